# SPDX-License-Identifier: GPL-3.0-or-later
"""The choice of a point of the sphere after a solve: other filaments and tubes of the same flow, without solving."""

import json
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, replace

import bpy

from ...core.errors import SynchError
from . import memory
from .objects import NORTH, seen
from .report import SolvedFlow, report_of, result_line

_filling = False


@dataclass(frozen=True)
class KeptFlow:
    """A solve and what shows it.

    Attributes
    ----------
    solved : SolvedFlow
    objects : their session numbers
    fill : callable(SolvedFlow, ClebschMap, objects) that shows a map in them and returns facts for the report
    """

    solved: SolvedFlow
    objects: tuple[int, ...]
    fill: Callable


def remember(solved, made, report, fill):
    """Keep the solve that objects show, for :func:`choose_point`, and what their panel says; see :class:`KeptFlow`."""
    if solved.sphere is not None:
        kept = KeptFlow(solved, tuple(obj.session_uid for obj in made), fill)
        for obj in made:
            memory.flows.put(obj, kept)
    _set_panels(made, solved, report)


def choose_point(obj, point=None, *, opening=None, smoothing=None):
    """Show the vortices that another point of the sphere gives, from the solve that an object shows (Section 4.6).

    All objects of that solve follow: filaments are where the map to the sphere shows the point's antipode, tubes
    around there.

    Parameters
    ----------
    obj : bpy.types.Object, filaments, tubes or a surface with a map that were solved since the file was opened
    point : three numbers, not all 0; None for the filaments of least energy, and tubes seen from the north
    opening : degrees around the antipode that are inside a tube; None for what was chosen before
    smoothing : how often points move to the middle of their neighbours; None as before

    Returns
    -------
    dict, the report; its energy is that of the filaments that are shown

    Raises
    ------
    SynchError
        with one line that says what is wrong and the remedy; nothing is changed
    """
    start = time.perf_counter()
    kept = memory.flows.get(obj)
    present = [found for found in bpy.data.objects if found.session_uid in kept.objects]
    if any(found.mode != "OBJECT" for found in present):
        raise SynchError(f"{obj.name} is being edited: leave its edit mode")
    solved = kept.solved
    look = {name: value for name, value in (("opening", opening), ("smoothing", smoothing)) if value is not None}
    solved = replace(solved, settings=replace(_shown(obj, solved.settings), **look, point=point))
    mapped = seen(solved.found, solved.sphere, solved.settings.point)
    facts = kept.fill(solved, mapped, present)
    for found in present:
        memory.flows.put(found, replace(kept, solved=solved))
    report = report_of(solved, mapped, present, start) | facts
    _set_panels(present, solved, report)
    return report


def slide(obj):
    """Show what the sliders of an object are set to, or set them back where that cannot be shown."""
    look = obj.synch_vortices
    try:
        choose_point(obj, tuple(look.point), opening=look.opening, smoothing=look.smoothing)
    except SynchError:
        _set_sliders(look, _shown(obj, memory.flows.get(obj).solved.settings))


def _shown(obj, settings):
    """The settings with the look that an object has now: an undo changes that, but not what is kept of the solve."""
    if not hasattr(bpy.types.Object, "synch_vortices"):  # the extension is not registered
        return settings
    return replace(settings, **obj.synch_vortices.figures["look"])


def is_filling():
    """Whether the sliders are being set to what is shown, which asks for nothing."""
    return _filling


@contextmanager
def _quietly():
    global _filling
    _filling = True
    try:
        yield
    finally:
        _filling = False


def _set_panels(objects, solved, report):
    if not hasattr(bpy.types.Object, "synch_vortices"):  # the extension is not registered
        return
    for obj in objects:
        look = obj.synch_vortices
        _set_sliders(look, solved.settings)
        look.result, look.sources = result_line(report), json.dumps(solved.sources)


def _set_sliders(look, settings):
    with _quietly():
        look.point = settings.point or NORTH
        look.opening, look.smoothing = settings.opening, settings.smoothing
