# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Animate from the window, frame by frame, and from an operator and the command line."""

import json

import bpy
import numpy as np
import pytest

from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.undo_steps import undo_steps
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.frames.job import AnimationJob, Span
from synch_fields.synch_addon.jobs.queue import queue
from synch_fields.synch_addon.operators import field_operator
from synch_fields.synch_addon.operators.animate import SYNCH_OT_animate
from synch_fields.synch_addon.operators.field_operator import BackgroundOperator, FieldOperator

from ..event_loop import Loop, Recorded
from ..moving_meshes import seen, stored_frames, swaying
from ..scenes import attribute, save_and_reopen, snapshot, sphere


class Animate(Recorded, BackgroundOperator):
    """The operator as the window runs it, without being one of Blender's."""

    bl_label = "Animate"
    _headline = SYNCH_OT_animate._headline

    def _job(self, context):
        return AnimationJob(context.active_object, SurfaceSettings(spacing=0.7), Span(1, 3))


@pytest.fixture
def begun(monkeypatch):
    """A moving object and an operator in a loop of its own, which reads one frame at each tick."""
    monkeypatch.setattr(AnimationJob, "at_once", 0.0)
    obj, loop, operator = swaying(sphere(2), 3), Loop(), Animate()
    bpy.context.scene.frame_set(2)
    before = snapshot()
    assert operator._start(loop) == {"RUNNING_MODAL"}
    return obj, loop, operator, before


@pytest.mark.full_search
def test_the_window_reads_frame_by_frame_and_waits_for_the_worker(begun):
    obj, loop, operator, before = begun
    seen = []
    for _ in range(2):
        assert loop.send(operator, "TIMER") == {"RUNNING_MODAL"}
        seen.append((queue.running.stage, queue.running.fraction))
        assert bpy.context.scene.frame_current == 2 and snapshot() == before
    assert seen == [("read frame 2", pytest.approx(0.1 / 3)), ("read frame 3", pytest.approx(0.2 / 3))]
    assert loop.run(operator) == {"FINISHED"} and loop.free and queue.running is None
    phases = attribute(obj, "synch_phase.2")
    api.animate(obj, frames=(1, 3), spacing=0.7)
    np.testing.assert_array_equal(phases, attribute(obj, "synch_phase.2"))


@pytest.mark.parametrize("ticks", [0, 3])
def test_escape_while_frames_are_read_or_solved_changes_nothing(begun, ticks):
    _, loop, operator, before = begun
    for _ in range(ticks):
        assert loop.send(operator, "TIMER") & {"RUNNING_MODAL", "PASS_THROUGH"}
    assert loop.send(operator, "ESC", "PRESS") == {"CANCELLED"}
    ((kind, line),) = operator.reports
    assert kind == {"INFO"} and line.endswith(": cancelled: nothing was changed")  # after the object's name
    assert snapshot() == before and bpy.context.scene.frame_current == 2 and loop.free and queue.running is None


def test_a_frame_that_cannot_be_read_ends_the_run_in_the_window(begun):
    obj, loop, operator, _ = begun
    loop.send(operator, "TIMER")
    obj.modifiers.new("Double", "MIRROR")
    assert loop.run(operator) == {"CANCELLED"} and loop.free and queue.running is None
    assert operator.reports[-1][0] == {"ERROR"} and operator.reports[-1][1].startswith("frame 2: the modifier Double")
    assert bpy.context.scene.frame_current == 2 and "synch_phase" not in obj.data.attributes


def test_frames_are_read_from_edit_mode(begun):
    obj, loop, operator, _ = begun
    bpy.ops.object.mode_set(mode="EDIT")
    loop.send(operator, "TIMER")
    assert obj.mode == "EDIT" and queue.running.stage == "read frame 2"
    assert loop.run(operator) == {"FINISHED"} and obj.mode == "EDIT"


def test_operator_and_command_line_give_the_same(tmp_path):
    obj = swaying(sphere(2), 3)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 2
    api.animate(obj, spacing=0.7, hold=0.3)
    wanted = attribute(obj, "synch_phase.2")
    assert stored_frames(obj) == [1, 2]
    assert bpy.ops.synch.animate(spacing=0.7, hold=0.3) == {"FINISHED"}
    np.testing.assert_allclose(attribute(obj, "synch_phase.2"), wanted, atol=1e-3)
    path, written = tmp_path / "out.blend", tmp_path / "report.json"
    line = ["animate", "--object", obj.name, "--frames", "1", "2", "--hold", "0.3", "--spacing", "0.7", "--quiet"]
    assert main.main([*line, "--output", str(path), "--report", str(written)], loaded=True) == 0
    report = json.loads(written.read_text())
    assert [figures["frame"] for figures in report["frames"]] == [1, 2] and report["pattern"] == "stripes"
    again = save_and_reopen(path, obj.name)
    np.testing.assert_allclose(attribute(seen(again, 2), "synch_phase"), wanted, atol=1e-3)


def test_of_the_jobs_of_one_click_the_last_makes_the_step_for_undo(monkeypatch):
    pushed, owed = [], []
    monkeypatch.setattr(undo_steps, "push", pushed.append)
    monkeypatch.setattr(undo_steps, "owe", owed.append)
    done, stopped = {"FINISHED"}, {"CANCELLED"}
    for results, last, steps, between in (
        ([done], done, [], []),
        ([stopped], stopped, [], []),
        ([done, done, done], done, [], ["Stripes"] * 2),
        ([stopped, done], done, [], []),
        ([done, stopped], stopped, ["Stripes"], ["Stripes"]),
    ):
        owed.clear()
        click = field_operator.Click()
        for _ in results:
            click.begin()
        ended = [click.end(result, "Stripes") for result in results]
        assert ended == [*[stopped] * (len(results) - 1), last] and pushed == steps and owed == between


def test_all_objects_of_one_click_share_its_step(monkeypatch):
    """Four: each that is begun looks for others, too, and finds none."""
    spheres, clicks = [sphere(1) for _ in range(4)], []
    others = [spheres[1:]]
    monkeypatch.setattr(field_operator, "others_selected", lambda _: others.pop() if others else [])

    class Selected(FieldOperator):
        def _begin(self, context):
            self._click = self._click or field_operator.Click()
            clicks.append(self._click)
            return {"RUNNING_MODAL"}

        def _begin_another(self, obj):
            Selected().invoke(bpy.context, None)

    Selected().invoke(bpy.context, None)
    assert len(clicks) == 4 and len({*clicks}) == 1 and FieldOperator._click is None
