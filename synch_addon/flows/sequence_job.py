# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of a sequence: one object a frame, seen at its frame alone."""

import time

import bpy

from ...core.tasks.flow_sequences import SequenceRequest
from ..blender.transaction import at_the_end, whole_or_nothing
from . import memory
from .choice import finish
from .frames import flow_frames
from .memory import Filled, SolvedFlow
from .objects import facts, fill, make_filaments, make_tubes
from .report import sequence_report


class SequenceJob:
    """Filaments and tubes of each frame; see :mod:`..jobs.job`."""

    link = None

    def __init__(self, source, settings):
        self._start = time.perf_counter()
        files, self._name = flow_frames(source, *settings.frames, settings.attribute)
        self.request = SequenceRequest(files, settings)

    def write(self, result):
        """Make a collection with an object for each frame, and for both two; returns the report."""
        with whole_or_nothing():
            collection = bpy.data.collections.new(f"{self._name} Vortices")
            at_the_end(memory.flows.begin_sequence)
            for frame in result.frames:
                shown, both = frame.shown, []
                for wanted, make, kind in (
                    (shown.tubes, make_tubes, "Tubes"),
                    (shown.lines, make_filaments, "Filaments"),
                ):
                    if wanted is not None:
                        made = make(f"{self._name} {kind} {frame.frame:04d}", shown)
                        collection.objects.link(made)
                        _show_at(made, frame.frame)
                        both.append(made)
                if frame.result is not None:
                    self._keep(frame, both)
            bpy.context.scene.collection.children.link(collection)
            return sequence_report(self._name, self.request.settings, result, collection, self._start)

    def _keep(self, frame, objects):
        """Keep the solve of a frame, so that its objects can show another point of the sphere."""
        name, numbers = f"{self._name} {frame.frame:04d}", tuple(obj.session_uid for obj in objects)
        solved = SolvedFlow(name, self.request.settings, frame.result, fill, numbers)
        finish(solved, Filled(facts(frame.shown), fill), objects, self._start)


def _show_at(obj, frame):
    """Keys that show an object at one frame alone, in views and renders."""
    for name in ("hide_viewport", "hide_render"):
        for when, hidden in ((frame - 1, True), (frame, False), (frame + 1, True)):
            setattr(obj, name, hidden)
            obj.keyframe_insert(name, frame=when)
        setattr(obj, name, bpy.context.scene.frame_current != frame)
