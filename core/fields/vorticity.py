# SPDX-License-Identifier: GPL-3.0-or-later
"""A flow from its vorticity: integrals along the edges of a grid with the same circulations.

On a regular grid the curl, from edges to faces, is diagonal in waves: cosines at the nodes of an open axis and sines
between them, complex exponentials along a periodic one. With the multipliers l of differences, the least velocity whose
curl is nearest to w is u = conj(l) x w / |l|^2. Gradients, and a uniform flow around a periodic box, have no vorticity:
they stay unknown, and filaments do not depend on gradients.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.fft import dct, dst, fft, idct, idst, ifft

from ..errors import SettingError
from ..geometry.grid import Grid


def vorticity_integrals(grid: Grid, vorticity: ArrayLike) -> np.ndarray:
    """(e,) integrals along the edges of a velocity with a given vorticity, (n, 3) at the nodes of a grid in space,
    without the part that has a divergence; SettingError for a grid in a plane, and values that are not numbers."""
    vorticity = np.asarray(vorticity, float)
    if vorticity.shape != (grid.node_count, 3) or grid.dimension != 3:
        raise SettingError(f"vorticity of the shape {vorticity.shape}: give three numbers a node of a grid in space")
    if not np.isfinite(vorticity).all():
        raise SettingError("the vorticity has values that are not numbers: fill or crop the grid")
    fluxes = [_face_means(grid, vorticity[:, normal].reshape(grid.shape), normal) for normal in range(3)]
    return edges_of_faces(grid, fluxes)


def edges_of_faces(grid: Grid, densities: Sequence[np.ndarray]) -> np.ndarray:
    """(e,) integrals of the velocity whose vorticity is nearest to that given, an array of the faces for each
    normal."""
    waves = [to_waves(grid, values, {0, 1, 2} - {normal}) for normal, values in enumerate(densities)]
    steps = [_multipliers(grid, axis) for axis in range(3)]
    along_x, along_y, along_z = (np.abs(step) ** 2 for step in steps)
    size = along_x + along_y + along_z
    size[0, 0, 0] = np.inf
    parts = []
    for axis in range(3):
        after, last = (axis + 1) % 3, (axis + 2) % 3
        velocity = (steps[after].conj() * waves[last] - steps[last].conj() * waves[after]) / -size
        parts.append(from_waves(grid, velocity, {axis}).ravel() * grid.spacing[axis])
    return np.concatenate(parts)


def _face_means(grid: Grid, values: np.ndarray, normal: int) -> np.ndarray:
    """Means of the values at the four corners of each face across an axis."""
    for axis in {0, 1, 2} - {normal}:
        after = np.roll(values, -1, axis=axis)
        values = 0.5 * (values + after)
        if not grid.periodic[axis]:
            values = np.moveaxis(np.moveaxis(values, axis, 0)[:-1], 0, axis)
    return values


def _multipliers(grid: Grid, axis: int) -> np.ndarray:
    """The factors of waves in difference quotients along an axis, as an array along that axis."""
    count = grid.shape[axis]
    turn = np.arange(count) * (2 * np.pi / count if grid.periodic[axis] else np.pi / (count - 1))
    steps = np.exp(1j * turn) - 1 if grid.periodic[axis] else -2 * np.sin(turn / 2) + 0j
    return (steps / grid.spacing[axis]).reshape([-1 if axis == other else 1 for other in range(3)])


def to_waves(grid: Grid, values: np.ndarray, between: set[int]) -> np.ndarray:
    """Coefficients of an array in cosines, and in waves along periodic axes; along the axes ``between`` its values lie
    between the nodes, and they are in sines."""
    for axis in range(grid.dimension):
        if grid.periodic[axis]:
            values = fft(values, axis=axis)
        elif axis in between:  # no wave of number 0
            values = np.pad(dst(values, type=2, axis=axis), [(int(axis == other), 0) for other in range(values.ndim)])
        else:
            values = dct(values, type=1, axis=axis)
    return values


def from_waves(grid: Grid, values: np.ndarray, between: set[int]) -> np.ndarray:
    """The inverse of :func:`to_waves`."""
    for axis in range(grid.dimension):
        if grid.periodic[axis]:
            values = ifft(values, axis=axis)
        elif axis in between:
            values = np.moveaxis(np.moveaxis(values, axis, 0)[1:], 0, axis)
            values = idst(values, type=2, axis=axis)
        else:
            values = idct(values, type=1, axis=axis)
    return np.real(values)
