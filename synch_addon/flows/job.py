# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of a flow as objects: filaments as a curve, tubes as a mesh coloured by the sphere (paper, Section 3.6)."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Unpack

import bpy

from ...core.fields.loops import flow_helicity, loop_error
from ...core.files.json_text import Json
from ...core.monitor import Callback
from ...core.settings.flow import FlowSettings
from ...core.settings.keywords import FlowKeywords
from ...core.tasks.flows import FlowRequest
from ...core.validation import check_path, from_names
from ..blender.objects import Selection
from ..blender.transaction import whole_or_nothing
from ..jobs.job import run
from .choice import finish
from .memory import Filled, SolvedFlow
from .objects import facts, fill, linking_facts, make_filaments, make_tubes, present
from .sequence_job import SequenceJob
from .sources import flow_source, objects_of
from .surface_job import SurfaceJob
from .surfaces import surface_flow


class ClebschJob:
    """Filaments and tubes of a flow in space; see :mod:`..jobs.job`."""

    link = None

    def __init__(self, source, settings):
        self._start, self._selection = time.perf_counter(), Selection.now()
        self.request = FlowRequest(flow_source(source, settings.core_cells, settings.attribute), settings)
        objects = [] if isinstance(source, str | Path) else objects_of(source)
        self._objects = tuple(obj.name for obj in objects)

    def write(self, result):
        """Make the objects; returns the report."""
        name, shown, made = self.request.source.name, result.shown, []
        with whole_or_nothing():
            if shown.tubes is not None:
                made.append(make_tubes(f"{name} Tubes", shown))
            if shown.lines is not None:
                made.append(make_filaments(f"{name} Filaments", shown))
            present(made, self._selection)
            numbers = tuple(obj.session_uid for obj in made)
            solved = SolvedFlow(name, self.request.settings, result, fill, numbers, self._objects)
            # How far the number of filaments through a loop is from the flow's circulation along it, in quanta and root
            # mean square over all square loops a quarter of the grid's longest side wide; None where there are none.
            off = {"circulation_error": loop_error(result.seen, max(result.seen.grid.shape) // 4)}
            whole = {"flow_helicity": flow_helicity(result.found.grid, result.found.integrals)}
            figures = facts(shown) | off | whole | linking_facts(result.linked)
            return finish(solved, Filled(figures, fill), made, self._start)


def clebsch(
    source: str | Path | bpy.types.Object | Sequence[bpy.types.Object],
    callback: Callback | None = None,
    **settings: Unpack[FlowKeywords],
) -> Json:
    """Show the vortices of a flow.

    Parameters
    ----------
    source : path of a file that :func:`flow_file` reads, #### for the numbers of frames; a volume object, a mesh object
        with faces, a curve object, or a list of curve objects
    callback : callable(stage, fraction) -> bool, optional; False cancels
    settings : see :class:`FlowSettings`

    Returns the report.

    Raises SynchError with one line that says what is wrong and the remedy; nothing is written.
    """
    return run(job_for(source, from_names(FlowSettings, settings)), callback)


def job_for(source, settings):
    """The job of a source: a :class:`SequenceJob` of frames, a :class:`SurfaceJob` of a surface or plane, otherwise a
    :class:`ClebschJob`."""
    if isinstance(source, str | Path):
        check_path(source)
    bpy.context.view_layer.update()  # a script may have moved or scaled objects just now
    if settings.frames is not None:
        return SequenceJob(source, settings)
    surface = surface_flow(source, settings.attribute, settings.strict)
    return ClebschJob(source, settings) if surface is None else SurfaceJob(surface, settings)
