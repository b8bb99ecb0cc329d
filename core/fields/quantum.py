# SPDX-License-Identifier: GPL-3.0-or-later
"""The circulation of one filament, chosen by quick solves on coarser grids."""

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from ..errors import MeshError, SettingError
from ..geometry.grid import Grid
from ..geometry.surface import Surface
from ..monitor import Callback, Monitor
from ..solve import Options
from .clebsch import (
    MOST_QUANTA,
    ClebschMap,
    circulations,
    clebsch_map,
    edge_integrals,
    layer_sums,
    mean_circulation,
    quantum_for,
)

# Circulations that are tried decrease by this factor; the share of the vorticity may be up to this.
STEP, EXCESS = 0.5**0.5, 1.1
# The most nodes of the grid where the search begins, and of the finest grid.
COARSE_NODES, FINE_NODES = 5_000, 40_000
# Quick solves find slightly more filaments than full ones: their share has to be larger by this.
MARGIN = 0.03


def find_quantum(
    grid: Grid | Surface,
    integrals: np.ndarray,
    share: float,
    count: float | None = None,
    largest: float | None = None,
    seed: int = 0,
    callback: Callback | None = None,
    show: Callable[[ClebschMap], object] | None = None,
) -> float:
    """The largest circulation of a filament, to three digits, with which the filaments carry a share of the vorticity;
    if there is none, the least that the grid can hold. SettingError for a flow without vorticity.

    Parameters
    ----------
    integrals : (e,) of the velocity along the edges
    count : filaments through one plane of the grid, one way; decides instead of the share
    largest : circulation to try first; None for all that passes the plane with most vorticity
    seed : of the quick solves
    show : called with the map that was chosen on each grid
    """
    options, monitor = Options(method="coarse", seed=seed), Monitor(callback)
    most = quantum_for(grid, integrals, count or 1)
    quantum = _rounded(min(most, largest or most))

    for fine, along in reversed(_levels(grid, integrals)):
        least = mean_circulation(fine, along) / MOST_QUANTA
        while quantum > 1.01 * least:
            monitor.at(f"trying a circulation of {quantum:.3g}", 0.0)
            found = clebsch_map(fine, along, quantum, options, lambda _stage, _fraction: monitor.check())
            if shows_enough(found, min(share + MARGIN, 1), count) and (found.vorticity_share or 0) <= EXCESS:
                if show is not None:
                    show(found)
                break
            quantum = _rounded(STEP * quantum)
    return max(quantum, _rounded(least_quantum(grid, integrals)))


def coarse_map(
    grid: Grid | Surface, integrals: np.ndarray, quantum: float, seed: int = 0, callback: Callback | None = None
) -> ClebschMap | None:
    """The map of a quick solve on the grid where the search begins; None where that grid cannot be made small,
    or the quantum is too small for it."""
    coarse, along = _levels(grid, integrals)[-1]
    if len(coarse.masses) > FINE_NODES:
        return None
    with suppress(SettingError):
        return clebsch_map(coarse, along, quantum, Options(method="coarse", seed=seed), callback)
    return None


def shows_enough(found: ClebschMap, share: float, count: float | None = None) -> bool:
    """Whether the filaments of a map carry a share of the vorticity, or pass one plane of the grid as often as
    given."""
    if count is None:
        return (found.vorticity_share or 0) >= share
    return layer_sums(found.grid, found.face_numbers) >= count


def least_quantum(grid: Grid | Surface, integrals: np.ndarray) -> float:
    """The circulation below which phases hardly distinguish the filaments through a face."""
    return 2 * mean_circulation(grid, integrals) / MOST_QUANTA


def _rounded(quantum: float) -> float:
    """Round to three digits, as in messages."""
    return float(f"{quantum:.3g}")


def sampling_noise(grid: Grid, velocity: np.ndarray) -> float | None:
    """The relative change of circulations around blocks of two by two faces if every other node is left out; (n, d)
    velocities at the nodes. None for a grid that cannot be halved, or a flow without vorticity.

    Near 0 for vorticity that the grid resolves, 1 for noise, and 3 where there is no vorticity but the error of the
    trapezoidal rule, which grows by four.
    """
    if not grid.can_halve:
        return None
    with suppress(MeshError):
        coarse, integrals = halved(grid, edge_integrals(grid, velocity))
        every_other = velocity.reshape(*grid.shape, -1)[(slice(None, None, 2),) * grid.dimension]
        kept = every_other[tuple(map(slice, coarse.shape))].reshape(coarse.node_count, -1)
        sums = circulations(coarse, integrals)
        rough = circulations(coarse, edge_integrals(coarse, kept))
        total = np.abs(sums).sum()
        return float(np.abs(rough - sums).sum() / total) if total else None
    return None


def _levels(grid: Grid | Surface, integrals: np.ndarray) -> list[tuple[Grid | Surface, np.ndarray]]:
    """The flow on the grids of the search, each coarser than the one before."""
    levels = [(grid, integrals)]
    with suppress(MeshError):  # obstacles leave no cell of a coarser grid open
        while isinstance(grid, Grid) and grid.node_count > COARSE_NODES and grid.can_halve:
            grid, integrals = halved(grid, integrals)
            levels.append((grid, integrals))
    return [level for level in levels[:-1] if level[0].node_count <= FINE_NODES] + levels[-1:]


def halved(grid: Grid, integrals: np.ndarray) -> tuple[Grid, np.ndarray]:
    """The grid of every other node, and the integrals along its edges, which are sums of two.

    Circulations around its faces are sums of four. The last nodes of an open axis with an even number are left out.
    """
    shape = [count // 2 if ring else (count + 1) // 2 for count, ring in zip(grid.shape, grid.periodic, strict=True)]
    solid = grid.solid[(slice(None, None, 2),) * grid.dimension][tuple(map(slice, shape))]
    coarse = Grid(shape, 2 * grid.spacing, grid.origin, grid.periodic, solid if solid.any() else None)
    parts, start = [], 0
    for axis in range(grid.dimension):
        whole, half = grid.element_shape([axis]), coarse.element_shape([axis])
        values = integrals[start : start + np.prod(whole)].reshape(whole)
        start += values.size
        ends = [slice(0, 2 * count, 2) for count in half]
        second = [*ends[:axis], slice(1, 2 * half[axis], 2), *ends[axis + 1 :]]
        parts.append((values[tuple(ends)] + values[tuple(second)]).ravel())
    return coarse, np.concatenate(parts)
