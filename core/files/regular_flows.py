# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows on regular grids: from components with coordinates along each axis, which may be uneven or staggered."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates

from ..errors import SettingError
from ..fields.clebsch import edge_integrals
from ..fields.quantum import sampling_noise
from ..fields.vorticity import vorticity_integrals
from ..geometry.grid import Grid

# Names of arrays that are not 0 in obstacles, and of arrays that are 0 outside the flow.
SOLIDS, MASKS = ("solid", "obstacle", "obstacles"), ("mask", "vtkvalidpointmask")
# By what share of a spacing nodes may be beside an even grid's.
_EVEN = 1e-3
PLANE = "its flow is in a plane: save it as .npz with velocity (nx, ny, 2), which is shown on a mesh of squares"

# Values (nx, ny, nz), and their coordinates along x, y and z.
Placed = tuple[np.ndarray, list[np.ndarray]]


@dataclass(frozen=True)
class GridFlow:
    """A flow at the nodes of a grid.

    Attributes
    ----------
    own : the grid
    velocity : (n, 3) or (n, 2) at its nodes
    is_vorticity : whether these vectors are the vorticity of the flow
    warnings : lines that the user should read
    """

    own: Grid
    velocity: np.ndarray
    is_vorticity: bool = False
    warnings: tuple[str, ...] = ()

    @property
    def noise(self) -> float | None:
        """The :func:`sampling_noise`; None where it cannot be measured."""
        return None if self.is_vorticity else sampling_noise(self.own, self.velocity)

    def grid(self, _resolution: int) -> Grid:
        """The flow's own grid."""
        return self.own

    def integrals(self, grid: Grid) -> np.ndarray:
        """(e,) of the velocity along the grid's edges."""
        return vorticity_integrals(grid, self.velocity) if self.is_vorticity else edge_integrals(grid, self.velocity)


def grid_flow(
    vectors: np.ndarray,
    spacing: Sequence[float] | np.ndarray,
    origin: Sequence[float] | np.ndarray,
    extra: dict[str, np.ndarray],
    is_curl: bool,
    warnings: tuple[str, ...],
) -> GridFlow:
    """A flow of (nx, ny, nz, 3) vectors; nodes in obstacles, outside masks and with nan are solid."""
    if min(vectors.shape[:3]) < 2:
        raise SettingError(PLANE)
    solid = ~np.isfinite(vectors).all(axis=3)
    for name, values in extra.items():
        solid |= is_solid(name, values)
    grid = Grid(vectors.shape[:3], spacing, origin, solid=solid if solid.any() else None)
    return GridFlow(grid, np.where(solid[..., None], 0, vectors).reshape(-1, 3).astype(float), is_curl, warnings)


def is_solid(name: str, values: np.ndarray) -> np.ndarray:
    """Bool like the values of an array of :data:`SOLIDS` or :data:`MASKS`: places without a flow."""
    return np.asarray((values != 0) if name.lower() in SOLIDS else (values == 0))


def resample_evenly(
    components: Sequence[Placed], extra: dict[str, Placed], is_curl: bool, warnings: tuple[str, ...]
) -> GridFlow:
    """A flow of three components, each with its own coordinates; resampled where these are uneven, or differ as on
    staggered grids, whose components are moved along their own axes alone."""
    components = [_increasing(*component) for component in components]
    axes = []
    for axis, name in enumerate("xyz"):
        low, high = (pick(p[axis][end] for _, p in components) for pick, end in ((max, 0), (min, -1)))
        along = components[(axis + 1) % 3][1][axis]
        along = along[(along >= low) & (along <= high)]
        if len(along) < 2:
            is_plane = any(len(places[axis]) < 2 for _, places in components)
            raise SettingError(
                PLANE if is_plane else f"its components do not overlap along {name}: put them on one grid"
            )
        axes.append(np.linspace(along[0], along[-1], len(along)))
    vectors = np.stack([_sample(*component, axes, 1) for component in components], axis=3)
    others = {name: _sample(*_increasing(*placed), axes, 0) for name, placed in extra.items()}
    spacing = [along[1] - along[0] for along in axes]
    return grid_flow(vectors, spacing, [along[0] for along in axes], others, is_curl, warnings)


def _increasing(values: np.ndarray, places: list[np.ndarray]) -> Placed:
    """Values whose coordinates increase along each axis."""
    places = list(places)
    for axis, along in enumerate(places):
        if len(along) > 1 and (np.diff(along) < 0).all():
            places[axis], values = along[::-1], np.flip(values, axis)
        elif not (np.diff(along) > 0).all():
            raise SettingError(f"its coordinates along {'xyz'[axis]} do not increase: sort them, two at least")
    return values, places


def _sample(values: np.ndarray, places: list[np.ndarray], axes: list[np.ndarray], order: int) -> np.ndarray:
    """Values at the nodes of other axes, which lie between the first and the last coordinate."""
    if all(
        len(along) == len(axis) and np.abs(along - axis).max() <= _EVEN * (axis[1] - axis[0])
        for along, axis in zip(places, axes, strict=True)
    ):
        return values
    index = [np.interp(axis, along, np.arange(len(along))) for axis, along in zip(axes, places, strict=True)]
    return map_coordinates(np.asarray(values, float), np.meshgrid(*index, indexing="ij"), order=order, mode="nearest")
