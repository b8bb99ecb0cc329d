# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths for a tool on solved layers, and the pattern on a regular grid."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from ..errors import SettingError, quote_value
from ..extract.layers.defect_curves import DefectCurve
from ..extract.layers.surfaces import LayerSurfaces
from ..extract.layers.voxels import points_inside
from ..fields.evenness import quantiles
from ..fields.layers import RARE, LayerPattern, Spacings
from ..geometry import TriangleMesh
from ..geometry.tet_mesh import TetMesh
from ..interpolate_solid import TetPhases, evaluate_in_tets
from ..monitor import Callback, Monitor, expect
from ..printing.beads import Beads, contour_beads, plane_beads
from ..printing.flat import is_flat
from ..printing.heights import sample_distances
from ..printing.infill import sparse_beads
from ..printing.machine import Machine
from ..printing.plan import PrintPlan, print_plan
from ..validation import check_choice, convert_value

# Approximate seconds on one core for each square of the step, of which beads take a share and order and reach the rest:
# on layers along an axis, and on others, whose beads have to be searched for what they meet; and for each voxel.
_FLAT, _CURVED, _FLAT_BEADS, _CURVED_BEADS, _VOXEL = 3e-4, 3e-3, 0.7, 0.2, 1e-6
FILLS = ("contour", "across-x", "across-y", "across-z")
# A microsecond and four bytes each.
MOST_VOXELS = 50_000_000
# Outside of the solid; half way between layers inside.
NOTHING, _LEAST = -1.0, np.nextafter(np.float32(-1), np.float32(0))


@dataclass(frozen=True)
class PathSettings:
    """Which paths a tool follows on each layer.

    Attributes
    ----------
    step : distance between paths in scene units; None for the machine's bore, or the mean spacing of the layers
    fill : "contour" for paths inside one another, the first half a step from the rim, and one along the middle of the
        remaining space; "across-x" and so on for paths in planes across an axis of the object, a step apart
    machine : its ``walls``, ``skins`` and ``infill`` say where contours fill the solid
    """

    step: float | None = None
    fill: str = "contour"
    machine: Machine = field(default_factory=Machine)

    def __post_init__(self) -> None:
        convert_value("fill", str, self.fill)
        check_choice(self, "fill", FILLS)
        if self.fill != FILLS[0] and self.machine.infill < 1:
            raise SettingError(f"an infill of {self.machine.infill:g} needs walls: choose the fill {FILLS[0]}")
        if self.step is not None and not 0 < convert_value("step", float, self.step) < math.inf:
            raise SettingError(f"the step between paths is {quote_value(self.step)}: give a positive number")


@dataclass(frozen=True)
class Layering:
    """Layers that were solved in a solid, and where they are.

    Attributes
    ----------
    pattern : its mesh is the solid in scene units, along the object's axes: with the object's scale, without its place
        and turn
    surfaces, curves : in the solid's space
    matrix : (4, 4) from the solid's space to the world: the place, turn and mirroring of the object
    """

    pattern: LayerPattern
    surfaces: LayerSurfaces
    curves: tuple[DefectCurve, ...]
    matrix: np.ndarray

    @property
    def solid(self) -> TetMesh:
        return self.pattern.mesh

    @property
    def spacing(self) -> float:
        """Mean distance of the layers; the solid's diagonal where there is no distance to measure."""
        mean = float(self.pattern.spacings.mean)
        return mean if math.isfinite(mean) else float(np.linalg.norm(np.ptp(self.solid.vertices, axis=0)))

    @property
    def spacings(self) -> Spacings:
        """Statistics of the distances between the layers; where layers end inside, along rays from layer to layer: past
        the end of a layer they reach the next but one, which gradients of the phase do not show."""
        found = self.pattern.spacings
        if not found.counted or not self.pattern.tet_phases.punctured.any():
            return found
        distances, counted = sample_distances(self.surfaces, self.solid, self.spacing)
        if not len(distances):
            return found
        thinnest, thickest = quantiles(distances, np.ones(len(distances)), [RARE, 1 - RARE])
        return replace(
            found,
            mean=float(distances.mean()),
            deviation=float(distances.std()),
            thinnest=float(thinnest),
            thickest=float(thickest),
            counted=counted,
        )

    def paths(self, settings: PathSettings) -> "PathsRequest":
        """The request for paths with these settings."""
        step = settings.step
        if step is None:
            machine = settings.machine
            step = machine.bore / machine.scale if machine.bore else self.spacing
        return PathsRequest(self.surfaces, self.solid, self.matrix, float(step), self.spacing, settings)

    def voxels(self, resolution: int) -> "VoxelsRequest":
        """The request for a grid with this number of voxels along its longest side."""
        return VoxelsRequest(self.solid, self.pattern.tet_phases, resolution)


@dataclass(frozen=True)
class PathsRequest:
    """Paths to make, ``step`` apart in scene units; arrays as in :class:`Layering`."""

    surfaces: LayerSurfaces
    solid: TetMesh
    matrix: np.ndarray
    step: float
    spacing: float
    settings: PathSettings

    @property
    def shared(self) -> tuple[TriangleMesh]:
        """The mesh of the layers, which the paths are on."""
        return (self.surfaces.mesh,)

    def solve(self, progress: Callback | None = None) -> PrintPlan:
        """Plan the print; SettingError for a step that is wider than every layer or makes too many points, Cancelled
        when ``progress`` returns False."""
        monitor, share = Monitor(progress), _FLAT_BEADS if is_flat(self.surfaces) else _CURVED_BEADS
        expect(progress, self.seconds)
        monitor.at("tool paths", 0.0)
        beads = monitor.during(self._make_beads)
        if len(beads.lines.sizes) == 0:
            raise SettingError(f"no path of the step {self.step:g} fits on a layer: reduce it")
        monitor.at("order and reach", share)
        return monitor.during(lambda: self._plan(beads))

    @property
    def seconds(self) -> float:
        """About how long it takes on one core."""
        squares = float(self.surfaces.areas.sum()) / self.step / self.step
        return squares * (_FLAT if is_flat(self.surfaces) else _CURVED)

    def _make_beads(self) -> Beads:
        fill, machine = self.settings.fill, self.settings.machine
        if fill == "contour":
            beads = contour_beads(self.surfaces, self.step)
            if machine.infill == 1 or not len(beads.lines.sizes):
                return beads
            return sparse_beads(self.surfaces, self.solid, beads, self.step, self.spacing, machine)
        return plane_beads(self.surfaces, self.surfaces.vertices[:, "xyz".index(fill[-1])], self.step)

    def _plan(self, beads: Beads) -> PrintPlan:
        machine = self.settings.machine
        return print_plan(self.surfaces, self.solid, beads, self.matrix, machine, self.step, self.spacing)


@dataclass(frozen=True)
class VoxelsRequest:
    """A grid of the pattern to make; SettingError for a resolution that makes too many voxels."""

    solid: TetMesh
    phases: TetPhases
    resolution: int

    def __post_init__(self) -> None:
        count = self._layout[1].prod(dtype=float)
        if count > MOST_VOXELS:
            raise SettingError(
                f"a resolution of {self.resolution} makes {count:.1e} voxels, and {MOST_VOXELS:.0e} is the most: "
                f"reduce it to {self._largest_resolution}"
            )

    def solve(self, progress: Callback | None = None) -> "Voxels":
        """Evaluate the pattern; Cancelled when ``progress`` returns False."""
        monitor = Monitor(progress)
        expect(progress, _VOXEL * float(self._layout[1].prod()))
        monitor.at("voxels", 0.0)
        return monitor.during(self._sample)

    def _sample(self) -> "Voxels":
        step, counts = self._layout
        low, extents = self.solid.vertices.min(axis=0), np.ptp(self.solid.vertices, axis=0)
        origin = low + (extents - step * (counts - 1)) / 2
        values = np.full(counts, NOTHING, np.float32)
        for places, tets, weights in points_inside(self.solid, origin, step, counts):
            cosines = np.cos(evaluate_in_tets(self.phases, tets, weights))
            values[tuple(places.T)] = np.maximum(cosines.astype(np.float32), _LEAST)
        return Voxels(values, origin, step)

    @property
    def _layout(self) -> tuple[float, np.ndarray]:
        """As of :func:`_grid`."""
        return _grid(np.ptp(self.solid.vertices, axis=0), self.resolution)

    @property
    def _largest_resolution(self) -> int:
        """A resolution that is allowed, not much below the largest."""
        extents, resolution = np.ptp(self.solid.vertices, axis=0), self.resolution
        while _grid(extents, resolution)[1].prod(dtype=float) > MOST_VOXELS:
            resolution = int(0.95 * resolution)
        return resolution


@dataclass(frozen=True)
class Voxels:
    """The pattern on a regular grid.

    Attributes
    ----------
    values : (i, j, k) float32, cos(phase) at the centres of the voxels: 1 on layers, above -1 in the solid, -1 outside
    origin : (3,) centre of the first voxel
    step : size of a voxel
    """

    values: np.ndarray
    origin: np.ndarray
    step: float


def _grid(extents: np.ndarray, resolution: int) -> tuple[float, np.ndarray]:
    """Size of the voxels, and (3,) their number along each axis, which covers the extents up to rounding errors."""
    step = float(extents.max()) / resolution
    return step, np.ceil(extents / step * (1 - 1e-12)).astype(int)
