# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The list that an object keeps: from the panel to the core, through files and undo, and what is refused."""

import json
import subprocess
import sys

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.settings.constraints import PLACES, WISHES, Constraint, wishes_at
from synch_fields.synch_addon import api
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.panels import constraints
from synch_fields.synch_addon.settings.constraint_list import stored_constraints

from ..constraint_rows import OPERATORS, add_row, sheet
from ..scenes import add_curve, add_group, attribute, make_active, save_and_reopen, snapshot

# From the panel to the core


def test_rows_become_constraints():
    obj = sheet()
    curve = add_curve([(0, 0, 0), (1, 0, 0)], "Hem")
    add_row(obj, where="SEAMS", what="CUT")
    add_row(obj, where="GROUP", what="PHASE", vertex_group="collar", phase=np.pi / 2, angle=1.0)
    add_row(obj, where="CURVE", what="ANGLE", curve=curve, angle=np.radians(30), phase=1.0, soft=True, weight=2.5)
    add_row(obj, where="BOUNDARY", what="CONSTANT", soft=True, vertex_group="collar")
    add_row(obj, where="ATTRIBUTE", what="ACROSS", attribute="combed", enabled=False)
    add_row(obj, where="SHARP", what="ALONG", vertex_group="collar", angle=1.0, weight=3.0)
    assert stored_constraints(obj) == (
        Constraint("seams", "cut"),
        Constraint("group", "phase", "collar", 90.0),
        Constraint("curve", "angle", "Hem", 30.0, 2.5),
        Constraint("boundary", "constant", "collar"),
        Constraint("sharp", "along"),
    )
    curve.name = "Renamed"
    assert stored_constraints(obj)[2].name == "Renamed"


@pytest.mark.parametrize("where", [place.name for place in PLACES])
def test_only_what_is_possible_is_offered_and_kept(where):
    row = add_row(sheet())
    for what in (wish.name for wish in WISHES):
        row.where, row.what = "SEAMS", what.upper()
        row.where = where.upper()
        possible = what in wishes_at(where)
        assert row.what == (what if possible else "along").upper()
        name = "x" if where in ("group", "curve", "attribute") else ""
        if possible:
            Constraint(where, what, name)
        else:
            with pytest.raises(SettingError, match=f"{what} is impossible: use one of along, across, angle, phase"):
                Constraint(where, what, name)


@pytest.mark.parametrize("operator", OPERATORS)
def test_operators_follow_the_list_of_the_object(operator):
    obj = sheet()
    row = add_row(obj, where="SEAMS", what="ANGLE", angle=np.radians(40))
    assert getattr(bpy.ops.synch, operator)() == {"FINISHED"}
    expected = np.array([-np.sin(np.radians(40)), np.cos(np.radians(40)), 0])
    np.testing.assert_allclose(np.abs(attribute(obj, "synch_direction") @ expected), 1, atol=1e-5)
    row.enabled = False
    add_row(obj, where="SEAMS", what="ACROSS")
    assert getattr(bpy.ops.synch, operator)("INVOKE_DEFAULT") == {"FINISHED"}
    np.testing.assert_allclose(np.abs(attribute(obj, "synch_direction")[:, 0]), 1, atol=1e-5)


def test_a_list_that_is_given_replaces_the_stored_one():
    obj = sheet()
    add_row(obj, where="SEAMS", what="ALONG")
    for given, component in (
        (None, 1),
        ([{"where": "seams", "what": "across"}], 0),
        ([Constraint("seams", "along")], 1),
    ):
        report = api.stripes(obj, spacing=0.4, constraints=given)
        np.testing.assert_allclose(np.abs(attribute(obj, "synch_direction")[:, component]), 1, atol=1e-5)
        (row,) = json.loads(json.dumps(report))["settings"]["constraints"]
        assert row == report["settings"]["constraints"][0]
        assert row == {
            "where": "seams",
            "what": "along" if component else "across",
            "name": "",
            "degrees": 0.0,
            "weight": None,
        }
        again = api.directions(obj, constraints=report["settings"]["constraints"])
        assert again["settings"]["constraints"] == report["settings"]["constraints"]
    assert api.stripes(obj, spacing=0.4, constraints=[])["settings"]["constraints"] == []
    assert len(obj.synch.constraints) == 1


# Rows are added, moved and removed


def test_rows_are_added_moved_and_removed():
    obj = sheet()
    stored = obj.synch
    for where in ("SEAMS", "SHARP", "CREASES"):
        add_row(obj, where=where)

    def order():
        return [row.where for row in stored.constraints], stored.active_constraint

    assert order() == (["SEAMS", "SHARP", "CREASES"], 2)
    assert bpy.ops.synch.constraint_move(direction="DOWN") == {"CANCELLED"}
    assert bpy.ops.synch.constraint_move(direction="UP") == {"FINISHED"}
    assert order() == (["SEAMS", "CREASES", "SHARP"], 1)
    bpy.ops.synch.constraint_remove()
    assert order() == (["SEAMS", "SHARP"], 1)
    bpy.ops.synch.constraint_remove()
    bpy.ops.synch.constraint_remove()
    assert order() == ([], 0)
    assert not bpy.ops.synch.constraint_remove.poll() and not bpy.ops.synch.constraint_move.poll()
    assert bpy.ops.synch.constraint_add.poll()
    make_active(add_curve([(0, 0, 0), (1, 0, 0)]))
    assert not bpy.ops.synch.constraint_add.poll() and not constraints.SYNCH_PT_constraints.poll(bpy.context)


def test_adding_and_removing_can_be_undone():
    sheet()
    bpy.ops.ed.undo_push(message="sheet")
    for what in ("along", "across"):
        bpy.ops.synch.constraint_add()
        bpy.context.active_object.synch.constraints[-1].what = what.upper()
        bpy.ops.ed.undo_push(message=what)
    bpy.ops.synch.constraint_remove()
    bpy.ops.ed.undo_push(message="remove")

    def wishes():
        return [row.what for row in bpy.context.active_object.synch.constraints]

    assert wishes() == ["ALONG"]
    for expected in (["ALONG", "ACROSS"], ["ALONG"], []):
        bpy.ops.ed.undo()
        assert wishes() == expected
    bpy.ops.ed.redo()
    assert wishes() == ["ALONG"]


def test_undo_of_a_run_leaves_the_list():
    obj = sheet()
    add_row(obj, where="SEAMS", what="ACROSS")
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.synch.stripes()
    bpy.ops.ed.undo_push(message="stripes")
    bpy.ops.ed.undo()
    obj = bpy.context.active_object
    assert "synch_phase" not in obj.data.attributes
    assert stored_constraints(obj) == (Constraint("seams", "across"),)


# Files and copies


def furnished():
    """A sheet with rows of several kinds, and its curve."""
    obj = sheet()
    add_group(obj, "some", range(4))
    curve = add_curve([(-0.5, -0.6, 0), (0.3, 0.6, 0)], "Slant")
    make_active(obj)
    add_row(obj, where="CURVE", what="PHASE", curve=curve, phase=np.pi)
    add_row(obj, where="GROUP", what="ALONG", vertex_group="some", soft=True, weight=0.5)
    add_row(obj, where="SEAMS", what="CUT", enabled=False)
    return obj


EXPECTED = (Constraint("curve", "phase", "Slant", 180.0), Constraint("group", "along", "some", 0.0, 0.5))


def test_the_list_is_saved_and_loaded(tmp_path):
    furnished()
    obj = save_and_reopen(tmp_path / "list.blend", "Panel")
    assert stored_constraints(obj) == EXPECTED
    assert [row.enabled for row in obj.synch.constraints] == [True, True, False]
    assert obj.synch.active_constraint == 2


def test_the_list_is_appended_with_its_curve(tmp_path):
    furnished()
    path = tmp_path / "list.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.wm.append(directory=f"{path}/Object/", filename="Panel")
    obj = bpy.data.objects["Panel"]
    make_active(obj)
    assert stored_constraints(obj) == EXPECTED
    report = api.stripes(obj, spacing=0.4)
    along = np.array([0.8, 1.2, 0]) / np.hypot(0.8, 1.2)
    assert report["settings"]["constraints"][0]["name"] == "Slant"
    near = np.abs((attribute(obj, "position") - [-0.5, -0.6, 0]) @ [-along[1], along[0], 0]) < 0.1
    np.testing.assert_allclose(np.abs(attribute(obj, "synch_direction")[near] @ along), 1, atol=0.01)


def test_a_copy_has_a_list_of_its_own():
    obj = furnished()
    bpy.ops.object.duplicate()
    copy = bpy.context.active_object
    copy.synch.constraints[0].what = "ACROSS"
    copy.synch.constraints.remove(1)
    assert stored_constraints(obj) == EXPECTED
    assert [row.what for row in copy.synch.constraints] == ["ACROSS", "CUT"]


def test_a_deleted_curve_leaves_a_row_that_says_so():
    obj = furnished()
    make_active(bpy.data.objects["Slant"])
    bpy.ops.object.delete()
    make_active(obj)
    before = snapshot()
    with pytest.raises(RuntimeError, match="the constraint curve phase has no name: choose a curve object"):
        bpy.ops.synch.stripes()
    assert snapshot() == before and obj.synch.constraints[0].is_incomplete


# The command line


@pytest.fixture
def file(tmp_path):
    """A file whose sheet asks for stripes across its seams."""
    obj = sheet()
    add_row(obj, where="SEAMS", what="ACROSS")
    path = tmp_path / "sheet.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def run(capfd, *arguments):
    capfd.readouterr()
    status = main.main([str(a) for a in arguments])
    return status, capfd.readouterr().err


@pytest.mark.parametrize("command", OPERATORS)
def test_command_line_takes_the_stored_list_or_one_from_a_file(file, tmp_path, capfd, command):
    rows, report = tmp_path / "rows.json", tmp_path / "report.json"
    rows.write_text('[{"where": "seams", "what": "along"}]')
    for given, component in (((), 0), (("--constraints", rows), 1)):
        status, err = run(capfd, command, file, *given, "--report", report)
        assert status == 0, err
        found = attribute(bpy.data.objects["Panel"], "synch_direction")
        np.testing.assert_allclose(np.abs(found[:, component]), 1, atol=1e-5)
        (row,) = json.loads(report.read_text())["settings"]["constraints"]
        assert row["what"] == ("along" if component else "across")


def test_neither_the_api_nor_the_command_line_needs_registering(file, tmp_path):
    report = tmp_path / "report.json"
    script = (
        "import bpy; from synch_fields.synch_addon import api; bpy.ops.mesh.primitive_grid_add(); "
        "api.directions(bpy.context.object, constraints=[{'where': 'boundary', 'what': 'along'}]); "
        "print(api.directions(bpy.context.object)['settings']['constraints'], flush=True); "
        "import runpy; runpy.run_module('synch_fields', run_name='__main__')"
    )
    arguments = [sys.executable, "-c", script, "directions", str(file), "--report", str(report)]
    done = subprocess.run(arguments, capture_output=True, text=True)
    assert done.returncode == 0 and "[]" in done.stdout.splitlines(), done.stderr
    assert [row["what"] for row in json.loads(report.read_text())["settings"]["constraints"]] == ["across"]


@pytest.mark.parametrize(
    "text, message",
    [
        (
            '[{"where": "seams",\n "what" "cut"}]',
            "Expecting ':' delimiter: line 2 column 9 (char 28)): write a JSON list",
        ),
        ('{"where": "seams", "what": "cut"}', "the constraints are not a list: give a list of rows"),
        ('[{"where": "seams", "what": "cut"}, {"what": "cut"}]', "row 2 is {'what': 'cut'}: give it a 'where'"),
        ('[{"where": "seams", "what": "dance"}]', "row 1: the constraint seams dance has 'dance': use one of along"),
        (f'[{{"where": "seams", "what": "phase", "value": 1{"0" * 5000}}}]', "write a JSON list of rows"),
        ('[{"where": "\\ud800", "what": "along"}]', "has '\\ud800': use one of boundary"),
        (None, "No such file or directory"),
    ],
)
def test_a_file_of_rows_that_is_wrong_is_named_with_its_line_or_row(file, tmp_path, capfd, text, message):
    rows = tmp_path / "rows.json"
    if text is not None:
        rows.write_text(text)
    status, err = run(capfd, "stripes", file, "--constraints", rows)
    assert status == 1 and err.startswith(f"synch stripes: {rows}") and message in err
    assert err.count("\n") == 1


def test_command_line_prints_a_contradiction_in_one_line(file, tmp_path, capfd):
    rows = tmp_path / "rows.json"
    rows.write_text('[{"where": "seams", "what": "along"}, {"where": "seams", "what": "across"}]')
    status, err = run(capfd, "stripes", file, "--constraints", rows, "--quiet", "--output", tmp_path / "out.blend")
    assert status == 1
    (line,) = [line for line in err.splitlines() if "Read blend" not in line]  # what Blender says itself
    assert line.endswith("ask for different directions at vertices 4, 13, 22 and 3 more: remove one of them there")
    assert not (tmp_path / "out.blend").exists()
