# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The job that the window waits for: it solves in a thread, stops when asked, and writes only what still fits."""

import time

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import Cancelled, SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.jobs import jobs
from synch_fields.synch_addon.operators import field_operator
from synch_fields.synch_addon.patterns import job, preview
from synch_fields.synch_addon.settings.fields import Settings

from .loop import Recorded, begun
from .scenes import attribute, set_vectors, snapshot, sphere


def started(obj, **settings):
    return jobs.BackgroundSolve(job.FieldJob("stripes", obj, Settings(spacing=0.4, **settings)))


def test_background_gives_what_a_blocking_run_gives():
    obj = sphere()
    work = started(obj)
    work.wait()
    assert work.finished and work.error is None and 0 < work.fraction <= 1
    work.job.write(obj)
    phases = attribute(obj, "synch_phase")
    api.stripes(obj, spacing=0.4)
    np.testing.assert_array_equal(phases, attribute(obj, "synch_phase"))


def test_cancelled_job_stops_soon_and_changes_nothing():
    obj = sphere()
    before = snapshot()
    work = started(obj)
    while not work.stage:
        time.sleep(0.001)
    work.cancel()
    work.wait()
    assert isinstance(work.error, Cancelled)
    assert snapshot() == before


def test_jobs_that_were_cancelled_have_ended_when_the_extension_goes():
    left = started(sphere())
    left.cancel()
    jobs.running = started(sphere())
    jobs.stop()
    assert left.cancelled and left.finished and jobs.running is None


def test_error_in_the_thread_reaches_the_window():
    obj = sphere()
    set_vectors(obj, "outwards", attribute(obj, "position"))
    work = started(obj, guidance="attribute:outwards")
    work.wait()
    assert isinstance(work.error, SynchError) and "straight out of the surface" in str(work.error)


@pytest.mark.parametrize("change", ["face", "position", "scale"])
def test_mesh_that_changed_meanwhile_is_not_written(change):
    obj = sphere()
    work = started(obj)
    work.wait()
    if change == "face":
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.flip_normals()
        bpy.ops.object.mode_set(mode="OBJECT")
    elif change == "position":
        obj.data.vertices[3].co.x += 0.1
    else:
        obj.scale.x = 2.0
        bpy.context.view_layer.update()
    before = snapshot()
    with pytest.raises(SynchError, match="changed while it was solved"):
        work.job.write(obj)
    assert snapshot() == before


def test_taking_the_extension_out_ends_the_job():
    jobs.running = started(sphere())
    work = jobs.running
    jobs.stop()
    assert jobs.running is None and work.finished


class Stripes(Recorded, field_operator.FieldOperator):
    """The operator as the window runs it, without being one of Blender's."""

    bl_label, command = "Stripes", "stripes"

    def __init__(self, **settings):
        super().__init__()
        self.settings, self.spacing = Settings(spacing=0.4, **settings), 0.0

    def _settings(self):
        return self.settings


def test_window_gets_what_a_script_gets():
    obj = sphere()
    loop, operator = begun(Stripes())
    assert loop.run(operator) == {"FINISHED"}
    assert jobs.running is None and loop.free
    phases = attribute(obj, "synch_phase")
    api.stripes(obj, spacing=0.4)
    np.testing.assert_array_equal(phases, attribute(obj, "synch_phase"))


@pytest.mark.parametrize("subdivisions", [3, 5])
@pytest.mark.parametrize("button", [False, True])
def test_escape_and_button_cancel_at_once(subdivisions, button):
    sphere(subdivisions)
    before = snapshot()
    loop, operator = begun(Stripes(seed=3))
    loop.run(operator, until=lambda: jobs.running.fraction > 0.1)
    start = time.perf_counter()
    if button:
        bpy.ops.synch.cancel()
        result = loop.send(operator, "TIMER")
    else:
        result = loop.send(operator, "ESC", "PRESS")
    assert result == {"CANCELLED"} and time.perf_counter() - start < 0.2
    assert operator.reports == [({"INFO"}, "cancelled: nothing was changed")]
    assert jobs.running is None and loop.free and snapshot() == before


def test_second_job_is_refused_with_the_reason():
    sphere()
    loop, operator = begun(Stripes())
    assert not bpy.ops.synch.stripes.poll()
    with pytest.raises(RuntimeError, match="is being solved: wait for it, or cancel it with Esc"):
        bpy.ops.synch.quads()
    loop.send(operator, "ESC", "PRESS")
    assert bpy.ops.synch.stripes.poll()


@pytest.fixture
def early(monkeypatch):
    """First results for small meshes too."""
    monkeypatch.setattr(jobs, "EARLY_FROM", 0)


@pytest.mark.parametrize("end", ["FINISHED", "CANCELLED"])
def test_first_result_is_shown_and_gone_at_the_end(early, end):
    obj = sphere(4)
    obj.data.materials.append(bpy.data.materials.new("Mine"))
    name, before = obj.name, snapshot()
    loop, operator = begun(Stripes())
    loop.run(operator, until=lambda: preview.shown is not None)
    (copy,) = [other for other in bpy.data.objects if other.type == "MESH" and other != obj]
    assert attribute(copy, "synch_phase").any() and copy.visible_get() and not obj.visible_get()
    assert "synch_phase" not in obj.data.attributes and bpy.context.active_object == obj
    first = jobs.running.fraction
    if end == "CANCELLED":
        assert loop.send(operator, "ESC", "PRESS") == {"CANCELLED"} and snapshot() == before
    else:
        assert loop.run(operator) == {"FINISHED"} and first < 0.7
        assert [o.name for o in bpy.data.objects if o.type == "MESH"] == [name]
        report = api.stripes(obj, spacing=0.4)
        assert not report["warnings"] and len(bpy.data.materials) == 2
    assert preview.shown is None and obj.visible_get() and obj.select_get()


@pytest.mark.parametrize("stage", ["results", "last step"])
def test_first_result_that_cannot_be_shown_does_not_stop_the_job(early, stage, monkeypatch):
    def fail(*_):
        raise RuntimeError("no place")

    obj = sphere(4)
    write_results, before = preview.write.results, snapshot()
    monkeypatch.setattr(preview.write, "results", fail if stage == "results" else write_results)
    if stage == "last step":
        monkeypatch.setattr(preview, "_spaces", fail)
    loop, operator = begun(Stripes())
    loop.run(operator, until=lambda: operator.reports)
    assert operator.reports == [({"WARNING"}, "the first result is not shown: no place")]
    assert jobs.running is not None and preview.shown is None and snapshot() == before
    monkeypatch.setattr(preview.write, "results", write_results)
    assert loop.run(operator) == {"FINISHED"} and loop.free
    assert obj.visible_get() and obj.select_get() and "synch_phase" in obj.data.attributes


def test_taking_the_extension_out_gives_the_window_back(early):
    sphere(4)
    before = snapshot()
    loop, operator = begun(Stripes())
    loop.run(operator, until=lambda: preview.shown is not None)
    assert loop.status and not loop.free
    preview.hide()  # as the extension does, module by module
    jobs.stop()
    assert loop.free and snapshot() == before
    assert loop.send(operator, "TIMER") == loop.send(operator, "ESC", "PRESS") == {"CANCELLED"}
    operator.cancel(loop)
    assert loop.free and jobs.running is None


def test_saving_meanwhile_leaves_the_first_result_out(early, tmp_path):
    obj = sphere(4)
    loop, operator = begun(Stripes())
    loop.run(operator, until=lambda: preview.shown is not None)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "mid.blend"), copy=True)
    assert preview.shown is None and [o.name for o in bpy.data.objects] == [obj.name]
    assert loop.run(operator) == {"FINISHED"}
    with bpy.data.libraries.load(str(tmp_path / "mid.blend")) as (kept, _):
        assert kept.objects == [obj.name]


@pytest.mark.parametrize("first", [False, True])
def test_opening_another_file_ends_the_job(first, monkeypatch):
    if first:
        monkeypatch.setattr(jobs, "EARLY_FROM", 0)
    sphere(4)
    loop, operator = begun(Stripes())
    if first:
        loop.run(operator, until=lambda: preview.shown is not None)
    work = jobs.running
    bpy.ops.wm.read_homefile(use_empty=True)
    assert work.cancelled and preview.shown is None
    operator.cancel(loop)  # as Blender tells every operator that runs
    assert jobs.running is None and loop.free
    work.wait()
    assert not bpy.data.objects and isinstance(work.error, Cancelled)


def test_object_that_is_gone_is_said_in_one_line():
    obj = sphere()
    loop, operator = begun(Stripes())
    bpy.data.objects.remove(obj)
    jobs.running.wait()
    assert loop.run(operator) == {"CANCELLED"}
    assert operator.reports[-1][0] == {"ERROR"} and "is gone: nothing was written" in operator.reports[-1][1]
