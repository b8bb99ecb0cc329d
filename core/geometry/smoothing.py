# SPDX-License-Identifier: GPL-3.0-or-later
"""Smoothing of values along the edges of a mesh or a line, by steps towards neighbours and back (Taubin 1995)."""

import numpy as np
from scipy.sparse import csr_array


def smooth_values(values, rows, columns, times, steps):
    """(n, k) values without what changes from each to the next.

    Parameters
    ----------
    values : (n, k)
    rows, columns : (m,) places of values that move, and of their neighbours
    times : how often they take the steps
    steps : shares of the way to the mean of the neighbours; one there and (negative) one a little further back leave
        the size of what is long alone
    """
    count = len(values)
    numbers = np.bincount(rows, minlength=count)
    means = csr_array((1 / numbers[rows], (rows, columns)), shape=(count, count))
    moves = numbers[:, None] > 0
    for _ in range(times):
        for step in steps:
            values = values + step * np.where(moves, means @ values - values, 0)
    return values


def smooth_line(points, is_closed, times, steps):
    """(p, 3) points of a line without what changes from each to the next; the ends of an open one stay.

    ``times`` and ``steps`` as for :func:`smooth_values`.
    """
    rows = np.arange(len(points)) if is_closed else np.arange(1, len(points) - 1)
    columns = np.concatenate([rows - 1, rows + 1]) % len(points)
    return smooth_values(points, np.tile(rows, 2), columns, times, steps)
