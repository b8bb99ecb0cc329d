# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of a flow as objects: filaments as a curve, tubes as a mesh coloured by the sphere (paper, Section 3.6)."""

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass
from numbers import Integral, Real
from pathlib import Path

from ...core.errors import SettingError
from ...core.fields.clebsch import clebsch_map, quantum_for, spherical_map
from ...core.keywords import check_choice, check_positive, check_whole, from_names
from ...core.monitor import Monitor
from ..blender.transaction import whole_or_nothing
from ..jobs.jobs import portion
from ..settings.solver import SolverSettings
from .choice import remember
from .objects import facts, fill, make_filaments, make_tubes, missing, present, seen, showing
from .report import SolvedFlow, circulation_error, report_of
from .sequence_job import SequenceJob
from .sources import CORE, VELOCITY, check_grid, check_resolution, flow_source, objects_of
from .surface_job import SurfaceJob
from .surfaces import surface_flow

SHOWN = ("filaments", "tubes", "both")
# Radius of the cores of curves in cells, where their tubes are shown.
_CORE_OF_TUBES = 2.0


@dataclass(frozen=True)
class ClebschSettings(SolverSettings):
    """Settings of the operator, the command line and the API alike, besides those of the solver.

    Attributes
    ----------
    show : "filaments", "tubes" or "both"
    resolution : nodes along the longest side that files and curves are resampled to
    count : filaments through the plane of the grid with most vorticity, unless a quantum is given
    quantum : circulation of one filament, None for one that makes ``count`` of them
    core : radius over which the vorticity of curves is spread, in cells; None for half a cell, and two where tubes are
        shown, which are nothing without an inside
    attribute : velocity on the vertices of a mesh, which then shows the map itself; or the grid of a volume, where
        "velocity" also stands for vel, v, or the only grid of vectors
    point : of the sphere, from which tubes are seen: they are around where the map shows its antipode; for filaments
        None shows the best map, a point the projection along it
    opening : degrees around the antipode that are inside a tube
    smoothing : how often points of filaments, and vertices of tubes, move to the middle of their neighbours
    frames : first and last frame of a sequence, None for what the source is now
    """

    show: str = "filaments"
    resolution: int = 48
    count: float = 4.0
    quantum: float | None = None
    core: float | None = None
    attribute: str = VELOCITY
    point: tuple[float, float, float] | None = None
    opening: float = 60.0
    smoothing: int = 5
    frames: tuple[int, int] | None = None

    def __post_init__(self):
        super().__post_init__()
        check_choice(self, "show", SHOWN)
        check_positive(self, "count", "opening", optional=("quantum", "core"))
        check_whole(self, "smoothing")
        if self.frames is not None:
            if not _are(Integral, 2, self.frames):
                raise SettingError(f"the frames are {self.frames!r}: give the first and the last one, whole numbers")
            first, last = self.frames
            if first > last:
                raise SettingError(f"the frames {first} to {last} are none: give the first one first")
        if self.opening >= 180:
            raise SettingError(f"the opening is {self.opening:g} degrees: the whole sphere has 180, give less")
        if self.point is not None:
            if not (_are(Real, 3, self.point) and all(map(math.isfinite, self.point)) and any(self.point)):
                raise SettingError(f"the point of the sphere is {self.point!r}: give three numbers that are not all 0")
            object.__setattr__(self, "point", tuple(map(float, self.point)))
        if (self.show != "filaments" or self.point is not None) and self.method != "sdp":
            raise SettingError("tubes and points of the sphere come from the relaxation: use the method sdp")


def _are(kind, count, values):
    """Whether values are so many of a kind."""
    values = list(values) if isinstance(values, Iterable) else []
    return len(values) == count and all(isinstance(value, kind) for value in values)


class ClebschJob:
    """One run in three steps: what Blender's data is needed for is read when it is made, :meth:`solve` may run in
    another thread, :meth:`write` makes objects."""

    def __init__(self, source, settings):
        self._start = time.perf_counter()
        self.settings = settings
        check_resolution(settings.resolution)
        core = settings.core or (CORE if settings.show == "filaments" else _CORE_OF_TUBES)
        self._source = flow_source(source, core, settings.attribute)
        objects = [] if isinstance(source, str | Path) else objects_of(source)
        self._objects = tuple(obj.name for obj in objects)

    def solve(self, callback=None):
        """Solve for the map and, where the method can, the sphere.

        Raises
        ------
        Cancelled
            when the callback returns False
        SettingError
            with one line that says what is wrong with the source
        """
        settings = self.settings
        grid, integrals = _interruptible(self._read, "flow", callback)
        quantum = settings.quantum
        if quantum is None:
            quantum = quantum_for(grid, integrals, settings.count)
        found = clebsch_map(grid, integrals, quantum, settings.options, portion(callback, 0.1, 0.7))
        sphere = spherical_map(found, portion(callback, 0.8, 0.15)) if settings.method == "sdp" else None
        self._seen = seen(found, sphere, settings.point)
        self._shown = _interruptible(lambda: showing(self._seen, sphere, settings), "vortices", callback, 0.95)
        warnings = [*self._source.warnings, *missing(self._shown)]
        self._solved = SolvedFlow(self._source.name, found, sphere, settings, warnings, self._objects)

    def _read(self):
        grid = self._source.grid(self.settings.resolution)
        check_grid(grid, self._source.name)
        return grid, self._source.integrals(grid)

    def write(self):
        """Make the objects; returns the report."""
        solved, shown = self._solved, self._shown
        made = []
        with whole_or_nothing():
            if shown.tubes is not None:
                made.append(make_tubes(f"{solved.name} Tubes", shown))
            if shown.lines is not None:
                made.append(make_filaments(f"{solved.name} Filaments", shown))
        present(made)
        report = report_of(solved, self._seen, made, self._start) | facts(shown)
        report["circulation_error"] = circulation_error(self._seen)
        remember(solved, made, report, fill)
        return report


def _interruptible(work, stage, callback, fraction=0.0):
    """The result of work that asks nobody whether it should stop; it is left behind when it should."""
    monitor = Monitor(callback)
    monitor.at(stage, fraction)
    return monitor.during(work)


def clebsch(source, callback=None, **settings):
    """Show the vortices of a flow.

    Parameters
    ----------
    source : path of a .vdb or .npz file, #### for the numbers of frames; a volume object, a mesh object with faces, a
        curve object, or a list of curve objects
    callback : callable(stage, fraction) -> bool, optional; False cancels
    settings : see :class:`ClebschSettings`

    Returns
    -------
    dict, the report

    Raises
    ------
    SynchError
        with one line that says what is wrong and the remedy; nothing is written
    """
    job = job_for(source, from_names(ClebschSettings, settings))
    job.solve(callback)
    return job.write()


def job_for(source, settings):
    """The job of a source: a :class:`SequenceJob` of frames, a :class:`SurfaceJob` of a surface or plane, otherwise a
    :class:`ClebschJob`."""
    if settings.frames is not None:
        return SequenceJob(source, settings)
    surface = surface_flow(source, settings.attribute)
    return ClebschJob(source, settings) if surface is None else SurfaceJob(surface, settings)
