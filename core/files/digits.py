# SPDX-License-Identifier: GPL-3.0-or-later
"""How many digits text files carry: nine of each number, and more of places far from the origin."""

import math

import numpy as np

# Nine digits tell all numbers of single precision apart, seventeen all of double precision.
DIGITS, MOST_DIGITS = 9, 17


def number_format(points: np.ndarray) -> str:
    """The format of coordinates, such as "%.9g": their steps are a billionth of the points' extent or less.

    Parameters
    ----------
    points : (n, d) places
    """
    extra = 0
    if len(points):
        largest, extent = float(np.abs(points).max()), float(np.ptp(points, axis=0).max())
        if 0 < extent < largest:
            extra = math.ceil(math.log10(largest / extent))
    return f"%.{min(DIGITS + extra, MOST_DIGITS)}g"
