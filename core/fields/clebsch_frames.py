# SPDX-License-Identifier: GPL-3.0-or-later
"""Clebsch maps of a changing flow: each frame is solved from the one before and aligned with it.

The phases of the frame before first grow by the potential whose gradient is nearest to the change of the velocity: the
point of the sphere at each node stays, and only the vortices have to move.

The freedom of a map is used to make it change least: the common phase of a map to the circle, a unitary matrix of a map
to S^3, which is a rotation of its sphere. So the colours of tubes and the point that filaments are seen from mean the
same in every frame.
"""

import time
from dataclasses import replace

import numpy as np

from ..geometry.grid import Grid
from ..interpolate import TURN
from ..monitor import Callback
from ..solve import Options
from ..solve.lifted import lifted_of_rank
from .clebsch import ClebschMap, SphericalMap, clebsch_map
from .vorticity import from_waves, to_waves


def solve_next_map(
    before: ClebschMap, integrals: np.ndarray, options: Options | None = None, callback: Callback | None = None
) -> ClebschMap:
    """Solve for the map of the next frame, with (e,) integrals on the same grid, from the map before, of the method
    "sdp"; options and callback as for :func:`core.solve.solve`."""
    grown = advance_phases(before, integrals)
    solution = before.solution
    start = replace(solution, phases=solution.phases * grown, lifted=solution.lifted * grown[:, None])
    found = clebsch_map(before.grid, integrals, before.quantum, options, callback, start)
    turn = np.vdot(found.phases, before.phases * grown)
    return found.with_phases(found.phases * (turn / abs(turn))) if turn != 0 else found


def solve_next_sphere(before: SphericalMap, found: ClebschMap, callback: Callback | None = None) -> SphericalMap:
    """Solve for the spherical map of the next frame, whose map to the circle is ``found``, from the one before."""
    begin = time.perf_counter()
    problem = found.problem
    start = before.lifted * advance_phases(before.found, found.integrals)[:, None]
    lifted = lifted_of_rank(problem, found.solution, 2, found.options, callback, start)
    left, _, right = np.linalg.svd(lifted.conj().T @ start)
    lifted = lifted @ (left @ right)
    energy = sum(problem.connection.energy(column) for column in lifted.T)
    return SphericalMap(found, lifted, energy, time.perf_counter() - begin)


def advance_phases(before: ClebschMap, integrals: np.ndarray) -> np.ndarray:
    """(n,) unit numbers by which the phases of a map grow to the next frame, up to vorticity."""
    return np.exp(1j * potential(before.regular_grid, TURN / before.quantum * (integrals - before.integrals)))


def potential(grid: Grid, differences: np.ndarray) -> np.ndarray:
    """(n,) numbers at the nodes of a grid whose differences along the edges are nearest to (e,) given ones.

    Poisson's equation with the grid's weights and masses, diagonal in cosines, and in waves along periodic axes;
    obstacles are ignored, which is near enough for a start.
    """
    i, j = grid.edges.T
    flow = grid.weights * differences
    sources = np.bincount(j, flow, grid.node_count) - np.bincount(i, flow, grid.node_count)
    values = to_waves(grid, (sources / grid.masses).reshape(grid.shape), set())
    stiffness = np.zeros(grid.shape)
    for axis, (count, spacing) in enumerate(zip(grid.shape, grid.spacing, strict=True)):
        is_periodic = grid.periodic[axis]
        turn = np.arange(count) * (2 * np.pi / count if is_periodic else np.pi / (count - 1))
        along = [1] * grid.dimension
        along[axis] = count
        stiffness += ((2 - 2 * np.cos(turn)) / spacing**2).reshape(along)
    stiffness[(0,) * grid.dimension] = np.inf  # a constant is free
    return from_waves(grid, values / stiffness, set()).ravel()
