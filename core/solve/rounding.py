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

# Rounds of continuation: where the fields that are carried come from, how many they are, and through
# which diffusion times they go, in units of 1 / (energy per mass). The first round only polishes: where
# few defects fit, their arrangement is drawn once, in the projection, and diffusion would lead all
# fields to the same one. Later rounds join the good parts of different fields.
ROUNDS = (
    ("best", 16, ()),
    ("best", 8, 0.2 * 0.4 ** np.arange(6)),
    ("pairs", 6, 0.4 * 0.4 ** np.arange(6)),
    ("lifted", 6, 0.4 ** np.arange(7)),
)
CONTINUATION_STEPS = 4
# Fields that are joined in pairs, and with how much of fresh projections the two best are mixed.
PAIRED = 6
MIXTURE = 0.8
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


def continuation(piece, lifted, columns, metric, energy_density, random, monitor):
    """Seeded continuation: rounds of diffusion with falling times, each polished; all fields, best first.

    Parameters
    ----------
    piece : Piece
    lifted : (N, r) solution of the relaxation
    columns : (N, k) its roundings, best first
    metric : Metric for the descent
    energy_density : energy per mass of the relaxation
    random : numpy Generator
    monitor : Monitor
    """
    spheres = Spheres(piece.block, lifted=False)
    found = np.empty((len(columns), 0), columns.dtype)
    for origin, count, times in ROUNDS if energy_density > 0 else ():
        if origin == "pairs":
            seeds = best_columns(piece, joined_pairs(spheres, columns[:, :PAIRED]), count)
        elif origin == "lifted":
            seeds = _mixed_with_lifted(piece, spheres, lifted, columns, count, random)
        else:
            seeds = columns[:, :count]
        times = np.asarray(times) / energy_density
        carried = diffuse(piece, spheres, seeds, times, CONTINUATION_STEPS, monitor)
        found = np.hstack([found, polish(piece, carried, metric, monitor)])
        columns = found = distinct_columns(piece, found)
    return columns


def joined_pairs(spheres, columns):
    """Normalized sums of all pairs of columns, each pair turned to agree as well as it can."""
    first, second = np.triu_indices(columns.shape[1], 1)
    if len(first) == 0:
        return columns
    return spheres.normalize(columns[:, first] + _aligned(columns[:, second], columns[:, first]))


def _mixed_with_lifted(piece, spheres, lifted, columns, count, random):
    """The best two columns, each mixed with the projections that go best with it."""
    parents = columns[:, :2]
    share = -(-count // parents.shape[1])
    mixed = []
    for parent in np.split(parents, parents.shape[1], axis=1):
        fresh = project(piece, lifted, random_directions(piece, lifted.shape[1], 16 * share, random))
        mixed.append(best_columns(piece, spheres.normalize(parent + MIXTURE * _aligned(fresh, parent)), share))
    return np.hstack(mixed)


def _aligned(columns, targets):
    """Columns times the global phase (a sign in real coordinates) that brings each nearest its target."""
    products = (targets * columns.conj()).sum(axis=0)
    sizes = np.abs(products)
    return columns * np.where(sizes > 0, products / np.where(sizes > 0, sizes, 1), 1)


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
