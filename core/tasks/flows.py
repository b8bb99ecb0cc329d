# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of flows in space and on surfaces (paper, Section 3.6)."""

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..errors import SettingError, round_up
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
from ..fields.quantum import STEP, coarse_map, find_quantum, least_quantum, shows_enough
from ..files.flows import ArrayFile
from ..files.volumes import VolumeFile
from ..geometry import TriangleMesh
from ..geometry.grid import Grid
from ..geometry.mesh_input import MeshInput
from ..geometry.surface import Surface
from ..monitor import Callback, Monitor, Result, expect, portion
from ..settings.flow import FlowSettings
from ..solution import COARSE_DIFFUSED
from ..solve import Options
from .flow_costs import COARSE_ROUNDING, MOST_NODES, solve_memory, solve_seconds

# Radius of a filament's tube, and the least of the cores of curves that tubes can surround, in cells of the grid.
_THICKNESS, _CORE_OF_TUBES = 0.25, 2.0
# Faces over which a filament's circulation has to be spread for tubes to have an inside; a core of two cells has 37.
_FACES_OF_TUBES = 20.0
# Filaments that extend over fewer cells are left out.
_STUB = 2.0
# Sampling noise above which vorticity is not resolved, and above which the flow has none.
_NOISE, _IRROTATIONAL = 0.8, 2.0
# Least share of the vorticity that filaments carry without a warning, how far the share of a solve may be below the
# wanted one, and how many solves with smaller circulations follow where it is further below; below this part of the
# wanted share the circulation is halved.
LEAST_SHARE, _SHORTFALL, _MORE_SOLVES, _FAR_BELOW = 0.6, 0.1, 3, 0.5
# Share of the work that the relaxation is counted as in any solve, and of the time that it takes in one of a flow.
_RELAXED, _RELAXED_OF_FLOW = 0.4, 0.8
# Mean number of filaments through a face above which there is a warning.
_MANY_QUANTA = 0.25


def check_grid(grid: Grid, name: object) -> None:
    """Refuse a grid in a plane, and one whose solve no usual machine can hold; ``name`` is of the source."""
    if grid.dimension != 3:
        raise SettingError(f"{name}: a flow in a plane has no filaments to show: give one in space")
    if grid.node_count > MOST_NODES:
        shape, needed = " x ".join(map(str, grid.shape)), solve_memory(grid.node_count) / 2**30
        raise SettingError(
            f"the grid has {shape} nodes, which take about {needed:.0f} GB: give a lower resolution, or a smaller file"
        )


@dataclass(frozen=True)
class Shown:
    """What is shown of a map in space.

    Attributes
    ----------
    lines, tubes : None where they are not asked for
    quantum : circulation of one filament
    thickness : radius of one, in scene units
    unwrapped : whether filaments are drawn in one piece where they leave a periodic box
    stubs : number of filaments that are left out because they extend over less than two cells
    """

    lines: list[Filament] | None
    tubes: Tubes | None
    quantum: float
    thickness: float
    unwrapped: bool = False
    stubs: int = 0

    @property
    def share(self) -> float | None:
        """The share of the vorticity that the filaments carry; None where they are not asked for."""
        return None if self.lines is None else sum(line.share for line in self.lines)

    @property
    def missing(self) -> tuple[str, ...]:
        """Lines that say what the map does not show, and the remedy."""
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


def extract_vortices(found: ClebschMap, sphere: SphericalMap | None, settings: FlowSettings) -> Shown:
    """The :class:`Shown` that settings ask for; filaments do not need the sphere."""
    grid, lines, tubes, stubs = found.regular_grid, None, None, 0
    if settings.show != "tubes":
        every = filaments(found, settings.smoothing)
        lines = [line for line in every if (np.ptp(line.whole, axis=0) / grid.spacing).max() >= _STUB]
        stubs = len(every) - len(lines)
    if settings.show != "filaments" and sphere is not None:
        tubes = vortex_tubes(sphere, settings.point, settings.opening, settings.smoothing)
    thickness = _THICKNESS * float(grid.spacing.min())
    return Shown(lines, tubes, found.quantum, thickness, settings.unwrapped, stubs)


@dataclass(frozen=True)
class FlowResult:
    """A solved flow, of which every point of the sphere shows other vortices.

    Attributes
    ----------
    found : the map of least energy
    sphere : None for methods without a relaxation
    seen : the map whose vortices are shown
    shown : None on surfaces, which show the map itself
    linked : None where filaments are not shown, or are too many
    warnings : lines that the user should read
    seconds : of parts of the work, by their names
    """

    found: ClebschMap
    sphere: SphericalMap | None
    seen: ClebschMap
    shown: Shown | None
    linked: Linked | None = None
    warnings: tuple[str, ...] = ()
    seconds: dict[str, float] = dataclasses.field(default_factory=dict)

    @classmethod
    def of(
        cls,
        grid: Grid | Surface,
        integrals: np.ndarray,
        settings: FlowSettings,
        progress: Callback | None,
        largest: float | None = None,
        show: Callable[[ClebschMap], object] | None = None,
    ) -> "FlowResult":
        """The maps of a flow with (e,) integrals along the edges; nothing is shown yet.

        ``largest`` is the circulation to try first where one is searched for. ``show`` is called with maps on coarse
        grids, and with the map to the circle before the one to the sphere is solved for.
        """
        quantum, options = settings.quantum, Options.of(settings)
        if len(grid.masses) > COARSE_ROUNDING and options.rounding == FlowSettings.rounding:
            options = replace(options, rounding=COARSE_DIFFUSED)
        more = _MORE_SOLVES if quantum is None else 0
        if quantum is None:
            sought = settings.share, settings.count, largest, settings.seed
            quantum = find_quantum(grid, integrals, *sought, portion(progress, 0.0, 0.1), show)
        elif show is not None:
            coarse = coarse_map(grid, integrals, quantum, settings.seed, portion(progress, 0.0, 0.1))
            if coarse is not None:
                show(coarse)
        is_rough = settings.show == "filaments" and isinstance(grid, Grid)
        end = 0.9 if is_rough else 0.75  # shares of the time
        found = clebsch_map(grid, integrals, quantum, options, _relaxing(portion(progress, 0.1, end - 0.2)))
        least = least_quantum(grid, integrals)
        for number in range(more):
            if settings.count is None:
                share = _shown_share(found, settings)
                is_enough, is_far = share >= settings.share - _SHORTFALL, share < _FAR_BELOW * settings.share
            else:
                is_enough, is_far = shows_enough(found, 0.0, settings.count), False
            if is_enough or STEP * found.quantum < least:
                break
            smaller = float(f"{max((STEP**2 if is_far else STEP) * found.quantum, least):.3g}")
            part = portion(progress, end - 0.1 * (1 - number / more), 0.1 / more)
            found = clebsch_map(grid, integrals, smaller, options, part)
        if show is not None:
            show(found)
        sphere = spherical_map(found, portion(progress, end, 1 - end), is_rough) if settings.method == "sdp" else None
        seconds = {"sphere": sphere.seconds} if sphere else {}
        return cls(found, sphere, found, None, seconds=seconds).seen_from_point(settings)

    def seen_from_point(self, settings: FlowSettings) -> "FlowResult":
        """The result seen from the settings' point of the sphere; None is the map of least energy."""
        if settings.point is None or self.sphere is None:
            return replace(self, seen=self.found)
        return replace(self, seen=self.sphere.seen_from(settings.point))

    @property
    def lean(self) -> "FlowResult":
        """The result without what only solves need: some 200 bytes a node."""
        found = self.found.lean
        sphere = None if self.sphere is None else replace(self.sphere, found=found)
        return replace(self, found=found, sphere=sphere, seen=found.with_phases(self.seen.phases))

    def show_again(self, settings: FlowSettings) -> "FlowResult":
        """The same solve shown with another point, width or smoothing."""
        other = self.seen_from_point(settings)
        if self.shown is None:
            return other
        return replace(other, shown=extract_vortices(other.seen, self.sphere, settings), linked=None)


def _relaxing(callback: Callback | None) -> Callback | None:
    """Derive a callback for a solve of which the relaxation takes most of the time."""
    if callback is None:
        return None
    shares = (0, _RELAXED, 1), (0, _RELAXED_OF_FLOW, 1)
    return lambda stage, fraction: callback(stage, float(np.interp(fraction, *shares)))


def _shown_share(found: ClebschMap, settings: FlowSettings) -> float:
    """The share of the vorticity that a map's filaments carry, in space without those that are left out."""
    if isinstance(found.grid, Grid) and settings.show != "tubes":
        return extract_vortices(found, None, settings).share or 0.0
    return found.vorticity_share or 0.0


@dataclass(frozen=True)
class FilamentPicture:
    """Filaments to draw: (2 k, 3) float32 ends of segments."""

    places: np.ndarray


@dataclass(frozen=True)
class FlowRequest:
    """Vortices of a flow in space."""

    source: ArrayFile | VolumeFile | FilamentCurves
    settings: FlowSettings

    def solve(self, progress: Callback | None = None) -> FlowResult:
        """Read, solve and extract; SettingError for an unusable source, Cancelled when ``progress`` returns False."""
        return self.solve_showing(None, progress)

    def solve_showing(
        self, show: Callable[[FlowResult], object] | None, progress: Callback | None = None
    ) -> FlowResult:
        """:meth:`solve` with intermediate results: filaments on coarse grids, and then those of the whole solve before
        the map to the sphere; ``show`` is called with each. Tubes, and filaments seen from a point of the sphere, need
        that map: they have no intermediate results."""
        settings = self.settings
        grid, integrals, warnings = _run_interruptibly(self._read, "flow", progress)
        is_of_curves = isinstance(self.source, FilamentCurves)
        expect(progress, solve_seconds(grid.node_count, self.settings, is_of_curves=is_of_curves))
        largest = max(abs(c[1]) for c in self.source.curves) if isinstance(self.source, FilamentCurves) else None
        early = None
        if show is not None and settings.show != "tubes" and settings.point is None:
            early = partial(self._show_early, show, grid, warnings)
        result = FlowResult.of(grid, integrals, settings, portion(progress, 0.1, 0.8), largest, early)
        extract = partial(extract_vortices, result.seen, result.sphere, settings)
        shown = _run_interruptibly(extract, "vortices", progress, 0.95)
        winding = None
        if shown.lines is not None:
            box = np.where(grid.periodic, grid.spacing * grid.shape, 0)
            winding = _run_interruptibly(partial(linking_numbers, shown.lines, box), "vortices", progress, 0.98)
            warnings += tuple(self._about_share(result.found, shown, portion(progress, 0.9, 0.1)))
        warnings = (*warnings, *self._about_core(result.found), *_about_quantum(result.found), *shown.missing)
        return replace(result, shown=shown, linked=winding, warnings=warnings)

    def _show_early(
        self, show: Callable[[FlowResult], object], grid: Grid, warnings: tuple[str, ...], found: ClebschMap
    ) -> None:
        """Show the filaments of a map, if it has any, without the map to the sphere and linking numbers."""
        shown = extract_vortices(found, None, self.settings)
        if found.grid is not grid:
            coarse = " x ".join(map(str, found.regular_grid.shape))
            line = f"the solve was ended early: the filaments are those of a coarse grid of {coarse} nodes"
            warnings = (*warnings, line)
        if shown.lines:
            show(FlowResult(found, None, found, shown, None, (*warnings, *shown.missing)))

    def picture(self, result: FlowResult) -> FilamentPicture:
        """The picture of an intermediate result."""
        assert result.shown is not None and result.shown.lines is not None  # see _show_early
        pieces = []
        for line in result.shown.lines:
            pieces += [line.whole] if self.settings.unwrapped or line.is_loop else line.parts
        ends = [np.repeat(piece, 2, axis=0)[1:-1] for piece in pieces]
        return FilamentPicture(np.concatenate([np.empty((0, 3)), *ends]).astype(np.float32))

    def _about_core(self, found: ClebschMap) -> Iterator[str]:
        """A warning where cores are too thin for tubes: those of curves are known, others are measured in the flow."""
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

    def _about_share(self, found: ClebschMap, shown: Shown, progress: Callback | None) -> Iterator[str]:
        """A warning where the filaments carry little of the vorticity, with a circulation that carries more, if any."""
        share = shown.share
        if not found.vorticity or share is None or share >= LEAST_SHARE:
            return
        line, smaller = f"the filaments carry {max(share, 0):.0%} of the vorticity", STEP * found.quantum
        if self.settings.quantum is not None or self.settings.count is not None:
            sought = FlowSettings.share, None, None, self.settings.seed, portion(progress, 0.0, 0.2)
            smaller = min(smaller, find_quantum(found.grid, found.integrals, *sought))
        if smaller < least_quantum(found.grid, found.integrals):
            yield f"{line}, and the grid holds no smaller circulations: give a finer grid, or show tubes"
            return
        smaller = float(f"{smaller:.3g}")
        other = clebsch_map(found.grid, found.integrals, smaller, found.options, portion(progress, 0.2, 0.8))
        if (other.vorticity_share or 0) > share:
            yield f"{line}: with a circulation of {smaller:.3g} they carry {other.vorticity_share:.0%}"
        else:
            yield f"{line}, and with a circulation of {smaller:.3g} not more: give a finer grid, or show tubes"

    def _read(self) -> tuple[Grid, np.ndarray, tuple[str, ...]]:
        flow = self.source.read()
        grid = flow.grid(self.settings.resolution)
        check_grid(grid, self.source.name)
        return grid, flow.integrals(grid), (*flow.warnings, *about_noise(flow.noise))


def about_noise(noise: float | None) -> Iterator[str]:
    """A warning where the vorticity is not that of a flow."""
    if noise is not None and noise > _IRROTATIONAL:
        yield "the flow has no vorticity but for what its sampling makes: its vortices mean nothing, give another flow"
    elif noise is not None and noise > _NOISE:
        yield "the velocities change at random from node to node: the vortices are those of noise, smooth the flow"


def _about_quantum(found: ClebschMap) -> Iterator[str]:
    """A warning where more filaments pass the faces than the phase can separate."""
    mean = mean_circulation(found.grid, found.integrals) / found.quantum
    if mean > _MANY_QUANTA:
        yield (
            f"{mean:.2g} filaments pass a face of the grid on average, and from {MOST_QUANTA:g} on they cannot be told "
            f"apart: give a circulation from {round_up(mean * found.quantum / _MANY_QUANTA)} on, or a finer grid"
        )


def _run_interruptibly(
    work: Callable[[], Result], stage: str, progress: Callback | None, fraction: float = 0.0
) -> Result:
    """The result of work that does not check for cancellation itself."""
    monitor = Monitor(progress)
    monitor.at(stage, fraction)
    return monitor.during(work)


@dataclass(frozen=True)
class SurfaceFlowRequest:
    """The vortices of a flow on a surface: (n, 3) velocities at its vertices, whose tangential part counts."""

    given: MeshInput
    velocity: np.ndarray
    settings: FlowSettings

    @property
    def shared(self) -> tuple[TriangleMesh]:
        """The mesh that the map is on."""
        return (self.given.mesh,)

    def solve(self, progress: Callback | None = None) -> FlowResult:
        """The :class:`FlowResult`; errors as :meth:`FlowRequest.solve`."""
        expect(progress, solve_seconds(self.given.mesh.vertex_count, self.settings, is_surface=True))
        surface = Surface(self.given.mesh, self.given.seam)
        return FlowResult.of(surface, edge_integrals(surface, self.velocity), self.settings, progress)
