# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking from the window: map after map, so that it is drawn in between, and cancelled without a trace."""

import gc
import time
from dataclasses import replace
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from synch_fields.core.settings.bake import BakeSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.bakes import other_process
from synch_fields.synch_addon.bakes.job import BakeJob
from synch_fields.synch_addon.bakes.other_process import OtherProcess
from synch_fields.synch_addon.jobs.queue import queue
from synch_fields.synch_addon.operators.bake import SYNCH_OT_bake
from synch_fields.synch_addon.operators.field_operator import BackgroundOperator

from ..event_loop import Recorded, begun
from ..scenes import attribute, snapshot, sphere

MAPS = ("mask", "height", "phase")


class Bake(Recorded, BackgroundOperator):
    """The operator as the window runs it, without being one of Blender's."""

    bl_label = "Bake"
    _headline, _elsewhere = SYNCH_OT_bake._headline, False

    def __init__(self, elsewhere=False, **settings):
        super().__init__()
        self._elsewhere = elsewhere
        self.settings = BakeSettings(maps=MAPS, size=32, samples=1, unwrap=True, **settings)

    def _job(self, context):
        return BakeJob(context.active_object, self.settings, self._elsewhere)


@pytest.fixture
def striped():
    obj = sphere()
    for layer in list(obj.data.uv_layers):
        obj.data.uv_layers.remove(layer)
    api.stripes(obj, spacing=0.5, method="spectral")
    return obj


def everything():
    return snapshot(), sorted(image.name for image in bpy.data.images), sorted(scene.name for scene in bpy.data.scenes)


def files(folder):
    return sorted(path.name for path in folder.iterdir())


def test_pieces_are_named_before_they_are_done_and_nothing_is_left_in_between(striped, tmp_path):
    before = everything()
    loop, operator = begun(Bake(folder=str(tmp_path)))
    seen = []
    while loop.send(operator, "TIMER") == {"RUNNING_MODAL"}:
        seen.append(operator._work.stage)
        assert everything() == before
    assert seen == ["unwrap", "mask", "phase", "write"]
    assert queue.running is None and loop.timers == 0 and operator.reports[-1][0] == {"INFO"}
    assert len(files(tmp_path)) == 3 and "Synch Bake" in striped.data.uv_layers


def test_files_are_those_of_a_script(striped, tmp_path):
    for name in ("window", "script"):
        (tmp_path / name).mkdir()
    loop, operator = begun(Bake(folder=str(tmp_path / "window"), naming="{map}"))
    assert loop.run(operator) == {"FINISHED"}
    maps = {"maps": MAPS, "size": 32, "samples": 1, "naming": "{map}"}
    api.bake(striped, folder=str(tmp_path / "script"), uv_map="Synch Bake", **maps)
    assert files(tmp_path / "window") == files(tmp_path / "script")
    for name in files(tmp_path / "window"):
        images = [bpy.data.images.load(str(tmp_path / kind / name)) for kind in ("window", "script")]
        assert images[0].pixels[:] == images[1].pixels[:]


def test_another_process_bakes_the_same_while_the_window_goes_on(striped, tmp_path):
    maps = ("mask", "colour", "height", "normal", "phase", "index")
    loops = []
    for elsewhere in (True, False):
        before = everything()
        folder = tmp_path / str(elsewhere)
        folder.mkdir()
        bake = Bake(elsewhere, folder=str(folder), naming="{map}")
        bake.settings = replace(bake.settings, maps=maps)
        loop, operator = begun(bake)
        loops.append(0)
        while loop.send(operator, "TIMER") == {"RUNNING_MODAL"}:
            loops[-1] += 1
            assert everything() == before
            if elsewhere:
                time.sleep(0.02)
        assert operator.reports[-1][0] == {"INFO"}
    assert loops[0] > loops[1] + 5
    for name in maps:
        images = [bpy.data.images.load(str(tmp_path / kind / f"{name}.png")) for kind in ("True", "False")]
        assert images[0].pixels[:] == images[1].pixels[:], name


def test_images_with_unsaved_changes_are_baked_as_they_are(tmp_path):
    """A file, from which another process could read them, does not have the changes."""
    obj = sphere()
    api.stripes(obj, spacing=0.5, method="spectral")
    material, image = bpy.data.materials.new("Painted"), bpy.data.images.new("Painted", 4, 4)
    image.pixels.foreach_set(np.tile(np.array([0.2, 0.8, 0.4, 1], np.float32), 16))
    tree = bpy.data.node_groups.new("Texture", "ShaderNodeTree")
    tree.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    nodes = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("NodeGroupOutput")
    nodes[0].image = image
    tree.links.new(nodes[0].outputs[0], nodes[1].inputs[0])
    if material.node_tree is None:
        material.use_nodes = True
    own = material.node_tree
    group = own.nodes.new("ShaderNodeGroup")
    group.node_tree = tree
    own.links.new(group.outputs[0], own.nodes["Principled BSDF"].inputs["Base Color"])
    obj.data.materials[0] = material
    bake = Bake(True, folder=str(tmp_path), naming="{map}")
    bake.settings = replace(bake.settings, maps=("colour",))
    loop, operator = begun(bake)
    while loop.send(operator, "TIMER") == {"RUNNING_MODAL"}:
        time.sleep(0.02)
    pixels = np.array(bpy.data.images.load(str(tmp_path / "colour.png")).pixels).reshape(-1, 4)
    np.testing.assert_allclose(np.median(pixels, axis=0), [0.2, 0.8, 0.4, 1], atol=0.01)


def test_escape_ends_the_process_that_bakes(striped, tmp_path):
    before = everything()
    bake = Bake(True, folder=str(tmp_path))
    bake.settings = replace(bake.settings, size=1024, samples=64)
    loop, operator = begun(bake)
    for _ in range(5):
        loop.send(operator, "TIMER")
    child = next(o for o in gc.get_objects() if isinstance(o, OtherProcess))._child
    assert operator._work.stage == "mask" and child.poll() is None
    assert loop.send(operator, "ESC", "PRESS") == {"CANCELLED"}
    assert child.poll() is not None and everything() == before and files(tmp_path) == []


def test_a_process_that_fails_is_said_in_one_line(striped, tmp_path, monkeypatch):
    monkeypatch.setattr(other_process, "_PROGRAM", tmp_path / "missing.py")
    (tmp_path / "out").mkdir()
    loop, operator = begun(Bake(True, folder=str(tmp_path / "out")))
    while loop.send(operator, "TIMER") == {"RUNNING_MODAL"}:
        time.sleep(0.02)
    assert operator.reports[-1][0] == {"ERROR"} and "ended without an image (code 2)" in operator.reports[-1][1]
    assert files(tmp_path / "out") == []


@pytest.mark.parametrize("pieces", [0, 3])
def test_escape_between_two_maps_leaves_everything_as_it_was(striped, pieces, tmp_path):
    before = everything()
    loop, operator = begun(Bake(folder=str(tmp_path), material=True))
    for _ in range(pieces):
        assert loop.send(operator, "TIMER") == {"RUNNING_MODAL"}
    start = time.perf_counter()
    assert loop.send(operator, "ESC", "PRESS") == {"CANCELLED"}
    assert time.perf_counter() - start < 0.2
    assert everything() == before and files(tmp_path) == []
    ((kind, line),) = operator.reports
    assert kind == {"INFO"} and line.endswith(": cancelled: nothing was changed")  # after the object's name
    assert queue.running is None and loop.timers == 0


def test_opening_another_file_ends_the_bake(striped, tmp_path):
    loop, operator = begun(Bake(folder=str(tmp_path)))
    for _ in range(2):
        loop.send(operator, "TIMER")
    bpy.ops.wm.read_homefile(use_empty=True)
    operator.cancel(loop)
    assert queue.running is None and files(tmp_path) == [] and not bpy.data.objects


def test_bake_in_edit_mode_comes_back_to_it(striped, tmp_path):
    bpy.ops.object.mode_set(mode="EDIT")
    loop, operator = begun(Bake(folder=str(tmp_path)))
    loop.send(operator, "TIMER")
    assert loop.send(operator, "ESC", "PRESS") == {"CANCELLED"}
    assert striped.mode == "EDIT"


def test_no_solve_begins_while_a_bake_runs(striped, tmp_path):
    loop, operator = begun(Bake(folder=str(tmp_path)))
    assert not bpy.ops.synch.stripes.poll() and not bpy.ops.synch.bake.poll()
    loop.send(operator, "ESC", "PRESS")
    assert bpy.ops.synch.stripes.poll() and attribute(striped, "synch_phase").any()


def test_what_is_refused_is_said_in_one_line(striped, tmp_path):
    loop, operator = begun(Bake(folder=str(tmp_path / "missing")))
    assert loop.run(operator) == {"CANCELLED"}
    assert operator.reports[-1][0] == {"ERROR"} and "this folder does not exist" in operator.reports[-1][1]
    assert queue.running is None


def test_the_button_makes_a_uv_map_where_there_is_none(striped):
    operator = SimpleNamespace()
    SYNCH_OT_bake._take(operator, bpy.context)
    assert operator.unwrap and not bpy.context.scene.synch_bake.unwrap
    striped.data.uv_layers.new(name="Mine")
    SYNCH_OT_bake._take(operator, bpy.context)
    assert not operator.unwrap
