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

# Rounds of continuation: how many of the best fields are carried, and through which diffusion times, in
# units of 1 / (energy per mass). The first only polishes: where few defects fit, their
# arrangement is drawn once, in the projection, and diffusion would lead all fields to the same one.
ROUNDS = (
    (16, ()),
    (8, 0.2 * 0.4 ** np.arange(6)),
    (4, 0.4 ** np.arange(7)),
    (4, 0.4 ** np.arange(7)),
)
CONTINUATION_STEPS = 4
SAME_ENERGY = 1e-6
POLISH_STEPS = 40
POLISH_TOLERANCE = 3e-5


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


def continuation(piece, columns, energy_density, metric, monitor):
    """Seeded continuation: rounds of diffusion with falling times, each polished; all fields, best first.

    Each round starts from the best distinct fields so far, which lets the defects of a good field
    settle once more.
    """
    spheres = Spheres(piece.block, lifted=False)
    found = np.empty((len(columns), 0), columns.dtype)
    for count, times in ROUNDS if energy_density > 0 else ():
        times = np.asarray(times) / energy_density
        carried = diffuse(piece, spheres, columns[:, :count], times, CONTINUATION_STEPS, monitor)
        found = np.hstack([found, polish(piece, carried, metric, monitor)])
        columns = found = distinct_columns(piece, found)
    return columns


def distinct_columns(piece, columns):
    """Columns sorted by energy, best first, without those that share theirs with the one before."""
    energies = piece.energy(columns)
    order = np.argsort(energies, kind="stable")
    apart = np.diff(energies[order], prepend=-np.inf) > SAME_ENERGY * np.abs(energies[order])
    return columns[:, order[apart]]


def polish(piece, columns, metric, monitor, steps=POLISH_STEPS, tolerance=POLISH_TOLERANCE):
    """Descend on the unrelaxed problem from each column; returns columns sorted by energy, best first."""
    descent = descend(piece.matrix, Spheres(piece.block, lifted=False), columns, metric, tolerance, steps, monitor)
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
