# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The job that the window waits for: it solves in a thread, stops when asked, and writes only what still fits."""

import time

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import Cancelled, SynchError
from synch_fields.synch_addon import api, jobs
from synch_fields.synch_addon.settings import Settings

from .scenes import attribute, set_vectors, snapshot, sphere


def started(obj, **settings):
    return jobs.BackgroundSolve(api.FieldJob("stripes", obj, Settings(spacing=0.4, **settings)))


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
