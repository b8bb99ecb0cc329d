# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of flows in space and on surfaces (paper, Section 3.6)."""

import dataclasses
import time
from dataclasses import dataclass, replace
from numbers import Integral

import numpy as np

from ..errors import SettingError
from ..extract.vortices.filaments import Filament, filaments
from ..extract.vortices.linking_numbers import Linked, linking_numbers
from ..extract.vortices.tubes import Tubes, vortex_tubes
from ..fields.biot_savart import FilamentCurves
from ..fields.clebsch import (
    MOST_QUANTA,
    ClebschMap,
    SphericalMap,
    clebsch_map,
    edge_integrals,
    faces_of_filament,
    mean_circulation,
    spherical_map,
)
from ..fields.quantum import STEP, find_quantum, least_quantum, shows_enough
from ..files.flows import ArrayFile
from ..files.volumes import VolumeFile
from ..geometry.mesh_input import MeshInput
from ..geometry.surface import Surface
from ..monitor import Monitor, portion
from ..settings.flow import FlowSettings
from ..solution import COARSE
from ..solve import Options

# Radius of a filament's tube, and of the cores of curves that tubes can be around, in cells of the grid.
_THICKNESS, _CORE_OF_TUBES = 0.25, 2.0
# Faces that a filament's circulation is spread over from which on tubes have an inside; with two cells it has 37.
_FACES_OF_TUBES = 20.0
# Cells that a filament has to extend over.
_STUB = 2.0
# Sampling noise from which on vorticity is not resolved, and from which on there is none.
_NOISE, _IRROTATIONAL = 0.8, 2.0
# Share of the vorticity below which filaments are warned of, how far that of a solve may be below the wanted one, and
# solves with smaller circulations that are made where it is.
LEAST_SHARE, _SHORTFALL, _MORE_SOLVES = 0.6, 0.1, 2
# Filaments that pass a face on average, from which on there is a warning.
_MANY_QUANTA = 0.25
# Nodes from which on fields are searched for on a coarse stage: in half the time, with some per mille more energy.
_COARSE_ROUNDING = 60_000
# Seconds that a solve takes for each node, about, on one core: up to so many nodes, and beyond.
_NODE_SECONDS, _LARGE_NODE_SECONDS = 3e-4, 1.5e-4
# Bytes that a solve takes for each node with a proved bound, which is tried up to so many nodes, and without; and the
# most nodes, 47 GB.
_PROVED, _PROVED_NODES, _ESTIMATED, _MOST_NODES = 22_000, 36_000, 5_000, 10_000_000


def solve_memory(nodes):
    """Bytes that a solve takes at its peak, measured on 24^3 to 64^3 nodes."""
    return nodes * (_PROVED if nodes <= _PROVED_NODES else _ESTIMATED)


def check_resolution(resolution):
    """Refuse a resolution that nothing can be seen at."""
    if not isinstance(resolution, Integral) or resolution < 8:
        raise SettingError(f"a resolution of {resolution!r} nodes shows no vortex: give a whole number from 8 on")


def check_grid(grid, name):
    """Refuse the grid of a source if it lies in a plane, or if no usual machine can hold a solve of it."""
    if grid.dimension != 3:
        raise SettingError(f"{name}: a flow in a plane has no filaments to show: give one in space")
    if grid.node_count > _MOST_NODES:
        shape, needed = " x ".join(map(str, grid.shape)), solve_memory(grid.node_count) / 2**30
        raise SettingError(
            f"the grid has {shape} nodes, which take about {needed:.0f} GB: give a lower resolution, or a smaller file"
        )


@dataclass(frozen=True)
class Shown:
    """What is shown of a map in space.

    Attributes
    ----------
    lines : list of Filament, or None where they are not asked for
    tubes : Tubes, or None
    quantum : circulation of one filament
    thickness : radius of one, in scene units
    unwrapped : whether filaments are drawn on beyond the sides of a periodic box
    stubs : filaments that are left out, as they extend over less than two cells
    """

    lines: list[Filament] | None
    tubes: Tubes | None
    quantum: float
    thickness: float
    unwrapped: bool = False
    stubs: int = 0

    @property
    def share(self):
        """What of the vorticity the filaments carry; None where they are not asked for."""
        return None if self.lines is None else sum(line.share for line in self.lines)

    @property
    def missing(self):
        """Lines that say what the map shows nothing of, and the remedy."""
        remedy, lines = "ask for more filaments, or a smaller circulation of each", []
        if self.lines == []:
            lines.append(f"the map has no filaments: {remedy}")
        if self.stubs:
            what = "a filament is" if self.stubs == 1 else f"{self.stubs} filaments are"
            lines.append(f"{what} left out, no longer than two cells of the grid: a finer grid shows more")
        if self.tubes is not None and not len(self.tubes.triangles):
            lines.append(f"the map does not come so near to the point's antipode: make the tubes wider, or {remedy}")
        elif self.tubes is not None and self.tubes.blobs:
            lines.append(
                f"{self.tubes.blobs} of {self.tubes.pieces} tubes are blobs, around no filament: give a smaller "
                "circulation or a finer grid, or show filaments, whose tubes have one thickness"
            )
        return tuple(lines)


def showing(found, sphere, settings):
    """The :class:`Shown` that settings ask for; the sphere may be missing where there are only filaments."""
    lines, tubes, stubs = None, None, 0
    if settings.show != "tubes":
        every = filaments(found, settings.smoothing)
        least = _STUB * found.grid.spacing.max()
        lines = [line for line in every if np.ptp(line.whole, axis=0).max() >= least]
        stubs = len(every) - len(lines)
    if settings.show != "filaments":
        tubes = vortex_tubes(sphere, settings.point, settings.opening, settings.smoothing)
    thickness = _THICKNESS * float(found.grid.spacing.min())
    return Shown(lines, tubes, found.quantum, thickness, settings.unwrapped, stubs)


@dataclass(frozen=True)
class FlowResult:
    """A solved flow, of which every point of the sphere shows other vortices.

    Attributes
    ----------
    found : ClebschMap, the best
    sphere : SphericalMap, None for methods without a relaxation
    seen : ClebschMap whose vortices are shown
    shown : Shown, None on surfaces, which show the map itself
    linked : Linked, how the filaments of the solve wind; None where they are not shown, or too many
    warnings : lines that the user should read
    seconds : that the map to the sphere took
    """

    found: ClebschMap
    sphere: SphericalMap | None
    seen: ClebschMap
    shown: Shown | None
    linked: Linked | None = None
    warnings: tuple[str, ...] = ()
    seconds: dict[str, float] = dataclasses.field(default_factory=dict)

    @classmethod
    def of(cls, grid, integrals, settings, progress, largest=None):
        """The maps of a flow, by its (e,) integrals along the edges of a Grid or Surface; nothing is shown yet.

        ``largest`` is the circulation that is tried first where one is looked for.
        """
        quantum, options = settings.quantum, Options.of(settings)
        if len(grid.masses) > _COARSE_ROUNDING and options.rounding == FlowSettings.rounding:
            options = replace(options, rounding=COARSE)
        more = _MORE_SOLVES if quantum is None else 0
        if quantum is None:
            sought = settings.share, settings.count, largest, settings.seed
            quantum = find_quantum(grid, integrals, *sought, portion(progress, 0.0, 0.1))
        found = clebsch_map(grid, integrals, quantum, options, portion(progress, 0.1, 0.35))
        least = least_quantum(grid, integrals)
        for number in range(more):
            if shows_enough(found, settings.share - _SHORTFALL, settings.count) or STEP * found.quantum < least:
                break
            smaller = float(f"{STEP * found.quantum:.3g}")
            found = clebsch_map(grid, integrals, smaller, options, portion(progress, 0.45 + 0.15 * number, 0.15))
        sphere = spherical_map(found, portion(progress, 0.8, 0.2)) if settings.method == "sdp" else None
        return cls(found, sphere, found, None, None, (), {"sphere": sphere.seconds} if sphere else {}).seeing(settings)

    def seeing(self, settings):
        """The map that the settings' point of the sphere gives, the best one for None."""
        if settings.point is None or self.sphere is None:
            return replace(self, seen=self.found)
        return replace(self, seen=self.sphere.seen_from(settings.point))

    @property
    def lean(self):
        """The same with maps that are there to be seen, at some 200 bytes a node."""
        found = self.found.lean
        sphere = None if self.sphere is None else replace(self.sphere, found=found)
        return replace(self, found=found, sphere=sphere, seen=found.showing(self.seen.phases))

    def again(self, settings):
        """What another point, width or smoothing shows of the same solve."""
        other = self.seeing(settings)
        if self.shown is None:
            return other
        return replace(other, shown=showing(other.seen, self.sphere, settings), linked=None)


@dataclass(frozen=True)
class FlowRequest:
    """Vortices of a flow in space. Raises SettingError for a resolution that shows nothing.

    Attributes
    ----------
    source : what the flow is read from
    settings : FlowSettings
    """

    source: ArrayFile | VolumeFile | FilamentCurves
    settings: FlowSettings

    def __post_init__(self):
        check_resolution(self.settings.resolution)

    @property
    def shared(self):
        """Nothing: the grid is known once the flow is read."""
        return ()

    def solve(self, progress=None):
        """The :class:`FlowResult`.

        Raises Cancelled when the progress is answered with False; SettingError with one line that says what is wrong
        with the source.
        """
        settings = self.settings
        grid, integrals, warnings = _interruptible(self._read, "flow", progress)
        each = _LARGE_NODE_SECONDS if grid.node_count > _COARSE_ROUNDING else _NODE_SECONDS
        progress = _with_estimate(progress, each * grid.node_count)
        largest = max(abs(c[1]) for c in self.source.curves) if isinstance(self.source, FilamentCurves) else None
        result = FlowResult.of(grid, integrals, settings, portion(progress, 0.1, 0.8), largest)
        shown = _interruptible(lambda: showing(result.seen, result.sphere, settings), "vortices", progress, 0.95)
        winding = None
        if shown.lines is not None:
            box = np.where(grid.periodic, grid.spacing * grid.shape, 0)
            winding = _interruptible(lambda: linking_numbers(shown.lines, box), "vortices", progress, 0.98)
            warnings += tuple(self._about_share(result.found, shown, portion(progress, 0.9, 0.1)))
        warnings = (*warnings, *self._about_core(result.found), *_about_quantum(result.found), *shown.missing)
        return replace(result, shown=shown, linked=winding, warnings=warnings)

    def _about_core(self, found):
        """A line where cores are too thin for tubes: those of curves are known, others are looked for in the flow."""
        if self.settings.show == "filaments":
            return
        cells, remedy = self.settings.core_cells, "or show filaments, whose tubes have one thickness"
        if isinstance(self.source, FilamentCurves):
            if cells < _CORE_OF_TUBES:
                yield (
                    f"tubes have an inside from a core of {_CORE_OF_TUBES:g} cells on, and it is {cells:g}: increase "
                    f"the core, {remedy}"
                )
            return
        faces = faces_of_filament(found.grid, found.integrals, found.quantum)
        if faces < _FACES_OF_TUBES:
            yield (
                f"the circulation of a filament is spread over {faces:.2g} faces of the grid, and tubes have an inside "
                f"from about {_FACES_OF_TUBES:g} on: give a finer grid, {remedy}"
            )

    def _about_share(self, found, shown, progress):
        """A line where the filaments carry little of the vorticity, with a circulation that this solve carries more
        with, if there is one."""
        if not found.vorticity or shown.share >= LEAST_SHARE:
            return
        line, smaller = f"the filaments carry {max(shown.share, 0):.0%} of the vorticity", STEP * found.quantum
        if self.settings.quantum is not None or self.settings.count is not None:
            sought = FlowSettings.share, None, None, self.settings.seed, portion(progress, 0.0, 0.2)
            smaller = min(smaller, find_quantum(found.grid, found.integrals, *sought))
        if smaller < least_quantum(found.grid, found.integrals):
            yield f"{line}, and the grid holds no smaller circulations: give a finer grid, or show tubes"
            return
        smaller = float(f"{smaller:.3g}")
        other = clebsch_map(found.grid, found.integrals, smaller, found.options, portion(progress, 0.2, 0.8))
        if (other.vorticity_share or 0) > shown.share:
            yield f"{line}: with a circulation of {smaller:.3g} they carry {other.vorticity_share:.0%}"
        else:
            yield f"{line}, and with a circulation of {smaller:.3g} not more: give a finer grid, or show tubes"

    def _read(self):
        flow = self.source.read()
        grid = flow.grid(self.settings.resolution)
        check_grid(grid, self.source.name)
        return grid, flow.integrals(grid), (*flow.warnings, *about_noise(flow.noise))


def about_noise(noise):
    """A line where the vorticity is not that of a flow."""
    if noise is not None and noise > _IRROTATIONAL:
        yield "the flow has no vorticity but for what its sampling makes: its vortices mean nothing, give another flow"
    elif noise is not None and noise > _NOISE:
        yield "the velocities change at random from node to node: the vortices are those of noise, smooth the flow"


def _about_quantum(found):
    """A line where so many filaments pass the faces that the phase can hardly tell them apart."""
    mean = mean_circulation(found.grid, found.integrals) / found.quantum
    if mean > _MANY_QUANTA:
        yield (
            f"{mean:.2g} filaments pass a face of the grid on average, and from {MOST_QUANTA:g} on they cannot be told "
            f"apart: give a circulation from {mean * found.quantum / _MANY_QUANTA:.3g} on, or a finer grid"
        )


def _with_estimate(progress, seconds):
    """A callback whose stages say about how many seconds are left, from the number that a solve usually takes."""
    if progress is None:
        return None
    begin = time.perf_counter()

    def told(stage, fraction):
        left = seconds - (time.perf_counter() - begin)
        return progress(f"{stage}, about {left:.0f} s left" if left >= 1 else stage, fraction)

    return told


def _interruptible(work, stage, progress, fraction=0.0):
    """The result of work that asks nobody whether it should stop; it is left behind when it should."""
    monitor = Monitor(progress)
    monitor.at(stage, fraction)
    return monitor.during(work)


@dataclass(frozen=True)
class SurfaceFlowRequest:
    """The map and the vortices of a flow on a surface.

    Attributes
    ----------
    given : the mesh
    velocity : (n, 3) at its vertices, of which the tangential part counts
    settings : FlowSettings
    """

    given: MeshInput
    velocity: np.ndarray
    settings: FlowSettings

    @property
    def shared(self):
        """The mesh that the map is on."""
        return (self.given.mesh,)

    def solve(self, progress=None):
        """The :class:`FlowResult`; errors as :meth:`FlowRequest.solve`."""
        surface = Surface(self.given.mesh, self.given.seam)
        return FlowResult.of(surface, edge_integrals(surface, self.velocity), self.settings, progress)
