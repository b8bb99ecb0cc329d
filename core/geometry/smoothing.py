# SPDX-License-Identifier: GPL-3.0-or-later
"""Smoothing of values along the edges of a mesh or a line, by steps towards neighbours and back (Taubin 1995)."""

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array


def smooth_values(
    values: np.ndarray, rows: np.ndarray, columns: np.ndarray, times: int, steps: Sequence[float]
) -> np.ndarray:
    """Remove short wavelengths from (n, k) values.

    Parameters
    ----------
    rows, columns : (m,) indices of values that move, and of their neighbours
    times : number of rounds of steps
    steps : shares of the way to the neighbours' mean; a positive and a slightly larger negative step keep long
        wavelengths
    """
    count = len(values)
    numbers = np.bincount(rows, minlength=count)
    means = csr_array((1 / numbers[rows], (rows, columns)), shape=(count, count))
    moves = numbers[:, None] > 0
    for _ in range(times):
        for step in steps:
            values = values + step * np.where(moves, means @ values - values, 0)
    return values


def smooth_line(points: np.ndarray, is_closed: bool, times: int, steps: Sequence[float]) -> np.ndarray:
    """Remove short wavelengths from the (p, 3) points of a line; the ends of an open one stay.

    ``times`` and ``steps`` as for :func:`smooth_values`.
    """
    rows = np.arange(len(points)) if is_closed else np.arange(1, len(points) - 1)
    columns = np.concatenate([rows - 1, rows + 1]) % len(points)
    return smooth_values(points, np.tile(rows, 2), columns, times, steps)
