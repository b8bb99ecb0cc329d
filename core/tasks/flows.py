# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of flows in space and on surfaces (paper, Section 3.6)."""

import dataclasses
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
    quantum_for,
    spherical_map,
)
from ..files.flows import ArrayFile, VolumeFile
from ..geometry.mesh_input import MeshInput
from ..geometry.surface import Surface
from ..monitor import Monitor, portion
from ..settings.flow import FlowSettings
from ..solve import Options

# Radius of a filament's tube, and of the cores of curves that tubes can be around, in cells of the grid.
_THICKNESS, _CORE_OF_TUBES = 0.25, 2.0
# Faces that a filament's circulation is spread over from which on tubes have an inside; with two cells it has 37.
_FACES_OF_TUBES = 20.0
# How often a circulation is halved to find one that gives filaments.
_HALVINGS = 6
# Filaments that pass a face on average, from which on there is a warning.
_MANY_QUANTA = 0.25
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
    """

    lines: list[Filament] | None
    tubes: Tubes | None
    quantum: float
    thickness: float
    unwrapped: bool = False

    @property
    def missing(self):
        """Lines that say what the map shows nothing of, and the remedy."""
        remedy, lines = "ask for more filaments, or a smaller circulation of each", []
        if self.lines == []:
            lines.append(f"the map has no filaments: {remedy}")
        if self.tubes is not None and not len(self.tubes.triangles):
            lines.append(f"the map does not come so near to the point's antipode: make the tubes wider, or {remedy}")
        return tuple(lines)


def showing(found, sphere, settings):
    """The :class:`Shown` that settings ask for; the sphere may be missing where there are only filaments."""
    lines = filaments(found, settings.smoothing) if settings.show != "tubes" else None
    tubes = None
    if settings.show != "filaments":
        tubes = vortex_tubes(sphere, settings.point, settings.opening, settings.smoothing)
    thickness = _THICKNESS * float(found.grid.spacing.min())
    return Shown(lines, tubes, found.quantum, thickness, settings.unwrapped)


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
    def of(cls, grid, integrals, settings, progress):
        """The maps of a flow, by its (e,) integrals along the edges of a Grid or Surface; nothing is shown yet."""
        quantum = settings.quantum
        if quantum is None:
            quantum = quantum_for(grid, integrals, settings.count)
        found = clebsch_map(grid, integrals, quantum, Options.of(settings), portion(progress, 0.0, 0.8))
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
    """Vortices of a flow in space.

    Attributes
    ----------
    source : what the flow is read from
    settings : FlowSettings

    Raises
    ------
    SettingError
        for a resolution that shows nothing
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

        Raises
        ------
        Cancelled
            when the progress is answered with False
        SettingError
            with one line that says what is wrong with the source
        """
        settings = self.settings
        grid, integrals, warnings = _interruptible(self._read, "flow", progress)
        result = FlowResult.of(grid, integrals, settings, portion(progress, 0.1, 0.85))
        shown = _interruptible(lambda: showing(result.seen, result.sphere, settings), "vortices", progress, 0.95)
        winding = None
        if shown.lines is not None:
            box = np.where(grid.periodic, grid.spacing * grid.shape, 0)
            winding = _interruptible(lambda: linking_numbers(shown.lines, box), "vortices", progress, 0.98)
            if not shown.lines:
                warnings += _interruptible(lambda: _about_nothing(result.found), "vortices", progress, 0.99)
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

    def _read(self):
        flow = self.source.read()
        grid = flow.grid(self.settings.resolution)
        check_grid(grid, self.source.name)
        return grid, flow.integrals(grid), flow.warnings


def _about_nothing(found):
    """Lines that say why there is no filament, and which circulation gives some: the largest half, quarter ... of which
    the quickest solve finds any."""
    most = quantum_for(found.grid, found.integrals, 1)
    line = (
        f"a filament of {found.quantum:.3g} has {found.quantum / most:.0%} of what passes the plane with most vorticity"
    )
    for halving in range(1, _HALVINGS + 1):
        quantum = found.quantum / 2**halving
        try:
            other = clebsch_map(found.grid, found.integrals, quantum, Options(method="spectral"))
        except SettingError:  # too many for the grid
            break
        if other.face_numbers.any():
            return (f"{line}: with a circulation of {quantum:.3g} there are some",)
    return (line,)


def _about_quantum(found):
    """A line where so many filaments pass the faces that the phase can hardly tell them apart."""
    mean = mean_circulation(found.grid, found.integrals) / found.quantum
    if mean > _MANY_QUANTA:
        yield (
            f"{mean:.2g} filaments pass a face of the grid on average, and from {MOST_QUANTA:g} on they cannot be told "
            f"apart: give a circulation from {mean * found.quantum / _MANY_QUANTA:.3g} on, or a finer grid"
        )


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
