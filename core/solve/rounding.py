# SPDX-License-Identifier: GPL-3.0-or-later
"""From the lifted field to unit phases (Section 4.5), and on to a local optimum of the problem itself.

Rounding is where most of what the relaxation won can be lost. Many random projections are tried at
once; the best are carried through a seeded continuation, diffusion steps with falling times, which
lets defects pair up and settle, and are then polished by descent on the unrelaxed problem (18).
"""

import numpy as np

from .descent import descend
from .diffusion import diffuse
from .spheres import Spheres, random_columns

CONTINUATION_TIMES = 0.1 * 0.4 ** np.arange(6)
CONTINUATION_STEPS = 4
POLISH_STEPS = 60
POLISH_TOLERANCE = 1e-5


def project(piece, lifted, directions):
    """Fields seen along (r, k) directions xi: Y xi, normalized (Eq. 29). Columns are candidates."""
    return Spheres(piece.block, lifted=False).normalize(lifted @ directions)


def random_directions(piece, rank, count, random):
    """(r, count) Gaussian directions."""
    directions = random.standard_normal((rank, count))
    return directions + 1j * random.standard_normal((rank, count)) if piece.is_complex else directions


def round_by_svd(piece, lifted):
    """(N, 1) field along the dominant singular direction; ``lifted`` is in principal columns."""
    return project(piece, lifted, np.eye(lifted.shape[1])[:, :1])


def best_columns(piece, columns, count):
    """The ``count`` columns of lowest energy, best first."""
    return columns[:, np.argsort(piece.energy(columns), kind="stable")[:count]]


def continuation(piece, columns, energy_density, monitor):
    """Seeded continuation: short diffusion steps with times falling from a tenth of 1 / energy_density."""
    if energy_density <= 0:
        return columns
    times = CONTINUATION_TIMES / energy_density
    return diffuse(piece, Spheres(piece.block, lifted=False), columns, times, CONTINUATION_STEPS, monitor)


def polish(piece, columns, metric, monitor, steps=POLISH_STEPS, tolerance=POLISH_TOLERANCE):
    """Descend on the unrelaxed problem from each column; returns columns sorted by energy, best first."""
    descent = descend(
        piece.matrix, Spheres(piece.block, lifted=False), columns, metric, tolerance, steps, monitor
    )
    return best_columns(piece, descent.point, descent.point.shape[1])


def ground_to_one(piece, columns):
    """Turn every column so that the ground, where there is one, has the phase 1."""
    if piece.ground is None:
        return columns
    value = columns[piece.ground * piece.block]
    return columns * np.conj(value / np.abs(value))


def random_fields(piece, count, random):
    """(N, count) independent uniform phases."""
    return Spheres(piece.block, lifted=False).normalize(random_columns(piece, count, random))
