# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How much lines branch and directions have singular points: in Python, the panel, on the command line, in frames, and
in what is read back from a file."""

import json
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import meshes
from synch_fields.synch_addon.frames.job import AnimationJob, Span
from synch_fields.synch_addon.operators.quads import SYNCH_OT_quad_mesh, SYNCH_OT_quads
from synch_fields.synch_addon.patterns import favourites, memory
from synch_fields.synch_addon.patterns.job import FieldJob
from synch_fields.synch_addon.patterns.read_back import read_back

from ..moving_meshes import moving, stored_frames, swaying, turned
from ..run_commands import run
from ..scenes import add_group, attribute, bent, empties, grid, quad_sphere, sphere


def hills():
    """A square with hills, on which even lines branch."""
    obj = bent(grid(24))
    obj.data.vertices.foreach_set("co", (attribute(obj, "position") * [1, 1, 6]).ravel())
    obj.data.update()
    return obj


def lumps():
    """A ball with lumps, on which crosses have more singular points than the eight that it needs."""
    obj = sphere(3)
    points = attribute(obj, "position").astype(float)
    grown = 1 + np.sin(6 * points).mean(axis=1, keepdims=True) / 2
    obj.data.vertices.foreach_set("co", (points * grown).ravel())
    obj.data.update()
    return obj


def counts(report):
    return {kind: len(report[kind]) for kind in ("disclinations", "dislocations")}


# What they do


@pytest.mark.parametrize("command", ["stripes", "quads"])
def test_lines_branch_less_and_spacing_varies_more(command):
    obj = lumps()
    reports = [getattr(api, command)(obj, spacing=0.2, branching=share) for share in (1, 0.5, 0)]
    dislocations = [len(report["dislocations"]) for report in reports]
    assert dislocations[0] > dislocations[1] >= dislocations[2] == 0
    spreads = [np.ptp(report["evenness"]["spacing"]) for report in reports]
    assert spreads[2] > spreads[0]
    assert [report["settings"]["branching"] for report in reports] == [1, 0.5, 0]


@pytest.mark.parametrize("command", ["directions", "quads"])
def test_directions_have_fewer_singular_points(command):
    obj = lumps()
    solve = getattr(api, command)
    found = [solve(obj, spacing=0.4, symmetry="cross", singularities=share)["disclinations"] for share in (1, 0)]
    assert len(found[0]) > len(found[1]) == 8


def test_what_is_not_asked_for_is_everything_but_in_quad_meshes():
    obj = hills()
    for command, branching, singularities in (
        ("stripes", 1.0, 1.0),
        ("quads", 1.0, 1.0),
        ("quad_mesh", 0.0, 0.9),
        ("directions", None, 1.0),
    ):
        settings = FieldJob(command, obj, SurfaceSettings(spacing=0.2)).request.settings
        assert (settings.branching, settings.singularities) == (branching, singularities)
    obj = lumps()
    report = api.quad_mesh(obj, spacing=0.2)
    assert (report["settings"]["branching"], report["settings"]["singularities"]) == (0, 0.9)
    assert report["dislocations"] == []
    assert report["quad_mesh"]["quad_share"] == 1
    more = api.quad_mesh(obj, spacing=0.2, branching=1.0, singularities=1.0)
    assert more["quad_mesh"]["quad_share"] < 1 and len(more["dislocations"]) > 0
    fewest = api.quad_mesh(obj, spacing=0.2, singularities=0.0)["disclinations"]
    assert len(more["disclinations"]) >= len(report["disclinations"]) > len(fewest) == 8


def test_only_fewer_singularities_than_usual_are_warned_of_along_given_directions():
    """A quad mesh along directions that are taken as they are says nothing of its own default."""
    obj = lumps()
    api.directions(obj, symmetry="cross")
    along = {"spacing": 0.4, "guidance": "attribute:synch_direction"}
    for share, warned in ((None, False), (0.9, False), (0.5, True)):
        report = api.quad_mesh(obj, singularities=share, **along)
        assert any("with all their singular points" in line for line in report["warnings"]) == warned


# Where they are set


def test_the_panel_has_them_in_percent():
    obj = hills()
    given = {"branching": 30, "singularities": 50, "mesh_branching": 80, "mesh_singularities": 20}
    for name, value in given.items():
        setattr(obj.synch, name, value)
    for kind, expected in ((SYNCH_OT_quads, (0.3, 0.5)), (SYNCH_OT_quad_mesh, (0.8, 0.2))):
        properties = SimpleNamespace(is_property_set=lambda name: False, property_unset=lambda name: None)
        operator = SimpleNamespace(properties=properties, stored_as=kind.stored_as, spacing=0.1)
        kind._take(operator, bpy.context)
        settings = kind._settings(operator)
        assert (settings.branching, settings.singularities) == expected
    api.quad_mesh(obj, spacing=0.3)
    made = bpy.context.active_object.synch
    # The mesh keeps what it was made with; the rest is as on its source.
    assert {name: getattr(made, name) for name in given} == given | {"mesh_branching": 0, "mesh_singularities": 90}


def test_operators_have_the_defaults_of_what_they_make():
    assert bpy.ops.synch.stripes.get_rna_type().properties["branching"].default == 100
    assert bpy.ops.synch.quad_mesh.get_rna_type().properties["branching"].default == 0
    assert bpy.ops.synch.quads.get_rna_type().properties["singularities"].default == 100
    assert bpy.ops.synch.quad_mesh.get_rna_type().properties["singularities"].default == 90
    obj = hills()
    assert bpy.ops.synch.quads(spacing=0.2, branching=30, singularities=50) == {"FINISHED"}
    settings = json.loads(obj.synch.result)["settings"]
    assert (settings["branching"], settings["singularities"]) == (0.3, 0.5)
    assert bpy.ops.synch.quad_mesh(spacing=0.2) == {"FINISHED"}
    settings = json.loads(bpy.context.active_object.synch.result)["settings"]
    assert (settings["branching"], settings["singularities"]) == (0, 0.9)
    assert (obj.synch.mesh_branching, obj.synch.mesh_singularities) == (0, 90)


def test_the_command_line_has_them(tmp_path, capfd):
    obj = lumps()
    expected = counts(api.quads(obj, spacing=0.3, branching=0.5, singularities=0.5))
    path, report = tmp_path / "hills.blend", tmp_path / "report.json"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    flags = ["--spacing", 0.3, "--singularities", 0.5, "--report", report, "--quiet"]
    assert run(capfd, "quads", path, "--branching", 0.5, *flags)[0] == 0
    found = json.loads(report.read_text())
    assert counts(found) == expected
    assert (found["settings"]["branching"], found["settings"]["singularities"]) == (0.5, 0.5)
    assert run(capfd, "quad_mesh", path, *flags)[0] == 0
    assert json.loads(report.read_text())["settings"]["branching"] == 0
    assert run(capfd, "quad_mesh", path, *flags[:2], *flags[4:])[0] == 0
    assert json.loads(report.read_text())["settings"]["singularities"] == 0.9
    assert run(capfd, "directions", path, "--symmetry", "cross", "--singularities", 0, *flags[-3:])[0] == 0
    assert len(json.loads(report.read_text())["disclinations"]) == 8
    status, _, err = run(capfd, "directions", path, "--branching", 0)
    assert status == 2 and "unrecognized arguments: --branching" in err


def test_the_command_line_refuses_what_is_no_share(tmp_path, capfd):
    sphere()
    path = tmp_path / "ball.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    status, _, err = run(capfd, "stripes", path, "--branching", 30, "--quiet")
    assert status == 1 and "branching is 30.0: give a share from 0 to 1" in err


# Frames


def test_frames_have_them():
    obj = swaying(hills(), 2)
    job = AnimationJob(obj, SurfaceSettings(spacing=0.2, branching=0.25, singularities=0.5), Span(1, 2))
    while job.advance() is not None:
        pass
    assert [(r.settings.branching, r.settings.singularities) for r in job.request.requests] == [(0.25, 0.5)] * 2
    report = api.animate(obj, frames=(1, 2), pattern="quads", spacing=0.2, branching=0.0, singularities=0.0)
    assert [(f["dislocations"], f["disclinations"]) for f in report["frames"]] == [(0, 0)] * 2
    assert stored_frames(obj) == [1, 2] and report["settings"]["branching"] == 0
    assert "synch_spacing_error" not in obj.data.attributes


def test_a_mesh_that_turns_keeps_its_calmed_phases():
    obj = hills()
    points = attribute(obj, "position").astype(float)
    moving(obj, [turned(points, angle) for angle in (0, 0.7)])
    settings = {"spacing": 0.3, "branching": 0.3, "singularities": 0.3}
    report = api.animate(obj, frames=(1, 2), pattern="quads", **settings)
    assert report["frames"][1]["change"] < 1e-3


# What is read back


def dislocations(pattern):
    return sorted((d.triangle, d.index, d.phase) for d in pattern.dislocations)


ROWS = [{"where": "group", "name": "line", "what": "phase"}]
READ_BACK = {
    "stripes": ("stripes", {}),
    "stripes with lines": ("stripes", {"boundary": "phase"}),
    "mirrored stripes": ("stripes", {"mirror": "X"}),
    "stripes along an attribute": ("stripes", {"guidance": "attribute:kept"}),
    "quads": ("quads", {}),
    "turned quads": ("quads", {"angle": 0.4}),
    "quads with lines": ("quads", {"boundary": "phase"}),
    "quads on a row": ("quads", {"constraints": ROWS}),
    "mirrored quads": ("quads", {"mirror": "XY", "boundary": "along"}),
}


SHARES = [(1.0, 1.0), (1.0, 0.5), (0.3, 1.0), (0.0, 1.0)]


@pytest.mark.parametrize(
    ("name", "branching", "singularities"),
    [
        *((name, 0.3, 0.5) for name in READ_BACK),
        *(("stripes", *shares) for shares in SHARES[::2]),
        *(("quads", *shares) for shares in SHARES[1::2]),
    ],
)
def test_dislocations_that_are_read_back_are_those_that_were_solved(name, branching, singularities):
    command, more = READ_BACK[name]
    obj = hills()
    add_group(obj, "line", [v.index for v in obj.data.vertices if abs(v.co.x) < 1e-3])
    obj.data.attributes.new("kept", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", [1.0, 0.5, 0] * 625)
    getattr(api, command)(obj, spacing=0.2, branching=branching, singularities=singularities, **more)
    solved = memory.recall(obj)
    with meshes.object_mode(obj):
        *_, field, pattern = read_back(obj, obj.synch.result)
    assert dislocations(pattern) == dislocations(solved.pattern)
    np.testing.assert_allclose(pattern.edge_phases.changes, solved.pattern.edge_phases.changes, atol=1e-3)
    np.testing.assert_allclose(field.scale, solved.field.scale, rtol=1e-5)


def test_settings_without_them_are_those_of_before():
    obj = hills()
    api.stripes(obj, spacing=0.2)
    result = json.loads(obj.synch.result)
    before = dislocations(memory.recall(obj).pattern)
    for name in ("branching", "singularities"):
        del result["settings"][name]
    memory.forget(obj)
    with meshes.object_mode(obj):
        settings, *_, pattern = read_back(obj, json.dumps(result))
    assert (settings.branching, settings.singularities) == (1, 1)
    assert dislocations(pattern) == before


@pytest.mark.parametrize("command", ["stripes", "quads"])
def test_a_favourite_of_another_branching_comes_back_with_it(command):
    obj = hills()
    solve = getattr(api, command)
    solve(obj, spacing=0.2, branching=0.0)
    favourites.keep(obj, "calm")
    solve(obj, spacing=0.2)
    assert empties(obj, "dislocation")
    favourites.show(obj, "calm")
    assert empties(obj, "dislocation") == [] and json.loads(obj.synch.result)["settings"]["branching"] == 0


# How even it is


def test_evenness_is_in_the_report_and_at_the_object():
    obj = quad_sphere(9)
    report = api.quads(obj, spacing=0.5)
    evenness = report["evenness"]
    assert evenness == memory.recall(obj).pattern.evenness.figures == json.loads(obj.synch.result)["evenness"]
    assert len(evenness["spacing"]) == len(evenness["angles"]) == 5
    assert "evenness" not in api.directions(obj)
    lower = api.vary(obj, 0)
    assert lower["command"] == "directions"
    made = api.quad_mesh(obj, spacing=0.5)
    assert made["evenness"]["off_share"] >= 0


def test_errors_of_faces_are_means_of_their_triangles_and_go_with_the_pattern():
    obj = quad_sphere(9)
    api.stripes(obj, spacing=0.3)
    errors = attribute(obj, "synch_spacing_error")
    solved = memory.recall(obj)
    expected = solved.pattern.evenness.errors.reshape(-1, 2).mean(axis=1)
    np.testing.assert_allclose(errors, expected, atol=1e-6)
    assert np.abs(errors).max() > 0.1
    api.vary(obj, 7)
    assert not np.array_equal(attribute(obj, "synch_spacing_error"), errors)
