# SPDX-License-Identifier: GPL-3.0-or-later
"""Live: what an object shows follows its settings, while they are dragged, curves that are drawn, and painted maps.

A timer compares the settings of the active object with those of the pattern that it shows. A job solves for the newest
settings from the shown pattern. Until its result is written, further changes wait; a job that takes long is ended for
them. Once nothing changes, the pattern settles: one of less energy fades in, then that of a whole solve from there.
"""

import time
from dataclasses import replace

import bpy
import numpy as np
from bpy.props import BoolProperty

from ...core.errors import Cancelled, SynchError
from ...core.solve.warm_start import Follower
from ...core.tasks.live import ANEW, NEAR, LiveRequest
from ...core.tasks.surfaces import SHOWN
from ..blender.objects import ObjectLink
from ..blender.pattern_surface import surface_of
from ..blender.timers import Timer
from ..blender.transaction import whole_or_nothing
from ..blender.undo_steps import undo_steps
from ..jobs.queue import queue
from ..jobs.report import Report
from ..reading.surface import gather, settings_for
from ..settings.fields import stored_settings
from . import memory, own_surface
from .curves_read import curves_read
from .job import write_result

_NAME = "Live"
# Seconds between two looks; after which a solve is ended if something else is asked for; of rest that end a change; in
# which a new pattern fades in. At 35,000 vertices it is whole a second after the last step.
_TICK, _PATIENCE, _REST, _FADE = 0.03, 0.7, 0.33, 0.2
# The share of the rest after which the new pattern is solved for. It is not shown before the rest ends.
_HEAD_START = 0.4
# A new pattern fades in where its energy is below this share of the shown one's.
_BETTER = 0.97
# What a pattern does not depend on, but its search, its faces and quad meshes do.
_OF_OTHERS = ("method", "rounding", "target_gap", "seed", "features", "smoothing", "faces", "loops", "strict")
# What directions do not depend on, but for their turn.
_OF_PATTERNS = ("spacing", "spacing_map", "spacing_range", "aspect", "branching")
_OF_PATTERNS += ("angle", "angle_attribute", "angle_range")


class LiveJob:
    """The pattern of an object for other settings, from what it shows; see :mod:`..jobs.job`.

    Parameters
    ----------
    settings : as of :func:`settings_for`
    shown : :class:`memory.Solved` that it shows
    followers : of the directions and of the pattern
    instead : whether the result is kept instead of what is shown
    is_painted : whether painted maps may have changed since the shown pattern read them
    settles : as of :class:`LiveRequest`
    turned_only : when the pattern settles, whether directions have only been turned since the last solve
    """

    def __init__(self, obj, settings, shown, followers, instead, is_painted=False, settles="", turned_only=True):
        self.link, self._shown, self._instead = ObjectLink.to(obj), shown, instead
        self._report = Report(shown.request.command, obj, settings)
        before, given = shown.report.settings, shown.request.given
        if _cuts(settings) != _cuts(before) or settings.symmetry != before.symmetry:
            raise SynchError("live settings cut no edges and change no symmetry: solve again")
        with self._report.clock("read"):
            if is_painted:
                own_surface.carry_painted_groups(obj)
            self._asked = gather(shown.request.command, surface_of(obj), settings, given=given)
            self._report.curves_read = curves_read(obj, settings)
            self._report.warn_about(obj, self._asked)
        # Directions are solved again unless all that they depend on is as it was.
        same = {name: getattr(before, name) for name in _OF_PATTERNS}
        turns_only = not is_painted and self._report.curves_read == shown.report.curves_read
        turns_only &= turned_only and replace(settings, **same) == before
        field, phases = shown.field.without_solution, shown.pattern.phases
        self.request = LiveRequest(self._asked, field, phases, turns_only, followers, settles)

    def write(self, result, share=1.0):
        """Write the result, or a share of the way to it, to the object at once; returns the report."""
        obj, shown, report = self.link.found, self._shown, self._report
        if share < 1:
            result, report = self.request.mixed(result, share), report.for_another_result()
        field = result.field
        if field.solution is None and self._asked.source.directions is None:  # the shown one, which was only turned
            is_turned = not np.array_equal(field.angles, shown.field.angles)
            field = replace(shown.field, angles=field.angles, turn=field.turn) if is_turned else shown.field
        report.take(result)
        with whole_or_nothing():
            if not own_surface.is_unchanged(obj, self._asked.given):
                raise SynchError(f"the mesh or the scale of {obj.name} changed while it was solved: run again")
            return write_result(obj, self._asked, field, result.pattern, report, instead=self._instead)


def _cuts(settings):
    return [(row.where, row.name) for row in settings.constraints if row.what == "cut"]


def from_shown(obj, request):
    """A request for a whole solve, which starts from what its object shows where Live is on and that is of its kind."""
    if not bpy.context.window_manager.synch_live or not memory.holds(obj):
        return request
    shown = memory.state(obj)
    before = shown.request
    triangles, asked = before.given.mesh.triangles, request.given.mesh.triangles
    of_kind = (before.command, before.settings.symmetry) == (request.command, request.settings.symmetry)
    if request.command not in SHOWN or not of_kind or not np.array_equal(triangles, asked):
        return request
    return replace(request, start=(shown.field.angles - shown.field.turn, shown.pattern.phases))


class _Live:
    """Follows the settings of the active object while it is on.

    ``error``: why nothing can follow, in one line, or "".
    """

    def __init__(self):
        self.clear()

    def clear(self):
        """Follow nothing, and keep nothing."""
        self.error = ""
        self._work = self._asked_last = self._shown = self._changed = self._fade = None
        self._is_painted, self._turned_only, self._stages = False, True, []
        self._mesh, self._followers = None, (Follower(), Follower())

    def step(self, context):
        """Write the result of the solve if it has ended, and begin the next one."""
        if self._work is not None:
            queue.advance()
            if not self._work.is_over:
                self._end_what_is_late()
                return
            self._finish(self._work)
        obj = context.active_object
        self._is_painted |= obj is not None and obj.mode == "WEIGHT_PAINT"
        if self._may_follow(obj):
            self._follow(obj)

    def _may_follow(self, obj):
        """Whether an object shows a pattern that other settings may change now."""
        if obj is None or obj.mode != "OBJECT" or queue.works or not memory.holds(obj):
            return False
        return memory.solve_of(obj).request.command in SHOWN

    def _follow(self, obj):
        """Start a job if settings differ from the shown and the asked ones; else settle once they have rested."""
        shown = memory.state(obj)
        asked = self._present_settings(obj, shown)
        known = (shown.report.settings, shown.report.curves_read), self._asked_last
        if asked is None or (asked in known and not self._is_painted):
            is_first = self._fade is None and self._stages[:1] == [ANEW]
            rest = _HEAD_START * _REST if is_first else _REST
            if self._changed is not None and time.monotonic() > self._changed + rest:
                self._settle(obj, shown, asked)
            return
        if self._mesh is not shown.request.given.mesh:
            self._mesh, self._followers = shown.request.given.mesh, (Follower(), Follower())
        self._asked_last, self._fade = asked, None
        instead = self._shown is shown  # a step on the way to the next one
        is_painted, self._is_painted = self._is_painted, False
        try:
            job = LiveJob(obj, asked[0], shown, self._followers, instead, is_painted)
            self._work = queue.add(job, _NAME, is_quiet=True)
        except SynchError as error:
            self._say(str(error))

    def _present_settings(self, obj, shown):
        """The object's present settings, but for ``_OF_OTHERS``, which stay as in the shown solve, and the state of the
        curves that they name; None if they are not valid: then the status line says why."""
        before = shown.report.settings
        try:
            settings = settings_for(shown.request.command, obj, stored_settings(obj))
        except SynchError as error:
            self._say(str(error))
            return None
        settings = replace(settings, **{name: getattr(before, name) for name in _OF_OTHERS})
        return settings, curves_read(obj, settings)

    def _end_what_is_late(self):
        obj, work = self._work.job.link.present, self._work
        if obj is None:
            queue.cancel(work)
        elif (work.job.request.settles or work.age > _PATIENCE) and memory.holds(obj):
            if self._present_settings(obj, memory.state(obj)) != self._asked_last:
                queue.end(work)

    def _finish(self, work):
        """Write the result of a job that has ended; a better one of a search fades in instead."""
        self._work, job = None, work.job
        if job.link.present is not None and job.link.present.mode == "EDIT":  # its mesh cannot be read now
            self._asked_last = None
            return
        try:
            if work.error is not None:
                raise work.error
            if job.request.settles == ANEW:
                if work.result.pattern.energy < _BETTER * self._shown.pattern.energy:
                    self._fade = job, work.result, max(time.monotonic(), self._changed + _REST)
                return
            job.write(work.result)
            undo_steps.owe(_NAME)
        except Cancelled:
            self._asked_last = None
            return
        except SynchError as error:
            self._say(str(error))
            self._stages = []
            return
        self._shown, self._changed = memory.state(job.link.found), time.monotonic()
        if not job.request.settles:
            self._stages = [ANEW, NEAR]
            self._turned_only &= job.request.turns_only
        self._say("")

    def _settle(self, obj, shown, asked):
        """After a rest, go on to a better pattern; at the last one, which is kept, undo leads back here."""
        if shown is not self._shown or asked is None:  # undone, or solved by a click
            self._changed = self._fade = None
        elif self._fade is not None or self._stages:
            try:
                self._fade_or_search(obj, shown, asked[0])
            except SynchError as error:
                self._say(str(error))
                self._fade, self._stages = None, []
        else:
            self._changed, self._shown, self._turned_only = None, None, True
            if not bpy.app.background:
                undo_steps.push(_NAME)

    def _fade_or_search(self, obj, shown, settings):
        """Write the next step of a fade, or else start the next search."""
        if self._fade is None:
            settling = {"settles": self._stages.pop(0), "turned_only": self._turned_only}
            job = LiveJob(obj, settings, shown, self._followers, True, **settling)
            self._work = queue.add(job, _NAME, is_quiet=True)
            return
        job, result, start = self._fade
        share = min((time.monotonic() - start) / _FADE, 1.0)
        if share == 1:
            self._fade = None
        job.write(result, share)
        undo_steps.owe(_NAME)
        self._shown = memory.state(obj)

    def _say(self, line):
        if line != self.error:
            self.error = line
            for window in bpy.context.window_manager.windows:
                for area in window.screen.areas:
                    area.tag_redraw()


live = _Live()


def _look():
    if not bpy.context.window_manager.synch_live:
        live.clear()
        return None
    live.step(bpy.context)
    return _TICK


_timer = Timer(_look, is_persistent=True)


def _on_toggle(manager, _context):
    if manager.synch_live:
        _timer.start()


def register():
    bpy.types.WindowManager.synch_live = BoolProperty(
        name=_NAME,
        description="Let stripes and quads follow their settings while these are dragged; click on Stripes or Quads "
        "for a full solve",
        update=_on_toggle,
        options={"SKIP_SAVE"},
    )


def unregister():
    _timer.stop()
    live.clear()
    del bpy.types.WindowManager.synch_live
