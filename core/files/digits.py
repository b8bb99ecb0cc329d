# SPDX-License-Identifier: GPL-3.0-or-later
"""The number of digits in text files: nine, and more for points far from the origin."""

import math

import numpy as np

# Nine digits distinguish all numbers of single precision, seventeen all of double precision.
DIGITS, MOST_DIGITS = 9, 17


def number_format(points: np.ndarray) -> str:
    """The format of the coordinates of (n, d) points, such as "%.9g": steps of a billionth of their extent or less."""
    extra = 0
    if len(points):
        largest, extent = float(np.abs(points).max()), float(np.ptp(points, axis=0).max())
        if 0 < extent < largest:
            extra = math.ceil(math.log10(largest / extent))
    return f"%.{min(DIGITS + extra, MOST_DIGITS)}g"
