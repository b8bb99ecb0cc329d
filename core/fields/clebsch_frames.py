# SPDX-License-Identifier: GPL-3.0-or-later
"""Clebsch maps of a flow that changes: each frame is solved from the one before and turned to it.

A map of the frame before fits the next one much better once its phases have grown by the potential of what the velocity
gained, as far as that has one: the point of the sphere at each node stays, and only vortices are left to be moved.

What a map leaves free is turned so that it changes least: the phase of all nodes of a map to the circle, a unitary
matrix of a map to S^3, which is a rotation of its sphere. Colours of tubes and the point from which filaments are
seen then mean the same in every frame.
"""

import time
from dataclasses import replace

import numpy as np
from scipy.fft import dct, fft, idct, ifft

from ..geometry.grid import Grid
from ..interpolate import TURN
from ..monitor import Callback
from ..solve import Options
from ..solve.lifted import lifted_of_rank
from .clebsch import ClebschMap, SphericalMap, clebsch_map


def following_map(
    before: ClebschMap, integrals: np.ndarray, options: Options | None = None, callback: Callback | None = None
) -> ClebschMap:
    """The :class:`ClebschMap` of the next frame of a flow, near the one before.

    Parameters
    ----------
    before : ClebschMap of the method "sdp"
    integrals : (e,) of the velocity of the frame, on the same grid
    options, callback : see :func:`core.solve.solve`
    """
    grown = advance_phases(before, integrals)
    solution = before.solution
    start = replace(solution, phases=solution.phases * grown, lifted=solution.lifted * grown[:, None])
    found = clebsch_map(before.grid, integrals, before.quantum, options, callback, start)
    turn = np.vdot(found.phases, before.phases * grown)
    return found.showing(found.phases * (turn / abs(turn))) if turn != 0 else found


def following_sphere(before: SphericalMap, found: ClebschMap, callback: Callback | None = None) -> SphericalMap:
    """The :class:`SphericalMap` of the next frame, near the one before.

    Parameters
    ----------
    before : SphericalMap
    found : ClebschMap of the frame
    callback : see :func:`core.solve.solve`
    """
    begin = time.perf_counter()
    problem = found.problem
    start = before.lifted * advance_phases(before.found, found.integrals)[:, None]
    lifted = lifted_of_rank(problem, found.solution, 2, found.options, callback, start)
    left, _, right = np.linalg.svd(lifted.conj().T @ start)
    lifted = lifted @ (left @ right)
    energy = sum(problem.connection.energy(column) for column in lifted.T)
    return SphericalMap(found, lifted, energy, time.perf_counter() - begin)


def advance_phases(before: ClebschMap, integrals: np.ndarray) -> np.ndarray:
    """(n,) unit numbers that turn the phases of a map as the next frame's velocity asks, up to its vorticity."""
    return np.exp(1j * potential(before.regular_grid, TURN / before.quantum * (integrals - before.integrals)))


def potential(grid: Grid, differences: np.ndarray) -> np.ndarray:
    """(n,) numbers at the nodes of a :class:`Grid` whose differences along the edges are nearest to (e,) given ones.

    Poisson's equation with the grid's own weights and masses, which cosines, and waves along periodic axes, make
    diagonal; as if there were no obstacles, which is near enough for a start.
    """
    i, j = grid.edges.T
    flow = grid.weights * differences
    sources = np.bincount(j, flow, grid.node_count) - np.bincount(i, flow, grid.node_count)
    values = (sources / grid.masses).reshape(grid.shape)
    stiffness = np.zeros(grid.shape)
    for axis, (count, spacing) in enumerate(zip(grid.shape, grid.spacing, strict=True)):
        is_periodic = grid.periodic[axis]
        values = fft(values, axis=axis) if is_periodic else dct(values, type=1, axis=axis)
        turn = np.arange(count) * (2 * np.pi / count if is_periodic else np.pi / (count - 1))
        along = [1] * grid.dimension
        along[axis] = count
        stiffness += ((2 - 2 * np.cos(turn)) / spacing**2).reshape(along)
    stiffness[(0,) * grid.dimension] = np.inf  # a constant is free
    values = values / stiffness
    for axis in range(grid.dimension):
        values = ifft(values, axis=axis) if grid.periodic[axis] else idct(values, type=1, axis=axis)
    return np.real(values).ravel()
