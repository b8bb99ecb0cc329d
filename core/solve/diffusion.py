# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffusion (MBO): solve (M + tau L) x' = M x and normalize, over and over (Viertel and Osting 2019)."""

import numpy as np
from scipy.sparse import diags_array

from .metric import SMALLEST_SHIFT, Factorization


def diffuse(piece, spheres, columns, times, steps, monitor, tolerance=0.0):
    """Carry columns through diffusion steps of given times.

    Parameters
    ----------
    piece : Piece
    spheres : Spheres
    columns : (N, k) array
    times : diffusion times tau, one factorization each
    steps : most steps at each time
    monitor : Monitor
    tolerance : largest move of a unit vector below which a time is finished early
    """
    row_mass = piece.row_mass
    columns = spheres.normalize(columns)
    for tau in np.minimum(times, 1 / (SMALLEST_SHIFT * piece.stiffness)):
        factorization = Factorization(diags_array(row_mass) + tau * piece.matrix)
        for _ in range(steps):
            monitor.check()
            moved = spheres.normalize(factorization.solve(row_mass[:, None] * columns))
            change = np.abs(moved - columns).max()
            columns = moved
            if change <= tolerance:
                break
    return columns
