# SPDX-License-Identifier: GPL-3.0-or-later
"""Smoothing of values along the edges of a mesh or a line that leaves their size alone (Taubin 1995)."""

import numpy as np
from scipy.sparse import csr_array


def evened_along(values, rows, columns, times, steps):
    """(n, k) values without what changes from each to the next.

    Parameters
    ----------
    values : (n, k)
    rows, columns : (m,) places of values that move, and of their neighbours
    times : how often they go there and back
    steps : shares of the way to the mean of the neighbours, there and (negative) a little further back
    """
    count = len(values)
    numbers = np.bincount(rows, minlength=count)
    means = csr_array((1 / numbers[rows], (rows, columns)), shape=(count, count))
    moves = numbers[:, None] > 0
    for _ in range(times):
        for step in steps:
            values = values + step * np.where(moves, means @ values - values, 0)
    return values
