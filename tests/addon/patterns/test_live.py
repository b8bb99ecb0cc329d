# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Live: what an object shows follows its settings."""

import time

import bpy
import numpy as np
import pytest

from synch_fields.core.process.ipc import pack_parts
from synch_fields.synch_addon.blender.pattern_surface import surface_of
from synch_fields.synch_addon.jobs.queue import queue
from synch_fields.synch_addon.patterns import guide_strokes, memory
from synch_fields.synch_addon.patterns import live as live_module
from synch_fields.synch_addon.patterns.job import FieldJob
from synch_fields.synch_addon.patterns.live import from_shown, live
from synch_fields.synch_addon.settings.fields import stored_settings

from ..scenes import attribute, empties, snapshot, sphere, tube
from .coarse_shapes import cube, half_body
from .live_steps import followed, settled, solve, striped


@pytest.fixture(autouse=True)
def _ends(monkeypatch):
    """Every test begins anew, and nothing settles but where a test lets it."""
    monkeypatch.setattr(live_module, "_REST", np.inf)
    live.clear()
    yield
    live.clear()
    for work in queue.works.copy():
        queue.cancel(work)


def add_row(obj, **values):
    row = obj.synch.constraints.add()
    for name, value in values.items():
        setattr(row, name, value)
    return row


def test_nothing_is_done_while_nothing_changes():
    obj = striped()
    before, shown = snapshot(), memory.state(obj)
    assert followed() == 0 and snapshot() == before and memory.state(obj) is shown


CHANGES = {"spacing": 0.404, "angle": np.radians(2), "branching": 90.0, "singularities": 80.0}


def uneven():
    """A sphere drawn out to an egg: on a round one there is no unevenness that singularities answer."""
    obj = sphere()
    for vertex in obj.data.vertices:
        vertex.co.z *= 1.6 if vertex.co.z > 0 else 0.8
    return obj


@pytest.mark.parametrize("name", CHANGES)
def test_a_changed_setting_is_followed_from_what_is_shown(name):
    obj = striped(uneven)
    before = attribute(obj, "synch_phase")
    setattr(obj.synch, name, CHANGES[name])
    assert followed() == 1 and live.error == ""
    after = attribute(obj, "synch_phase")
    change = np.abs(np.cos(after) - np.cos(before))
    assert change.max() > 1e-3 and change.mean() < 0.25
    solved = memory.recall(obj)
    wanted = CHANGES[name] / 100 if name in ("branching", "singularities") else CHANGES[name]
    assert getattr(solved.report.settings, name) == pytest.approx(wanted)
    assert followed() == 0


def test_the_strength_of_guidance_is_followed():
    obj = sphere()
    obj.synch.guidance = "BLEND"
    guide = obj.synch.guides.add()
    guide.kind, guide.axis, guide.strength = "AXIS", "Z", 0.1
    obj.synch.automatic_spacing, obj.synch.spacing = False, 0.4
    solve(obj)
    assert followed() == 0
    before = attribute(obj, "synch_direction")
    guide.strength = 10.0
    assert followed() == 1
    after, z = attribute(obj, "synch_direction"), np.array([0, 0, 1])
    assert np.abs(after @ z).mean() > np.abs(before @ z).mean() + 1e-3


def test_the_weight_of_a_constraint_is_followed():
    obj = tube()
    obj.synch.guidance, obj.synch.guide.axis = "AXIS", "Z"
    row = add_row(obj, where="BOUNDARY", what="ALONG", soft=True, weight=0.01)
    obj.synch.automatic_spacing, obj.synch.spacing = False, 0.4
    solve(obj)
    assert followed() == 0
    before = attribute(obj, "synch_direction")
    row.weight = 100.0
    assert followed() == 1
    assert np.abs(attribute(obj, "synch_direction") - before).max() > 0.05


def test_the_newest_value_wins_and_the_steps_between_are_not_kept(monkeypatch):
    obj, asked, add = striped(lambda: sphere(4)), [], queue.add
    monkeypatch.setattr(queue, "add", lambda job, *rest, **more: (asked.append(job), add(job, *rest, **more))[1])
    for step in range(1, 5):
        obj.synch.spacing = 0.4 * 1.01**step
        live.step(bpy.context)  # the first begins, and the others wait
    while followed():
        pass
    assert len(asked) == 2 and memory.state(obj).report.settings.spacing == pytest.approx(0.4 * 1.01**4)
    assert len(memory._fields.get(obj)._compact) == 2
    # Of what both have, nothing was told twice.
    assert len(b"".join(pack_parts(("solve", asked[1].request), asked[0].request.kept))) < 0.5 * len(
        b"".join(pack_parts(("solve", asked[1].request)))
    )


def test_what_takes_long_is_ended_for_what_is_asked_since(monkeypatch):
    monkeypatch.setattr(live_module, "_PATIENCE", 0.0)
    obj = striped(lambda: sphere(5))
    obj.synch.singularities = 60.0
    live.step(bpy.context)
    work, child = live._work, queue._worker.number
    obj.synch.singularities = 50.0
    assert followed() == 1
    assert work.result is None and str(work.error).startswith("cancelled") and queue._worker.number == child
    assert memory.state(obj).report.settings.singularities == 0.5


def test_quads_are_followed_too():
    obj = striped(command="quads")
    obj.synch.spacing = 0.405
    assert followed() == 1 and memory.state(obj).request.command == "quads"
    assert memory.state(obj).request.spacing == pytest.approx(0.405)


def test_what_cannot_be_is_said_once_and_changes_nothing():
    obj = striped()
    before = snapshot()
    obj.synch.spacing = 100.0
    assert followed() == 0 and "larger than the object" in live.error and snapshot() == before
    obj.synch.spacing = 0.41
    assert followed() == 1 and live.error == ""


def test_a_changed_mesh_is_refused_and_a_changed_symmetry_too():
    obj = striped()
    obj.synch.symmetry = "VECTOR"
    assert followed() == 0 and "symmetry" in live.error
    obj.synch.symmetry, obj.synch.spacing = "LINE", 0.41
    obj.data.vertices[0].co.x += 0.1
    assert followed() == 0 and "changed" in live.error


def test_small_steps_change_little_and_each_begins_where_the_last_one_ended():
    obj = striped(lambda: sphere(4), spacing=0.3)
    counts, changes = [len(empties(obj, "dislocation"))], []
    for step in range(1, 6):
        before = attribute(obj, "synch_phase")
        obj.synch.spacing = 0.3 * 1.01**step
        assert followed() == 1
        changes.append(np.abs(np.cos(attribute(obj, "synch_phase")) - np.cos(before)).mean())
        counts.append(len(empties(obj, "dislocation")))
    assert max(changes) < 0.15 and np.abs(np.diff(counts)).max() <= 2


@pytest.mark.parametrize("command", ["stripes", "quads"])
def test_after_a_rest_a_better_pattern_fades_in_and_is_proved(monkeypatch, command):
    obj = striped(lambda: sphere(4), command, spacing=0.3)
    for step in range(1, 9):
        obj.synch.spacing = 0.3 * 1.01**step
        assert followed() == 1
    shown, count = memory.state(obj), len(memory._fields.get(obj)._compact)
    monkeypatch.setattr(live_module, "_REST", 0.0)
    monkeypatch.setattr(live_module, "_FADE", 1.0)
    energies = settled()
    assert len(energies) > 3  # as it fades
    after = memory.state(obj)
    anew = FieldJob(command, obj, stored_settings(obj)).request.solve()
    assert after.plain["energy"] == energies[-1] == min(energies) < 0.9 * shown.plain["energy"]
    assert after.plain["energy"] < 1.15 * anew.pattern.energy and after.plain["certificate"] == "proved"
    np.testing.assert_allclose(attribute(obj, "synch_direction"), shown.field.vectors, atol=1e-5)
    assert len(memory._fields.get(obj)._compact) == count and followed() == 0


def test_a_new_pattern_is_solved_for_while_the_hand_rests_but_not_shown_before_it_has_rested(monkeypatch):
    obj = striped(lambda: sphere(4), spacing=0.3)
    for step in range(1, 9):
        obj.synch.spacing = 0.3 * 1.01**step
        assert followed() == 1
    shown, rest = memory.state(obj), 2.0
    monkeypatch.setattr(live_module, "_REST", rest)
    live._changed = time.monotonic()
    end = live._changed + rest
    while live._fade is None:
        live.step(bpy.context)
        assert memory.state(obj) is shown and time.monotonic() < end
        time.sleep(0.005)
    while memory.state(obj) is shown:
        live.step(bpy.context)
        time.sleep(0.005)
    assert end <= time.monotonic() < end + 5 and memory.state(obj).plain["energy"] != shown.plain["energy"]


def test_directions_settle_where_guides_have_turned_them(monkeypatch):
    obj = tube()
    obj.synch.guidance, obj.synch.guide.axis = "AXIS", "Z"
    row = add_row(obj, where="BOUNDARY", what="ALONG", soft=True, weight=0.01)
    obj.synch.automatic_spacing, obj.synch.spacing = False, 0.4
    solve(obj)
    row.weight = 100.0
    assert followed() == 1
    monkeypatch.setattr(live_module, "_REST", 0.0)
    settled()
    directions = memory.state(obj).plain["directions"]
    anew = FieldJob("stripes", obj, stored_settings(obj)).request.directed()
    assert directions["energy"] == pytest.approx(anew.energy, rel=0.01) and directions["certificate"] == "proved"


def test_a_new_setting_ends_what_settles(monkeypatch):
    obj = striped(lambda: sphere(4), spacing=0.3)
    obj.synch.spacing = 0.31
    assert followed() == 1
    monkeypatch.setattr(live_module, "_REST", 0.0)
    live.step(bpy.context)
    assert live._work is not None and live._work.job.request.settles
    obj.synch.spacing = 0.32
    assert followed() == 1 and memory.state(obj).report.settings.spacing == pytest.approx(0.32)


def test_what_a_click_has_solved_does_not_settle(monkeypatch):
    obj = striped(spacing=0.4)
    obj.synch.spacing = 0.41
    assert followed() == 1
    report = solve(obj)
    monkeypatch.setattr(live_module, "_REST", 0.0)
    assert settled() in ([], [report["energy"]]) and memory.state(obj).plain is report


def test_a_full_solve_afterwards_is_proved():
    obj = striped()
    obj.synch.spacing = 0.41
    assert followed() == 1 and memory.state(obj).plain["certificate"] == "none"
    assert solve(obj)["certificate"] == "proved" and followed() == 0


@pytest.mark.full_search
def test_a_click_while_it_is_on_starts_from_what_is_shown_and_proves():
    obj = striped(uneven)
    obj.synch.spacing = 0.44
    assert followed() == 1
    shown = memory.state(obj)
    anew = FieldJob("stripes", obj, stored_settings(obj)).request.solve()
    manager = bpy.context.window_manager
    manager.synch_live = True
    try:
        bpy.ops.synch.stripes("EXEC_DEFAULT", spacing=obj.synch.spacing)
        request = from_shown(obj, FieldJob("stripes", obj, stored_settings(obj)).request)
    finally:
        manager.synch_live = False
        bpy.app.timers.unregister(live_module._look)
    near = memory.state(obj)
    assert near.plain["certificate"] == "proved" and near.plain["energy"] <= shown.plain["energy"]
    products = [np.vdot(shown.pattern.phases, other.pattern.phases) for other in (near, anew)]
    shares = np.abs(products) / len(shown.pattern.phases)
    assert shares[0] > 0.8 and shares[0] > shares[1]
    results = []
    request.solve_showing(results.append)
    np.testing.assert_allclose(results[0].pattern.phases, near.pattern.phases, atol=1e-9)  # shown first as it is
    assert from_shown(obj, request) is request  # it is off again


def test_the_toggle_begins_to_look_and_ends_it():
    manager = bpy.context.window_manager
    manager.synch_live = True
    assert bpy.app.timers.is_registered(live_module._look) and live_module._look() > 0
    manager.synch_live = False
    assert live_module._look() is None
    bpy.app.timers.unregister(live_module._look)


def test_a_stroke_that_is_drawn_moved_and_removed_is_followed():
    obj = striped(lambda: sphere(4), spacing=0.3)
    obj.select_set(True)
    shown = [attribute(obj, "synch_direction")]
    turns = np.linspace(0.2, 1.2, 6)
    line = np.column_stack([np.cos(turns), np.sin(turns), 0.4 * np.sin(5 * turns)])
    for change in (
        lambda: guide_strokes.add(obj, [line], "ACROSS", None),
        lambda: guide_strokes.add(obj, [-line], "ACROSS", None),  # in the same row of the list
        lambda: guide_strokes.replace(obj, {("Icosphere Across", 0): line * (1, 1, -1)}),
        lambda: setattr(obj.synch.constraints[0].curve, "location", (0.0, 0.0, 0.3)),
        lambda: guide_strokes.remove(obj, [("Icosphere Across", 0), ("Icosphere Across", 1)]),
    ):
        assert followed() == 0
        change()
        bpy.context.view_layer.update()
        assert followed() == 1 and live.error == ""
        shown.append(attribute(obj, "synch_direction"))
        assert np.abs(shown[-1] - shown[-2]).max() > 0.05
    assert followed() == 0


def test_a_stroke_that_a_full_solve_has_read_is_not_followed_again():
    obj = striped(lambda: sphere(4), spacing=0.3)
    guide_strokes.add(obj, [np.eye(3)], "ALONG", None)
    solve(obj)
    assert memory.state(obj).report.curves_read and followed() == 0


def test_a_map_is_followed_after_it_was_painted():
    obj = sphere()
    obj.vertex_groups.new(name="turn").add([0], 0.0, "REPLACE")
    obj.synch.angle_attribute = "turn"
    obj.synch.automatic_spacing, obj.synch.spacing = False, 0.4
    solve(obj)
    before = attribute(obj, "synch_direction")
    bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
    assert followed() == 0
    obj.vertex_groups["turn"].add(range(len(obj.data.vertices)), 0.1, "REPLACE")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert followed() == 1 and followed() == 0
    cosines = np.einsum("ij,ij->i", attribute(obj, "synch_direction"), before)
    np.testing.assert_allclose(np.median(np.abs(cosines)), np.cos(0.1), atol=2e-3)


def test_directions_that_are_given_have_no_solution_of_those_before():
    obj = striped(spacing=0.5)
    assert memory.state(obj).field.solution is not None
    obj.synch.guidance, obj.synch.guide.vectors = "ATTRIBUTE", "synch_direction"
    assert stored_settings(obj).exact_attribute == "synch_direction"
    assert followed() == 1 and live.error == ""
    field = memory.state(obj).field
    assert field.solution is None and field.energy is None


@pytest.mark.any_surface
@pytest.mark.parametrize("build", [cube, half_body])
def test_a_painted_map_is_followed_on_a_surface_of_its_own(build):
    obj = build()
    obj.vertex_groups.new(name="turn").add([0], 0.0, "REPLACE")
    obj.synch.angle_attribute = "turn"
    obj.synch.automatic_spacing, obj.synch.spacing = False, 0.5
    solve(obj)
    surface = surface_of(obj)
    before = attribute(surface, "synch_direction")
    bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
    assert followed() == 0
    obj.vertex_groups["turn"].add(range(len(obj.data.vertices)), 0.1, "REPLACE")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert followed() == 1 and live.error == "" and surface_of(obj) == surface != obj
    cosines = np.einsum("ij,ij->i", attribute(surface, "synch_direction"), before)
    np.testing.assert_allclose(np.median(np.abs(cosines)), np.cos(0.1), atol=2e-3)


def test_a_result_that_comes_in_edit_mode_is_dropped():
    obj = striped()
    before = obj.synch.result
    obj.synch.angle += np.radians(2)
    live.step(bpy.context)
    bpy.ops.object.mode_set(mode="EDIT")
    assert live._work is not None
    end = time.monotonic() + 20
    while live._work is not None and time.monotonic() < end:
        live.step(bpy.context)
        time.sleep(0.005)
    assert live._work is None and not live.error and obj.synch.result == before
    bpy.ops.object.mode_set(mode="OBJECT")
    assert followed() > 0 and obj.synch.result != before
