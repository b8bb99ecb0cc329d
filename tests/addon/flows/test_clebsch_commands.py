# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the command and the operator take for a flow, and what they refuse."""

import json
import re

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.files.flows import flow_file
from synch_fields.synch_addon.blender import openvdb
from synch_fields.synch_addon.command.main import main
from synch_fields.synch_addon.flows import sources
from synch_fields.synch_addon.flows.job import clebsch

from ..vortex_scenes import circle, write_npz, write_vdb


def test_the_command_line(tmp_path, capfd):
    write_npz(tmp_path / "ring.npz")
    out, report = tmp_path / "out.blend", tmp_path / "report.json"
    arguments = ["clebsch", str(tmp_path / "ring.npz"), "--quantum", "1.3", "--quiet"]
    assert main([*arguments, "--output", str(out), "--report", str(report)]) == 0
    facts = json.loads(report.read_text())
    assert facts["command"] == "clebsch" and len(facts["filaments"]) == 1 and out.is_file()
    assert re.search(r"1 filament, 1 of them closed, with \d+% of the vorticity", capfd.readouterr().out)
    circle()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "curves.blend"))
    assert main(["clebsch", str(tmp_path / "curves.blend"), "--quantum", "1", "--resolution", "20", "--quiet"]) == 0
    assert main(["clebsch", str(tmp_path / "none.npz"), "--quiet"]) == 1
    assert "no such file" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"show": "smoke"}, "show 'smoke' is unknown"),
        ({"count": 0}, "the count is 0"),
        ({"quantum": 0}, "the quantum is 0.0: give a positive"),
        ({"quantum": "a"}, "the quantum is 'a': give a number"),
        ({"frames": (1,)}, r"the frames are \(1,\): give the first and the last"),
        ({"frames": 3}, "the frames are 3: give the first and the last"),
        ({"point": "abc"}, "the point of the sphere is 'abc': give three numbers"),
        ({"point": (float("inf"), 0, 0)}, "the point of the sphere is .* give three numbers"),
        ({"resolution": 4000}, r"the grid has 4000 x 4000 x 1\d+ nodes, which take about \d+ GB"),
        ({"resolution": "fine"}, "the resolution is 'fine'"),
        ({"core": -1}, "the core is -1.0: give a positive"),
        ({"opening": 200}, "to 179.9"),
        ({"point": (0, 0, 0)}, "three numbers that are not all 0"),
        ({"show": "tubes", "method": "spectral"}, "use the method sdp"),
        ({"resolution": 3}, "the resolution is 3: give a whole number from 8"),
        ({"colour": 1}, "'colour' is unknown"),
    ],
)
def test_settings_out_of_range_are_refused(settings, message):
    obj = circle()
    with pytest.raises(SettingError, match=message):
        clebsch(obj, **settings)
    assert len(bpy.data.objects) == 1


@pytest.mark.parametrize("far", [2**30, -(2**31)])
def test_voxels_too_far_for_the_library_are_refused(tmp_path, far):
    """It ends the process when it copies them."""
    vdb = openvdb.openvdb_module()
    volume = vdb.Vec3SGrid()
    volume.name = "velocity"
    volume.fill((far, 0, 0), (far + 9, 9, 9), (0.5, 0.2, 0.1))
    vdb.write(str(tmp_path / "far.vdb"), [volume])
    with pytest.raises(SettingError, match="velocity has voxels too far from its origin: move them nearer"):
        flow_file(tmp_path / "far.vdb", module=openvdb.module_file()).read()


def test_the_command_finds_the_only_flow_of_a_file(tmp_path, capfd):
    def run(name, *more):
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / name))
        arguments = [str(tmp_path / name), "--quantum", "1", "--resolution", "16", "--method", "spectral", "--quiet"]
        capfd.readouterr()
        return main(["clebsch", *arguments, *more]), capfd.readouterr()

    circle()
    clebsch(circle(location=(0, 0, 0.4)), resolution=16, quantum=1.0, method="spectral")
    both = run("shown.blend")[1].out.splitlines()[0]
    assert both == run("same.blend", "--object", "Circle", "Circle.001")[1].out.splitlines()[0]
    assert both != run("first.blend", "--object", "Circle")[1].out.splitlines()[0]
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
    ball = bpy.context.active_object
    turning = np.cross([0, 0, 1], [vertex.co for vertex in ball.data.vertices]).astype(np.float32)
    ball.data.attributes.new("velocity", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", turning.ravel())
    name = ball.name  # in the user's language
    status, said = run("several.blend")
    assert status == 1 and f"several flows ({name}, Circle, Circle.001)" in said.err
    for other in ("Circle", "Circle.001"):
        bpy.data.objects.remove(bpy.data.objects[other])
    status, said = run("ball.blend")
    assert status == 0 and said.out.startswith(f"clebsch on {name}")
    bpy.data.objects.remove(bpy.data.objects[name])
    status, said = run("none.blend")
    assert status == 1 and "nothing in the file is a flow (it has Circle.001 Filaments" in said.err


def test_what_gives_no_flow_is_refused_in_one_line(tmp_path):
    obj = circle()
    for source in (None, 3, [], [obj, "Circle"]):
        with pytest.raises(SettingError, match="is not a flow: give a file"):
            clebsch(source)
    obj[sources.STRENGTH] = "strong"
    with pytest.raises(SettingError, match="Circle: its synch_strength is 'strong': give the circulation"):
        clebsch(obj)
    bpy.ops.object.volume_import(filepath=str(write_vdb(tmp_path / "ring.vdb")))
    volume = bpy.context.active_object
    volume.scale.y, volume.rotation_euler.x = 0.0, 0.3
    bpy.context.view_layer.update()
    with pytest.raises(SettingError, match="scaled to nothing along an axis"):
        clebsch(volume)


def test_the_operator_takes_the_selected_curves():
    obj = circle()
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    assert bpy.ops.synch.clebsch(resolution=20, count=1) == {"FINISHED"}
    assert bpy.context.active_object.type == "CURVE" and bpy.context.active_object != obj
    for other in bpy.data.objects:
        other.select_set(False)
    bpy.context.view_layer.objects.active = None  # beside a result, what it was made of is solved again
    with pytest.raises(RuntimeError, match="nothing has a flow"):
        bpy.ops.synch.clebsch()
