# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One solve, many results: variations, placed defects, the mesh of the quads that are shown."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError, SynchError
from synch_fields.core.solution import COARSE, Options
from synch_fields.core.solve import solve
from synch_fields.core.tasks.surfaces import SurfaceRequest
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.translations import translate
from synch_fields.synch_addon.jobs.queue import queue
from synch_fields.synch_addon.operators.variations import SYNCH_OT_place_defect
from synch_fields.synch_addon.patterns import memory
from synch_fields.synch_addon.patterns.found_again import DrawnVariationJob

from ..quad_meshes import corner_vertices
from ..scenes import attribute, empties, grid, make_active, places, quad_sphere, snapshot, sphere, torus

pytestmark = pytest.mark.full_search

SOLVES = {
    "stripes": lambda obj: api.stripes(obj, symmetry="line", spacing=0.5),
    "quads": lambda obj: api.quads(obj, spacing=0.7),
    "directions": lambda obj: api.directions(obj, symmetry="cross"),
}


def written_phases(obj):
    """Phases that the object shows, as unit numbers."""
    return np.exp(1j * attribute(obj, "synch_vertex_phase"))


@pytest.mark.parametrize("number", [0, 1, 500])
def test_a_variation_is_what_the_solve_holds(number):
    obj = sphere()
    api.stripes(obj, symmetry="vector", spacing=0.5)
    solution = memory.recall(obj).pattern.solution
    report = api.vary(obj, number)
    problem = memory.recall(obj).pattern.problem
    if number < len(solution.variations):
        expected = solution.variations[number]
    else:
        expected = solve(problem, Options(method=COARSE, seed=number)).phases
    shown = memory.recall(obj).pattern
    np.testing.assert_allclose(np.abs(np.vdot(expected, shown.phases)), len(expected), rtol=1e-9)
    np.testing.assert_allclose(np.cos(np.angle(shown.phases)), written_phases(obj).real, atol=1e-6)
    assert report["energy"] == pytest.approx(shown.energy) and report["energy"] >= report["lower_bound"]
    assert len(empties(obj, "dislocation")) == len(report["dislocations"])


@pytest.mark.parametrize("command", SOLVES)
def test_variations_come_back_to_the_solution(command):
    obj = sphere()
    before = SOLVES[command](obj)
    written = snapshot()["meshes"]
    assert api.vary(obj, 700)["energy"] != before["energy"]
    assert api.vary(obj, 0)["energy"] == pytest.approx(before["energy"])
    assert snapshot()["meshes"] == written


@pytest.mark.parametrize(("build", "command"), [(sphere, "quads"), (torus, "stripes"), (quad_sphere, "stripes")])
def test_a_placed_defect_is_in_a_face_at_the_vertex(build, command):
    obj = build()
    SOLVES[command](obj)
    names = ["synch_index"] if command == "stripes" else ["synch_index_x", "synch_index_y"]
    torn = "synch_disclination" if command == "stripes" else "synch_disclination_x"
    for vertex in np.linspace(0, len(obj.data.vertices) - 1, 4).astype(int).tolist():
        api.place_defects(obj, [vertex])
        faces = [face.index for face in obj.data.polygons if vertex in face.vertices]
        numbers = [attribute(obj, n)[faces] for name in names for n in (name, f"{name}_2") if n in obj.data.attributes]
        around = attribute(obj, torn)[faces] if torn in obj.data.attributes else np.zeros(1)
        assert np.any(numbers) or np.any(around), vertex


def test_what_a_defect_costs_is_told_before_the_click():
    obj = sphere()
    before = SOLVES["stripes"](obj)
    operator = SimpleNamespace(_foretold=None, _is_slow=False)
    surface = SimpleNamespace(vertex_at=lambda *ray: 11)
    line = SYNCH_OT_place_defect.foretell(operator, obj, surface, (None, None))
    assert SYNCH_OT_place_defect.foretell(operator, obj, surface, (None, None)) is None  # it is told already
    after = api.place_defects(obj, [11])
    ends = len(after["dislocations"]) - len(before["dislocations"])
    more = after["energy"] / before["energy"] - 1
    assert line == translate("Here: {ends:+} line ends, {more:+.1%} energy", ends=ends, more=more)


def test_what_was_shown_comes_back_as_it_was():
    obj = sphere()
    SOLVES["stripes"](obj)
    api.place_defects(obj, [5])
    shown, before = memory.recall(obj), snapshot()
    api.place_defects(obj, [40, 60])
    assert snapshot() != before
    api.show_again(obj, shown)
    assert snapshot() == before and memory.recall(obj).plain == shown.plain


@pytest.mark.parametrize(("build", "command"), [(sphere, "quads"), (torus, "stripes"), (quad_sphere, "stripes")])
def test_a_line_end_that_is_moved_lies_in_its_new_face(build, command):
    obj = build()
    SOLVES[command](obj)
    placed = api.place_defects(obj, [20])
    start = placed["dislocations"][0]["face"]
    taken = {defect["face"] for kind in ("disclinations", "dislocations") for defect in placed[kind]}
    middles = np.array([face.center for face in obj.data.polygons])
    apart = np.linalg.norm(middles - middles[start], axis=1)
    end = min((face for face in range(len(middles)) if face not in taken), key=lambda face: abs(apart[face] - 0.4))
    onto = memory.recall(obj)
    moved = api.move_defect(obj, start, end)
    faces = [defect["face"] for defect in moved["dislocations"]]
    assert end in faces and len(faces) <= len(placed["dislocations"])  # two may meet
    api.move_defect(obj, start, end, onto=onto)
    assert sorted(faces) == sorted(empty["synch_face"] for empty in empties(obj, "dislocation"))


def test_edits_after_one_another_come_back_from_what_is_kept_of_them():
    obj = sphere()
    SOLVES["stripes"](obj)
    api.vary(obj, 1)
    api.place_defects(obj, [5])
    api.place_defects(obj, [40])
    shown = memory.recall(obj)
    again = shown.compact().restored()
    np.testing.assert_allclose(again.pattern.phases, shown.pattern.phases)
    assert again.pattern.energy == pytest.approx(shown.plain["energy"]) and shown.number == 1


def test_a_line_end_that_is_not_there_cannot_be_moved():
    obj = sphere()
    report = SOLVES["stripes"](obj)
    taken = {defect["face"] for kind in ("disclinations", "dislocations") for defect in report[kind]}
    free = next(face for face in range(len(obj.data.polygons)) if face not in taken)
    bpy.context.view_layer.update()
    before = snapshot()
    for start, end, words in ((free, free, "not there any more"), (free, 10**6, "there is no face 1000000")):
        with pytest.raises(SettingError, match=words):
            api.move_defect(obj, start, end)
    assert snapshot() == before


def test_what_was_not_solved_has_no_variations():
    obj = sphere()
    for ask in (lambda: api.vary(obj, 1), lambda: api.place_defects(obj, [0]), lambda: api.trace_quads(obj)):
        with pytest.raises(SynchError, match="solve it first"):
            ask()
    SOLVES["stripes"](obj)
    bpy.context.view_layer.update()  # empties are where they were put
    before = snapshot()
    with pytest.raises(SettingError, match="whole number"):
        api.vary(obj, -1)
    with pytest.raises(SynchError, match="shows no quads"):
        api.trace_quads(obj)
    assert snapshot() == before
    obj.scale = (2, 2, 2)
    bpy.context.view_layer.update()
    with pytest.raises(SynchError, match="has changed since"):
        api.vary(obj, 1)


def test_the_mesh_of_the_quads_that_are_shown(monkeypatch):
    obj = torus()
    obj.synch.seed, obj.synch.smoothing = 5, 2
    # A quad mesh from scratch has the field of quads if nothing is its own: a guide, as free ones lie along the
    # curvature; curvature of every length; and a rounding, as with the default one directions need a smaller search.
    monkeypatch.setattr(SurfaceRequest, "_detail", 0.0)
    held = {"guidance": "axis:Z", "spacing": 0.4, "seed": 3, "rounding": "random"}
    api.quads(obj, **held)
    report = api.trace_quads(obj, smoothing=1)
    made = bpy.data.objects[report["quad_mesh"]["object"]]
    assert (made.synch.seed, made.synch.smoothing) == (5, 2) and '"quad_mesh"' in made.synch.result
    other = api.quad_mesh(obj, **held, smoothing=1, branching=1.0, singularities=1.0)
    again = bpy.data.objects[other["quad_mesh"]["object"]]
    np.testing.assert_array_equal(places(made), places(again))
    np.testing.assert_array_equal(corner_vertices(made), corner_vertices(again))

    make_active(obj)
    varied = api.vary(obj, 100)
    assert api.trace_quads(obj)["energy"] == pytest.approx(varied["energy"])


def test_the_operator_traces_what_the_object_shows():
    obj = grid()
    with pytest.raises(RuntimeError, match="solve it first"):
        bpy.ops.synch.trace_quads()
    api.quads(obj, spacing=0.7)
    assert bpy.ops.synch.trace_quads(smoothing=0) == {"FINISHED"}
    assert bpy.context.active_object.name == f"{obj.name} Quads" and obj.hide_get()


@pytest.mark.parametrize("method", ["spectral", "diffusion"])
def test_methods_without_a_lifted_field_say_that_they_do_not_vary(method):
    obj = sphere()
    api.stripes(obj, spacing=0.5, method=method)
    written, line = snapshot()["meshes"], obj.synch.result
    for name in ("draw_variation", "variation"):
        with pytest.raises(RuntimeError, match="only the semidefinite method finds variations"):
            getattr(bpy.ops.synch, name)()
    obj.synch_shown.variation = 50
    assert (obj.synch_shown.variation, obj.synch.result) == (0, line) and snapshot()["meshes"] == written
    assert memory.recall(obj).varies is False and api.isolines(obj)["lines"]
    assert len(api.place_defects(obj, [11])["dislocations"]) > 1


def test_the_slider_goes_back_where_the_mesh_has_changed_and_on_when_that_is_undone():
    obj = sphere()
    api.stripes(obj, spacing=0.5)
    obj.synch_shown.variation = 30
    bpy.ops.ed.undo_push(message="variation")
    obj.data.vertices[3].co *= 1.1
    bpy.ops.ed.undo_push(message="edit")
    obj.synch_shown.variation = 40
    assert obj.synch_shown.variation == 30
    with pytest.raises(RuntimeError, match="has changed since it was solved: solve it again"):
        bpy.ops.synch.draw_variation()
    assert obj.synch_shown.variation == 30
    bpy.ops.ed.undo()
    obj = bpy.context.active_object
    assert bpy.ops.synch.draw_variation() == {"FINISHED"} and obj.synch_shown.variation >= 100
    drawn = obj.synch_shown.variation
    bpy.ops.synch.variation(number=0)
    bpy.ops.synch.draw_variation(number=drawn)  # as the redo panel runs it again
    assert obj.synch_shown.variation == drawn
    assert memory.recall(obj).number == obj.synch_shown.variation


@pytest.mark.parametrize("command", SOLVES)
def test_a_variation_that_the_child_process_draws_is_that_of_its_number(command):
    obj = sphere()
    SOLVES[command](obj)
    api.vary(obj, 200)
    job = DrawnVariationJob(obj, [300])
    work = queue.add(job, "Draw Variation")
    while not work.is_over:
        queue.advance()
    drawn = job.write(work.result)
    assert (drawn["variation"], obj.synch_shown.variation) == (300, 300)
    assert api.vary(obj, 300)["energy"] == pytest.approx(drawn["energy"], rel=1e-9)
    assert drawn["more"] == pytest.approx(drawn["energy"] / api.vary(obj, 0)["energy"] - 1)
    stale = DrawnVariationJob(obj, [400])
    SOLVES[command](obj)
    with pytest.raises(SynchError, match="shows another solve than before: draw again"):
        stale.write(stale.request.solve())


def test_defects_are_not_placed_in_directions_alone():
    obj = sphere()
    SOLVES["directions"](obj)
    assert bpy.ops.synch.draw_variation() == {"FINISHED"}
    with pytest.raises(RuntimeError, match="defects are placed in stripes and quads: solve one of them first"):
        bpy.ops.synch.place_defect()
