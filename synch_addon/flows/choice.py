# SPDX-License-Identifier: GPL-3.0-or-later
"""The choice of a point of the sphere after a solve: other filaments and tubes of the same flow, without solving."""

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import bpy

from ...core.errors import SynchError
from ...core.extract.vortices.tubes import NORTH
from ...core.files.json_text import Json, json_text
from ..blender.objects import no_object
from ..blender.transaction import assign, at_the_end, undone_by, whole_or_nothing
from . import memory
from .report import report_of, result_line


def finish(solved, filled, objects, start):
    """Keep the solve that objects, the last one active, have just been filled with, for :func:`choose_point`; returns
    the report.

    The run began at ``start``, by ``time.perf_counter``.
    """
    solved = replace(solved, fill=filled.fill)
    report = report_of(solved, filled, objects, start)
    if solved.result.sphere is not None:
        at_the_end(lambda: [memory.flows.put(obj, solved) for obj in objects])
    shown = solved.result.shown
    if shown is not None and shown.lines is not None:
        kept = shown.lines, solved.result.linked
        at_the_end(lambda: [memory.shown_filaments.put(obj, kept) for obj in objects])
    if hasattr(bpy.types.Object, "synch_vortices"):  # as long as the extension is registered
        for obj in objects:
            assign(obj.synch_vortices, "sources", json_text(solved.sources))
            _set_sliders(obj.synch_vortices, solved.settings, result_line(report))
    return report


def choose_point(
    obj: bpy.types.Object,
    point: Sequence[float] | None = None,
    *,
    opening: float | None = None,
    smoothing: int | None = None,
) -> Json:
    """Show the vortices that another point of the sphere gives, from the solve that an object shows (Section 4.6).

    All objects of that solve follow: filaments are where the map to the sphere shows the point's antipode, tubes
    around there.

    Parameters
    ----------
    obj : bpy.types.Object, filaments, tubes or a surface with a map that were solved since the file was opened
    point : three numbers, not all 0; None for the filaments of least energy, and tubes seen from the north
    opening : degrees around the antipode that are inside a tube; None for what was chosen before
    smoothing : how often points move to the middle of their neighbours; None as before

    Returns the report; its energy is that of the filaments that are shown.

    Raises SynchError with one line that says what is wrong and the remedy; nothing is changed.
    """
    start = time.perf_counter()
    reason = no_object(obj)
    if reason:
        raise SynchError(reason)
    solved = memory.flows.get(obj)
    present = [found for found in bpy.data.objects if found.session_uid in solved.objects]
    if any(found.mode != "OBJECT" for found in present):
        raise SynchError(f"{obj.name} is being edited: leave its edit mode")
    look = {name: value for name, value in (("opening", opening), ("smoothing", smoothing)) if value is not None}
    settings = replace(_with_present_look(obj, solved.settings), **look, point=point)
    result = solved.result.show_again(settings)
    with whole_or_nothing():
        filled = solved.fill(result, settings, present)
        return finish(replace(solved, settings=settings, result=result), filled, present, start)


def slide(obj):
    """Show the values of an object's sliders, or reset them if these cannot be shown."""
    look = obj.synch_vortices
    try:
        choose_point(obj, tuple(look.point), opening=look.opening, smoothing=look.smoothing)
    except SynchError:
        _set_sliders(look, _with_present_look(obj, memory.flows.get(obj).settings), look.result)


def _with_present_look(obj, settings):
    """The settings of a solve with the look that the object has now: an undo may have changed it."""
    if not hasattr(bpy.types.Object, "synch_vortices"):  # the extension is not registered
        return settings
    return replace(settings, **obj.synch_vortices.figures.get("look", {}))


def _set_sliders(look, settings, line):
    assign(look, "result", "")  # so that setting the sliders asks for nothing
    undone_by(look, partial(setattr, look, "point", tuple(look.point)))
    look.point = settings.point or NORTH
    assign(look, "opening", settings.opening)
    assign(look, "smoothing", settings.smoothing)
    assign(look, "result", line)
