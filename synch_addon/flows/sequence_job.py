# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of a sequence: one object a frame, seen at its frame alone."""

import time

import bpy

from ...core.tasks.flow_sequences import SequenceRequest
from ..blender.transaction import whole_or_nothing
from .frames import flow_frames
from .objects import make_filaments, make_tubes
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
            for frame in result.frames:
                shown = frame.shown
                for wanted, make, kind in (
                    (shown.tubes, make_tubes, "Tubes"),
                    (shown.lines, make_filaments, "Filaments"),
                ):
                    if wanted is not None:
                        made = make(f"{self._name} {kind} {frame.frame:04d}", shown)
                        collection.objects.link(made)
                        _show_at(made, frame.frame)
            bpy.context.scene.collection.children.link(collection)
            return sequence_report(self._name, self.request.settings, result, collection, self._start)


def _show_at(obj, frame):
    """Keys that show an object at one frame alone, in views and renders."""
    for name in ("hide_viewport", "hide_render"):
        for when, hidden in ((frame - 1, True), (frame, False), (frame + 1, True)):
            setattr(obj, name, hidden)
            obj.keyframe_insert(name, frame=when)
        setattr(obj, name, bpy.context.scene.frame_current != frame)
