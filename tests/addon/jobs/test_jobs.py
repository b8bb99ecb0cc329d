# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs that the window waits for: solved one after the other, and only what still fits is written."""

import time
from functools import partial
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import Cancelled, SynchError
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.jobs.kept_results import result_line
from synch_fields.synch_addon.jobs.queue import queue
from synch_fields.synch_addon.jobs.worker import Worker
from synch_fields.synch_addon.panels.solid_view import corners_of
from synch_fields.synch_addon.patterns import memory
from synch_fields.synch_addon.patterns.job import FieldJob

from ..event_loop import BESIDE, begun
from ..scenes import attribute, grid, set_vectors, snapshot, sphere
from .striping import Stripes, child, in_work, is_alive


@pytest.mark.full_search
def test_window_gets_what_a_script_gets():
    obj = sphere()
    loop, operator = begun(Stripes())
    assert loop.run(operator) == {"FINISHED"}
    assert queue.running is None and loop.free
    names = {a.name for a in obj.data.attributes if a.name.startswith("synch_")}
    written = [attribute(obj, name) for name in names]
    api.stripes(obj, spacing=0.4)
    assert names == {a.name for a in obj.data.attributes if a.name.startswith("synch_")}
    for name, values in zip(names, written, strict=True):
        np.testing.assert_array_equal(values, attribute(obj, name))


def test_the_window_is_never_kept_waiting_by_a_solve():
    sphere(6)
    loop, operator = begun(Stripes(spacing=0.1))
    loop.run(operator, until=in_work)
    loop.longest = 0.0
    loop.run(operator, until=lambda: queue.running.fraction > 0.3)
    assert loop.longest < 0.2
    bpy.ops.synch.cancel()


@pytest.mark.parametrize("button", [False, True])
def test_escape_and_button_cancel_at_once(button):
    sphere(5)
    before = snapshot()
    loop, operator = begun(Stripes(seed=3))
    loop.run(operator, until=in_work)
    number, start = child(), time.perf_counter()
    if button:
        bpy.ops.synch.cancel()
        result = loop.send(operator, "TIMER")
    else:
        result = loop.send(operator, "ESC", "PRESS")
    assert result == {"CANCELLED"} and time.perf_counter() - start < 0.2
    ((kind, line),) = operator.reports
    assert kind == {"INFO"} and line.endswith(": cancelled: nothing was changed")  # after the object's name
    assert queue.running is None and loop.free and snapshot() == before and not is_alive(number)


def test_escape_elsewhere_and_all_other_keys_are_blenders():
    sphere()
    loop, operator = begun(Stripes())
    assert loop.send(operator, "ESC", "PRESS", BESIDE) == {"PASS_THROUGH"}
    for key in ("X", "Z", "TAB", "LEFTMOUSE", "G"):
        assert loop.send(operator, key, "PRESS") == {"PASS_THROUGH"}
    assert loop.run(operator) == {"FINISHED"}


def test_several_jobs_wait_in_a_row_and_each_object_has_one():
    first, second = sphere(), sphere()
    second.name = "second"
    bpy.context.view_layer.objects.active = first
    loop, operator = begun(Stripes())
    assert not bpy.ops.synch.stripes.poll() and queue.holds(first) and not queue.holds(second)
    with pytest.raises(RuntimeError, match=r"is being solved: wait for it, or cancel it"):
        bpy.ops.synch.quads()
    bpy.context.view_layer.objects.active = second
    assert bpy.ops.synch.stripes.poll()
    other_loop, other = begun(Stripes(spacing=0.5))
    assert [work.has_begun for work in queue.works] == [True, False] and "waiting" in queue.works[1].line
    assert other_loop.send(other, "ESC", "PRESS") == {"PASS_THROUGH"}  # it is not its turn
    assert loop.run(operator) == {"FINISHED"}
    assert "synch_phase" in first.data.attributes and "synch_phase" not in second.data.attributes
    assert other_loop.run(other) == {"FINISHED"} and "synch_phase" in second.data.attributes


def test_a_waiting_job_can_be_cancelled_without_the_one_that_runs(monkeypatch):
    asked, ask = [], Worker.ask
    monkeypatch.setattr(Worker, "ask", lambda worker, request: (asked.append(request), ask(worker, request)))
    sphere()
    loop, operator = begun(Stripes())
    sphere()
    other_loop, other = begun(Stripes())
    bpy.ops.synch.cancel(place=1)
    assert other_loop.send(other, "TIMER") == {"CANCELLED"} and other_loop.free
    assert loop.run(operator) == {"FINISHED"} and len(asked) == 1


def test_errors_of_the_solve_reach_the_window():
    obj = sphere()
    set_vectors(obj, "outwards", attribute(obj, "position"))
    loop, operator = begun(Stripes(guidance="attribute:outwards"))
    assert loop.run(operator) == {"CANCELLED"}
    assert operator.reports[-1][0] == {"ERROR"} and "straight out of the surface" in operator.reports[-1][1]


def change_face(obj):
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.flip_normals()
    bpy.ops.object.mode_set(mode="OBJECT")


def change_position(obj):
    obj.data.vertices[3].co.x += 0.1


def change_scale(obj):
    obj.scale.x = 2.0
    bpy.context.view_layer.update()


@pytest.mark.parametrize("change", [change_face, change_position, change_scale])
def test_mesh_that_changed_meanwhile_is_not_written(change):
    obj = sphere()
    loop, operator = begun(Stripes())
    change(obj)
    before = snapshot()
    assert loop.run(operator) == {"CANCELLED"} and snapshot() == before
    assert "changed while it was solved" in operator.reports[-1][1]


def test_an_object_is_found_by_whatever_name_it_has():
    obj = sphere()
    name = obj.name
    loop, operator = begun(Stripes())
    obj.name = "renamed"
    other = sphere()
    other.name = name
    assert loop.run(operator) == {"FINISHED"}
    assert "synch_phase" in obj.data.attributes and "synch_phase" not in other.data.attributes


def test_object_that_is_gone_is_said_in_one_line():
    obj = sphere()
    loop, operator = begun(Stripes())
    name = obj.name
    bpy.data.objects.remove(obj)
    assert loop.run(operator) == {"CANCELLED"} and queue.running is None
    assert operator.reports == [({"ERROR"}, f"the object {name} is gone: nothing was written")]


def test_the_result_takes_no_selection_with_it():
    obj = sphere()
    loop, operator = begun(Stripes())
    other = sphere()
    obj.select_set(False)
    obj.hide_set(True)
    assert loop.run(operator) == {"FINISHED"}
    assert bpy.context.active_object == other and other.select_get() and not obj.select_get() and obj.hide_get()


@pytest.mark.parametrize("end", ["FINISHED", "CANCELLED"])
def test_the_result_waits_for_a_mode_in_which_it_can_be_written(end):
    obj = sphere()
    loop, operator = begun(Stripes())
    bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
    work = operator._work
    assert loop.run(operator, until=lambda: work.is_over and "waits" in (loop.status or "")) == {"PASS_THROUGH"}
    assert "waits for object mode of" in loop.status and "synch_phase" not in obj.data.attributes
    if end == "FINISHED":
        bpy.ops.object.mode_set(mode="OBJECT")
        assert loop.run(operator) == {"FINISHED"} and "synch_phase" in obj.data.attributes
    else:
        assert loop.send(operator, "ESC", "PRESS") == {"CANCELLED"} and loop.free
        bpy.ops.object.mode_set(mode="OBJECT")
        assert "synch_phase" not in obj.data.attributes


def test_taking_the_extension_out_ends_all_jobs_and_the_child():
    sphere()
    before = snapshot()
    loop, operator = begun(Stripes())
    loop.run(operator, until=in_work)
    number = child()
    queue.stop()
    assert not is_alive(number) and queue.running is None and snapshot() == before and loop.free
    assert loop.send(operator, "TIMER") == {"CANCELLED"} and loop.free


def test_opening_another_file_ends_the_job():
    sphere()
    loop, operator = begun(Stripes())
    loop.run(operator, until=in_work)
    number = child()
    bpy.ops.wm.read_homefile(use_empty=True)
    operator.cancel(loop)  # as Blender tells every operator that runs
    assert queue.running is None and loop.free and not is_alive(number) and not bpy.data.objects
    assert isinstance(operator._work.error, Cancelled)


def test_results_on_the_way_are_pictures_of_their_phases():
    obj = sphere(4)
    obj.scale = 1, 2, 3
    bpy.context.view_layer.update()
    job = FieldJob("stripes", obj, SurfaceSettings(spacing=0.4))
    shown = []
    found = job.request.solve_showing(shown.append)
    energies = [result.pattern.solution.energy for result in (*shown, found)]
    assert len(shown) > 2 and shown[0].pattern.solution.lower_bound == 0 < shown[-1].pattern.solution.lower_bound
    assert energies[0] > energies[-1]
    # The first is along other directions, the rest are ever better along those of the result.
    assert sorted(energies[1:], reverse=True) == pytest.approx(energies[1:], rel=1e-5)
    np.testing.assert_array_equal(found.pattern.phases, job.request.solve().pattern.phases)
    picture = job.request.picture(shown[0])
    # The picture is what Solid view shows of the object when the result is kept.
    job.write(shown[0])
    places, phases, of_quads = corners_of(obj)
    assert not of_quads and not picture.of_quads and not picture.phases[:, 1].any()
    np.testing.assert_allclose(picture.places, places, atol=1e-6)
    np.testing.assert_allclose(np.cos(picture.phases), np.cos(phases), atol=1e-3)


@pytest.mark.parametrize("command, settings", [("directions", {}), ("stripes", {"method": "spectral"})])
def test_nothing_is_shown_where_there_is_nothing_better_to_come(command, settings):
    request = FieldJob(command, sphere(), SurfaceSettings(spacing=0.4, **settings)).request
    shown = []
    request.solve_showing(shown.append)
    assert shown == []


def test_the_window_gets_pictures_and_discarding_them_goes_back():
    sphere(5)
    before = snapshot()
    loop, operator = begun(Stripes(spacing=0.15))
    seen = []

    def three():
        if queue.running.picture is not None and not any(queue.running.picture is one for one in seen):
            seen.append(queue.running.picture)
        return len(seen) == 3

    loop.run(operator, until=three)
    assert all(len(picture.places) >= 3 * 5120 for picture in seen) and snapshot() == before
    assert seen[0].phases.tobytes() != seen[2].phases.tobytes()
    bpy.ops.synch.cancel()
    assert loop.send(operator, "TIMER") == {"CANCELLED"} and snapshot() == before


def test_escape_keeps_what_is_drawn_and_a_second_one_discards_it():
    obj = sphere(6)
    before = snapshot()
    loop, operator = begun(Stripes(spacing=0.15))
    loop.run(operator, until=lambda: queue.running.picture is not None)
    assert loop.send(operator, "ESC", "PRESS") == {"PASS_THROUGH"} and not queue.running.can_be_kept
    assert loop.send(operator, "ESC", "PRESS") == {"CANCELLED"} and snapshot() == before
    loop, operator = begun(Stripes(spacing=0.15))
    loop.run(operator, until=lambda: queue.running.picture is not None)
    shown = queue.running.picture
    loop.send(operator, "ESC", "PRESS")
    assert loop.run(operator) == {"FINISHED"}
    np.testing.assert_allclose(np.cos(corners_of(obj)[1]), np.cos(shown.phases), atol=1e-3)


def test_good_enough_writes_what_is_shown_and_nothing_is_kept_of_it_for_the_next():
    obj = sphere(5)
    loop, operator = begun(Stripes(spacing=0.15))
    assert not bpy.ops.synch.keep.poll()
    loop.run(operator, until=lambda: queue.running.picture is not None)
    picture = queue.running.picture
    bpy.ops.synch.keep()
    bpy.ops.synch.keep()  # the second word comes when all is over
    assert loop.run(operator) == {"FINISHED"} and loop.free
    places, phases, _ = corners_of(obj)
    np.testing.assert_allclose(picture.places, places, atol=1e-6)
    np.testing.assert_allclose(np.cos(picture.phases), np.cos(phases), atol=1e-3)
    kept = memory.recall(obj).plain
    assert kept["status"] == "no bound asked" and kept["energy"] > 0
    loop, operator = begun(Stripes(spacing=0.4))
    assert loop.run(operator) == {"FINISHED"}
    assert memory.recall(obj).plain["certificate"] == "proved"


def test_good_enough_keeps_the_draft_of_a_quad_mesh():
    sphere(6)
    operator = Stripes(spacing=0.15, faces=2000)
    operator.command = "quad_mesh"
    loop, operator = begun(operator)
    loop.run(operator, until=lambda: queue.running.picture is not None)
    assert not bpy.ops.synch.keep.poll()  # a glimpse is no result
    loop.run(operator, until=lambda: queue.running.shows_result)
    assert queue.running.picture.of_quads
    bpy.ops.synch.keep()
    assert loop.run(operator) == {"FINISHED"}
    made = [obj for obj in bpy.data.objects if obj.type == "MESH" and len(obj.data.polygons) < 4000]
    assert len(made) == 1 and len(made[0].data.polygons) == pytest.approx(2000, rel=0.2)
    assert all(len(face.vertices) == 4 for face in made[0].data.polygons)


def test_views_status_bar_and_panels_are_drawn_one_at_a_time(monkeypatch):
    sphere(5)
    monkeypatch.setattr("synch_fields.synch_addon.operators.field_operator._TURN", 0.0)
    loop, operator = begun(Stripes(spacing=0.15))
    said, drawn = [], []
    loop.windows = [loop]
    for kind in ("UI", "WINDOW"):
        loop.areas[0].regions.append(SimpleNamespace(type=kind, tag_redraw=partial(drawn.append, kind)))
    monkeypatch.setattr(loop, "status_text_set", drawn.append)
    while queue.running.picture is None or queue.running.fraction < 0.4:
        loop.run(operator, until=lambda: drawn)
        said += drawn
        assert len(drawn) == 1
        drawn.clear()
    assert "WINDOW" in said
    said = [one == "UI" for one in said if one != "WINDOW"]
    assert len(said) > 4 and said == [True, False] * (len(said) // 2) + [True] * (len(said) % 2)  # in turns
    bpy.ops.synch.cancel()


def test_errors_select_on_their_own_object_alone():
    obj = sphere()
    loop, operator = begun(Stripes())
    work = operator._work
    other = grid(2)
    queue.cancel(work)
    work.error = SynchError("a line", [len(obj.data.vertices) - 1])
    assert loop.send(operator, "TIMER") == {"CANCELLED"} and not any(
        v.select for v in other.data.vertices if v.index > 99
    )
    assert obj.data.vertices[len(obj.data.vertices) - 1].select


def test_what_is_kept_of_a_result_is_not_touched_by_the_report():
    """Showing a state again gives the same line, whatever the report says of waiting and memory."""
    obj = sphere()
    loop, operator = begun(Stripes())
    assert loop.run(operator) == {"FINISHED"}
    line, shown = obj.synch.result, memory.recall(obj)
    assert result_line(shown.plain) == line
    api.vary(obj, 1)
    api.show_again(obj, shown)
    assert obj.synch.result == line


def test_an_object_whose_job_waits_is_refused_whatever_asks():
    obj = sphere()
    loop, operator = begun(Stripes())
    with pytest.raises(SynchError, match="is being solved"):
        queue.add(FieldJob("quads", obj, SurfaceSettings(spacing=0.5)), "Quads")
    assert len(queue.works) == 1 and loop.send(operator, "ESC", "PRESS") == {"CANCELLED"}


def test_jobs_refuse_at_once_what_cannot_be():
    obj = sphere()
    obj.data.clear_geometry()
    with pytest.raises(SynchError):
        begun(Stripes())
    assert queue.running is None
