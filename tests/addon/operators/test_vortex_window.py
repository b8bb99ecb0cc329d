# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices from the window: it stays alive while they are solved, Esc is heard at once, and nothing is half written."""

import bpy
import pytest

from synch_fields.core.settings.flow import FlowSettings
from synch_fields.synch_addon.flows.job import job_for
from synch_fields.synch_addon.jobs.queue import queue
from synch_fields.synch_addon.operators.clebsch import SYNCH_OT_clebsch
from synch_fields.synch_addon.operators.field_operator import BackgroundOperator

from ..event_loop import Recorded, begun
from ..scenes import snapshot
from ..vortex_scenes import QUICK, write_npz, write_vdb

# Seconds that one event may take.
AT_ONCE = 0.2


class Vortices(Recorded, BackgroundOperator):
    """The operator as the window runs it, without being one of Blender's."""

    bl_label = "Vortices"
    _headline = SYNCH_OT_clebsch._headline

    def __init__(self, source, **settings):
        super().__init__()
        self.source, self.settings = source, FlowSettings(**settings)

    def _job(self, context):
        return job_for(self.source, self.settings)


def wide_circle():
    """A circle whose flow at 40 nodes takes seconds to integrate, and longer to solve."""
    bpy.ops.curve.primitive_bezier_circle_add()
    made = bpy.context.active_object
    made.data.resolution_u = 64
    return made


@pytest.mark.parametrize(("stage", "resolution"), [("flow", 40), ("relaxation", 22)])
def test_escape_is_heard_at_once_whatever_is_done(stage, resolution):
    """Of tubes alone there is no early picture that Esc would keep."""
    obj = wide_circle()
    before = snapshot()
    loop, operator = begun(Vortices(obj, show="tubes", quantum=0.34, resolution=resolution))
    loop.run(operator, until=lambda: stage in queue.running.stage)
    assert loop.send(operator, "ESC", "PRESS") == {"CANCELLED"} and loop.longest < AT_ONCE
    assert queue.running is None and loop.free and snapshot() == before
    assert operator.reports == [({"INFO"}, "cancelled: nothing was changed")]


def test_the_objects_are_there_at_the_end(tmp_path):
    loop, operator = begun(Vortices(str(write_npz(tmp_path / "ring.npz", circulation=4.0)), show="both", **QUICK))
    before = snapshot()
    stages = []

    def nothing_yet():
        stages.append(operator._work.stage)
        return snapshot() != before

    assert loop.run(operator, until=nothing_yet) == {"FINISHED"}
    assert len(set(stages)) > 2 and operator.reports[0][0] == {"INFO"} and "filament" in operator.reports[0][1]
    assert {tuple(kind) for kind, _ in operator.reports[1:]} == {("WARNING",)}  # last, where they are seen
    assert sorted(obj.type for obj in bpy.data.objects) == ["CURVE", "MESH"]


def test_frames_are_named_while_they_are_solved(tmp_path):
    for frame in (1, 2):
        write_vdb(tmp_path / f"s_{frame}.vdb", 0.1 * frame)
    loop, operator = begun(Vortices(str(tmp_path / "s_#.vdb"), frames=(1, 2), resolution=18, **QUICK))
    loop.run(operator, until=lambda: operator._work.stage.startswith("frame 2, "))
    assert not bpy.data.objects
    assert loop.run(operator) == {"FINISHED"} and "2 frames" in operator.reports[0][1]
    assert len(bpy.data.collections["s Vortices"].objects) == 2


def test_an_error_of_the_solve_is_one_line(tmp_path):
    (tmp_path / "text.vdb").write_text("no volume")
    loop, operator = begun(Vortices(str(tmp_path / "text.vdb")))
    assert loop.run(operator) == {"CANCELLED"}
    ((kind, line),) = operator.reports
    assert kind == {"ERROR"} and "choose an OpenVDB file" in line and "\n" not in line
