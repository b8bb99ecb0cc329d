# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad input, by operator and by command line: one line that names element and remedy, and nothing is written."""

import json

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.translations import operator_error
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.panels import overlay
from synch_fields.synch_addon.patterns import memory, write

from ...corpus.makers import moebius_strip
from ..scenes import add_group, add_object, grid, quad_sphere, set_vectors, snapshot, sphere, tube

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def empty_mesh():
    return add_object([], [])


def no_faces():
    return add_object(SQUARE, [])


def flat_face():
    return add_object([*SQUARE, (0.5, 0, 0)], [(0, 1, 2), (0, 2, 3), (0, 4, 1)])


def doubled_face():
    return add_object(SQUARE, [(0, 1, 2), (0, 2, 3), (1, 2, 0)])


def three_faces_at_an_edge():
    return add_object([*SQUARE, (0.5, 0.5, 1)], [(0, 1, 2), (0, 2, 3), (2, 0, 4)])


def bow_tie():
    return add_object([*SQUARE, (2, 1, 0), (2, 2, 0)], [(0, 1, 2), (0, 2, 3), (2, 4, 5)])


def flipped_face():
    return add_object(SQUARE, [(0, 1, 2), (0, 3, 2)])


def one_sided():
    return add_object(*moebius_strip())


def lost_coordinates():
    return add_object([(0, 0, 0), (float("nan"), 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)])


def broken_piece():
    piece = np.array([*SQUARE, (0.5, 0, 0)]) + (9, 0, 0)
    return add_object([*SQUARE, *piece], [(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7), (4, 8, 5)])


def no_scale():
    obj = sphere()
    obj.scale = (1, 0, 1)
    bpy.context.view_layer.update()
    return obj


def grouped():
    """A tube with a group on its rim, one inside and one without vertices."""
    obj = tube()
    add_group(obj, "inside", [30, 31, 32])
    add_group(obj, "nobody", [])
    return obj


def combed():
    """A flat square with a vector attribute on its faces, a scalar one, and one that points upwards."""
    obj = grid()
    set_vectors(obj, "on faces", np.ones((len(obj.data.polygons), 3)), "FACE")
    obj.data.attributes.new("scalar", "FLOAT", "POINT")
    set_vectors(obj, "upwards", np.tile((0, 0, 1), (len(obj.data.vertices), 1)))
    return obj


PHASE = {"boundary": "phase"}
STRICT = {"strict": True}
CASES = {
    "empty mesh": (empty_mesh, {}, "the mesh is empty", "add some geometry"),
    "no faces": (no_faces, {}, "the mesh has no faces", "fill"),
    "zero-area face": (flat_face, STRICT, "face 2 has no area", "Degenerate Dissolve"),
    "duplicate faces": (doubled_face, STRICT, "face 2 has the same corners", "Delete > Only Faces"),
    "non-manifold edge": (three_faces_at_an_edge, STRICT, "edge between vertices 0 and 2 has 3 faces", "keep two"),
    "bow-tie vertex": (bow_tie, STRICT, "vertex 2 has faces that touch only at this point", "Split"),
    "flipped face": (flipped_face, STRICT, "faces 0 and 1 at the edge between vertices 0 and 2", "Recalculate Outside"),
    "one-sided": (one_sided, STRICT, "the surface is one-sided at faces", "cut it open"),
    "not a number": (lost_coordinates, STRICT, "vertex 1 has no finite position", "delete it"),
    "broken piece": (broken_piece, STRICT, "face 4 has no area (in the piece of vertex 4, one of 2)", "Dissolve"),
    "zero scale": (no_scale, {}, "the scale of Icosphere is zero", "give it a scale"),
    "zero spacing": (sphere, {"spacing": 0.0}, "the spacing is 0", "give a positive number"),
    "negative spacing": (sphere, {"spacing": -0.1}, "the spacing is -0.1", "give a positive number"),
    "huge spacing": (sphere, {"spacing": 50.0}, "spacing 50 is larger than the object", "reduce it"),
    "no boundary": (sphere, PHASE, "the mesh has no boundary", "set the boundary to free"),
    "missing group": (grouped, PHASE | {"vertex_group": "rim"}, "no vertex group 'rim'", "one of its groups (in"),
    "empty group": (grouped, PHASE | {"vertex_group": "nobody"}, "vertex group 'nobody' is empty", "assign vertices"),
    "group inside": (grouped, PHASE | {"vertex_group": "inside"}, "vertex group holds no boundary edge", "add both"),
    "missing attribute": (
        combed,
        {"guidance": "attribute:wool"},
        "no attribute 'wool'",
        "choose a vector attribute (it has ",
    ),
    "attribute on faces": (
        combed,
        {"guidance": "attribute:on faces"},
        "FLOAT_VECTOR on FACE",
        "must be a vector on points",
    ),
    "scalar attribute": (combed, {"guidance": "attribute:scalar"}, "FLOAT on POINT", "must be a vector on points"),
    "upright attribute": (
        combed,
        {"guidance": "attribute:upwards"},
        "guidance vector of vertex 0",
        "tangential direction",
    ),
    "cross stripes": (sphere, {"symmetry": "cross"}, "stripes need a vector or line field", "set the symmetry"),
}


# The cases that the operator and the command line are asked, too.
ASKED_AGAIN = ["no faces", "huge spacing", "no boundary", "missing attribute"]


@pytest.mark.parametrize("name", CASES)
def test_python_is_refused_with_one_line(name):
    build, settings, element, remedy = CASES[name]
    obj = build()
    before = snapshot()
    with pytest.raises(SynchError) as refused:
        api.stripes(obj, **settings)
    message = str(refused.value)
    assert "\n" not in message and element in message and remedy in message
    assert repr(snapshot()) == repr(before)  # nan is not equal to itself


@pytest.mark.parametrize("name", ASKED_AGAIN)
def test_operator_is_cancelled_with_one_line(name):
    build, settings, element, remedy = CASES[name]
    obj = build()
    before = snapshot()
    values = {k: v.upper() if k in ("boundary", "symmetry") else v for k, v in settings.items()}
    with pytest.raises(RuntimeError) as refused:
        bpy.ops.synch.stripes(**values)
    message = operator_error(refused.value)
    assert "\n" not in message and element in message and remedy in message
    assert message.index(element) < message.index(remedy)
    assert snapshot() == before
    assert obj.mode == "OBJECT"


def test_operator_in_edit_mode_returns_there():
    obj = flat_face()
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(RuntimeError) as refused:
        bpy.ops.synch.stripes(spacing=-1)
    assert operator_error(refused.value) == f"{obj.name}: the spacing is -1.0: give a positive number"
    assert obj.mode == "EDIT"


@pytest.mark.parametrize("name", [*ASKED_AGAIN, "zero-area face"])
def test_command_line_fails_with_one_line_and_says_so_in_the_report(name, tmp_path, capfd):
    build, settings, element, remedy = CASES[name]
    build()
    source = tmp_path / "bad.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(source))
    flags = [f"--{key.replace('_', '-')}" + ("" if value is True else f"={value}") for key, value in settings.items()]
    outputs = [tmp_path / name for name in ("out.blend", "out.png", "out.json")]
    capfd.readouterr()
    status = main.main(
        ["stripes", str(source), *flags, "--quiet", "--output", str(outputs[0]), "--render", str(outputs[1])]
        + ["--report", str(outputs[2])]
    )
    printed = capfd.readouterr()
    assert status == 1
    assert printed.out == ""
    (line,) = [line for line in printed.err.splitlines() if line.startswith("synch stripes: ")]
    assert element in line and remedy in line
    report = json.loads(outputs[2].read_text())
    assert report["status"] == "failed" and report["command"] == "stripes"
    assert line == f"synch stripes: {report['error']}"
    assert not outputs[0].exists() and not outputs[1].exists()


@pytest.mark.parametrize("command", ["directions", "info"])
def test_other_commands_name_the_broken_element_too(command, tmp_path, capfd):
    flat_face()
    source = tmp_path / "bad.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(source))
    main.main([command, str(source)])
    printed = capfd.readouterr()
    assert "face 2 has no area" in printed.out + printed.err


def test_an_object_whose_solve_had_to_go_is_told_why():
    objects = [grid(2) for _ in range(memory.MOST + 1)]
    for obj in objects:
        api.directions(obj)
    with pytest.raises(SynchError, match=r"no solve in memory \(kept for the last 8 objects .*\): solve it first"):
        api.vary(objects[0], 1)
    memory.recall(objects[1])


def test_more_defects_than_blender_takes_objects_are_told_and_drawn_without_them(monkeypatch):
    monkeypatch.setattr(write, "MOST_EMPTIES", 3)
    obj = quad_sphere(5)
    report = api.stripes(obj, spacing=0.5)
    assert any("an empty for none of them" in warning for warning in report["warnings"])
    assert len(report["disclinations"]) > 3 and not obj.children
    assert sum(map(len, (points for points, _ in overlay.defect_points(obj)))) > 3
