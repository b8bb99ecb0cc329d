# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel of vortices: what it shows before and after a solve, and that the operator takes what it stores."""

import re
from types import SimpleNamespace
from unittest.mock import MagicMock

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.flows.chosen import flow_of
from synch_fields.synch_addon.flows.properties import VortexProperties
from synch_fields.synch_addon.jobs.queue import Work
from synch_fields.synch_addon.operators.clebsch import SYNCH_OT_clebsch
from synch_fields.synch_addon.panels.vortices import SYNCH_PT_vortex_result, SYNCH_PT_vortices

from ..scenes import make_active
from ..vortex_scenes import QUICK, write_npz, write_vdb


def drawn(panel):
    """The texts of the labels that a panel draws, and the names of its settings, all of which exist."""
    layout = MagicMock()
    panel.draw(SimpleNamespace(layout=layout), bpy.context)
    calls = [call for call in layout.mock_calls if call[0]]
    props = [call.args for call in calls if call[0].split(".")[-1] == "prop"]
    for owner, name in props:
        assert name in owner.bl_rna.properties
    return [call.kwargs["text"] for call in calls if call[0].endswith("label")], [name for _, name in props]


def estimated():
    """Nodes along the axes, seconds and megabytes that the panel tells."""
    lines = "\n".join(drawn(SYNCH_PT_vortices)[0])
    *shape, seconds, memory = map(
        int, re.search(r"(\d+) × (\d+) × (\d+) nodes\nAbout (\d+) s, (\d+) MB", lines).groups()
    )
    return shape, seconds, memory


def test_the_estimate_is_the_grid_that_is_solved(tmp_path):
    settings = bpy.context.scene.synch_vortices
    settings.resolution = 16
    settings.by, settings.quantum = "CIRCULATION", 1.0
    rough = {"resolution": 16, "method": "spectral"}
    assert not [text for text in drawn(SYNCH_PT_vortices)[0] if "nodes" in text]  # nothing is chosen
    settings.filepath = str(write_vdb(tmp_path / "ring.vdb"))
    solved = api.clebsch(settings.filepath, **rough)
    nodes = np.prod(solved["shape"])
    shape, seconds, memory = estimated()
    assert shape == solved["shape"] and memory == pytest.approx(nodes * 22e-3 / 1.049, abs=1)
    pace = Work._paces.get("Vortices", 1.0)
    assert seconds == pytest.approx(max(nodes * 2e-4 * pace, 1), abs=0.5)
    bpy.ops.object.volume_import(filepath=settings.filepath)
    settings.filepath = ""
    volume = bpy.context.active_object
    volume.rotation_euler.z = 0.3
    bpy.context.view_layer.update()
    assert estimated()[0] == api.clebsch(volume, **rough)["shape"]
    bpy.ops.curve.primitive_bezier_circle_add(location=(3, 0, 1), rotation=(0.4, 0, 0))
    curve = make_active(bpy.context.active_object)
    assert estimated()[0] == api.clebsch(curve, **rough)["shape"]


def about():
    """Seconds that the panel tells, None where it tells none."""
    found = re.search(r"About (\d+) s", "\n".join(drawn(SYNCH_PT_vortices)[0]))
    return None if found is None else int(found[1])


def test_sequences_and_surfaces_are_estimated_too(tmp_path, monkeypatch):
    monkeypatch.setattr(Work, "_paces", {"Vortices": 10.0})
    settings = bpy.context.scene.synch_vortices
    for frame in (1, 2):
        write_vdb(tmp_path / f"ring_{frame}.vdb")
    settings.resolution, settings.by, settings.quantum = 24, "CIRCULATION", 1.0
    settings.filepath = str(tmp_path / "ring_1.vdb")
    alone = estimated()
    settings.filepath, settings.use_frames, settings.frame_start = str(tmp_path / "ring_#.vdb"), True, 1
    settings.frame_end = 5
    shape, seconds, memory = estimated()
    assert (shape, memory) == (alone[0], alone[2]) and seconds == pytest.approx(4.2 * alone[1], rel=0.05)
    settings.frame_end = 0
    assert about() is None  # no frames
    settings.filepath, settings.use_frames = "", False
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=99, y_subdivisions=99)
    assert about() is None  # no flow
    flow = bpy.context.active_object.data.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
    flow.data.foreach_set("vector", np.ones(3 * 10_000, np.float32))
    told = about()
    assert told == pytest.approx(11, abs=1) and not [text for text in drawn(SYNCH_PT_vortices)[0] if "MB" in text]
    settings.by = "SHARE"  # which is searched for
    assert about() > 2 * told


def test_a_file_that_is_none_has_no_estimate(tmp_path):
    (tmp_path / "text.vdb").write_text("no volume")
    for name in ("text.vdb", "missing.vdb"):
        bpy.context.scene.synch_vortices.filepath = str(tmp_path / name)
        assert not [text for text in drawn(SYNCH_PT_vortices)[0] if "nodes" in text]


def test_settings_are_shown_where_they_count():
    settings = bpy.context.scene.synch_vortices
    bpy.context.view_layer.objects.active = None
    assert {"share", "smoothing", "shown_core", "attribute"} <= set(drawn(SYNCH_PT_vortices)[1])
    for add, counts in (
        (bpy.ops.curve.primitive_bezier_circle_add, "shown_core"),
        (bpy.ops.mesh.primitive_grid_add, "attribute"),
    ):
        add()
        assert {"shown_core", "attribute"} & set(drawn(SYNCH_PT_vortices)[1]) == {counts}
    bpy.ops.mesh.primitive_circle_add()  # edges without faces are filaments
    assert {"shown_core", "attribute"} & set(drawn(SYNCH_PT_vortices)[1]) == {"shown_core"}
    bpy.ops.object.select_all(action="DESELECT")
    bpy.ops.curve.primitive_bezier_circle_add()
    quick = {"resolution": 12, "quantum": 0.34, "target_gap": 0.5}
    report = api.clebsch([bpy.context.active_object], show="tubes", **quick)
    make_active(bpy.data.objects[report["object"]])  # what is solved again is the flow of the curve
    assert {"shown_core", "attribute"} & set(drawn(SYNCH_PT_vortices)[1]) == {"shown_core"}
    settings.by = "COUNT"
    assert {"count", "share"} & set(drawn(SYNCH_PT_vortices)[1]) == {"count"}
    settings.by, settings.show, settings.use_frames = "CIRCULATION", "TUBES", True
    settings.filepath = "smoke_####.vdb"
    shown = set(drawn(SYNCH_PT_vortices)[1])
    assert {"quantum", "opening", "frame_start", "frame_end"} <= shown
    assert not {"count", "shown_core"} & shown


def test_the_result_has_figures_and_the_choice(tmp_path):
    report = api.clebsch(write_npz(tmp_path / "ring.npz", circulation=4.0), show="both", **QUICK)
    tubes, lines = (bpy.data.objects[name] for name in report["objects"])
    for obj in (tubes, lines):
        make_active(obj)
        assert SYNCH_PT_vortex_result.poll(bpy.context)
        texts, settings = drawn(SYNCH_PT_vortex_result)
        assert f"Energy {report['energy']:.4g}" in texts and {"point", "opening", "smoothing"} <= set(settings)
        assert any("of the vorticity" in text for text in texts) and "90° N, 0° E" in texts
    lines.synch_vortices.point = (0, -1, 0)
    assert "0° N, 90° W" in drawn(SYNCH_PT_vortex_result)[0]
    bpy.ops.mesh.primitive_cube_add()
    assert not SYNCH_PT_vortex_result.poll(bpy.context)


def test_the_operator_takes_what_the_panel_stores():
    stored = bpy.context.scene.synch_vortices
    changed = {"filepath": "a.vdb", "show": "BOTH", "resolution": 33, "quantum": 2.5, "core": 1.5, "use_frames": True}
    for name, value in changed.items():
        setattr(stored, name, value)
    operator = SimpleNamespace()
    SYNCH_OT_clebsch._take(operator, bpy.context)
    assert vars(operator).keys() == VortexProperties.__annotations__.keys()
    assert {n: getattr(operator, n) for n in changed} == changed


def test_vortices_of_what_was_made_are_those_of_what_it_was_made_of():
    bpy.ops.curve.primitive_bezier_circle_add()
    circle = make_active(bpy.context.active_object)
    settings = {"resolution": 16, "by": "CIRCULATION", "quantum": 1.0, "target_gap": 0.05}
    assert bpy.ops.synch.clebsch(**settings) == {"FINISHED"}
    made = bpy.context.active_object
    assert made != circle and flow_of(bpy.context, "") == [circle]
    assert flow_of(bpy.context, "other.vdb") == "other.vdb"
    bpy.data.objects.remove(circle)
    assert flow_of(bpy.context, "") == [made]  # a curve like any other
