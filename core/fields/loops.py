# SPDX-License-Identifier: GPL-3.0-or-later
"""Circulations along loops of a grid: how well filaments represent the flow that they come from (paper, Eq. 9)."""

import numpy as np

from ..geometry.grid import Grid
from .clebsch import ClebschMap, circulations


def sum_through_squares(grid: Grid, fluxes: np.ndarray, size: int) -> np.ndarray:
    """(l,) sums of the (f,) fluxes inside every square loop of ``size`` edges a side, in all planes of the grid.

    Loops across the end of a periodic axis are left out; the result is empty where the grid is too small.
    """
    parts, start = [], 0
    for plane in grid.planes:
        shape = grid.element_shape(plane)
        values = fluxes[start : start + np.prod(shape)].reshape(shape)
        start += values.size
        for axis in plane:
            sums = np.cumsum(np.insert(values, 0, 0, axis=axis), axis=axis, dtype=float)
            sums = np.moveaxis(sums, axis, 0)
            values = np.moveaxis(sums[size:] - sums[: max(len(sums) - size, 0)], 0, axis)
        parts.append(values.ravel())
    return np.concatenate(parts)


def loop_error(found: ClebschMap, size: int) -> float | None:
    """Root mean square difference, in quanta, between the filaments through all square loops of a size and the flow's
    circulation along them; None where there is no loop."""
    grid = found.regular_grid
    missing = circulations(grid, found.integrals) / found.quantum - found.face_numbers
    differences = sum_through_squares(grid, missing, size)
    return float(np.sqrt(np.mean(differences**2))) if len(differences) else None


def flow_helicity(grid: Grid, integrals: np.ndarray) -> float:
    """The helicity of a flow in space, the integral of velocity times vorticity, from (e,) integrals along the edges:
    in each open cell, the means of its edges along an axis and of its faces across it."""
    faces = grid.cell_faces
    flux = circulations(grid, integrals)[faces]
    # A cell's four edges along an axis are around its faces across the next axis.
    total = 0.0
    for axis in range(3):
        beside = (axis + 1) % 3
        sides = grid.face_edges[faces[:, 2 * beside : 2 * beside + 2]]
        along = sides[grid.edge_axes[sides] == axis].reshape(len(faces), 4)
        total += integrals[along].mean(axis=1) @ flux[:, 2 * axis : 2 * axis + 2].mean(axis=1)
    return float(total)
