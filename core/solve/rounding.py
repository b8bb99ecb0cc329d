# SPDX-License-Identifier: GPL-3.0-or-later
"""From the lifted field to unit phases (Section 4.5), and on to a local optimum of the problem itself.

Rounding is where most of what the relaxation won can be lost. Many random projections are tried at
once; the best are carried through a seeded continuation, diffusion steps with falling times, which
lets defects pair up and settle, and then descend on the unrelaxed problem (18). The fields so found are
crossed, each region from the one that does better there, and carried again, as long as that pays.
"""

import numpy as np

from .descent import descend
from .diffusion import diffuse

# Diffusion times, in units of 1 / (energy per mass), of a continuation on the piece itself, and of one on
# the coarser stage that comes before for half of the fields: there a larger time costs next to nothing.
TIMES = 0.2 * 0.4 ** np.arange(5)
COARSE_TIMES = 0.7 ** np.arange(6)
STEPS = 3
# Projections that are carried: from the piece itself, and on the coarser stage, of which the best go on.
FRESH, COARSE_TRIED, COARSE = 8, 16, 6
# Nodes that a coarser stage must have to be worth looking at.
SMALLEST_EXPLORED = 100
# Rounds of crossing: fields that are crossed in pairs, crossings that go on, rounds at least and at most, and the
# relative gain below which they end.
CROSSED, CROSSINGS = 8, 6
FEWEST_ROUNDS, MOST_ROUNDS = 2, 8
GAIN = 1e-3
# Over which diffusion time local energies are compared, and how sharply the better one is preferred.
CROSSING_TIME = 4.0
SHARPNESS = 5.0
# Fields whose energies agree to this share are taken for one.
SAME_ENERGY = 1e-4
# Steps of descent: between rounds, for the best few, and for the best.
SHORT_STEPS, LONG_STEPS, FINAL_STEPS = 15, 30, 200
FINALISTS = 3
TOLERANCE, FINAL_TOLERANCE = 3e-5, 1e-9
# Fields that are kept beside the best one.
KEPT = 8
# Metric shift of descents as a share of the energy per mass.
SHIFT = 1.0


def project(stage, lifted, directions):
    """Fields seen along (r, k) directions xi: Y xi, normalized (Eq. 29). Columns are candidates."""
    dtype = stage.matrix.dtype
    return stage.candidates.normalize(lifted.astype(dtype) @ directions.astype(dtype))


def random_directions(piece, rank, count, random):
    """(r, count) directions: the dominant singular one, and Gaussian ones."""
    directions = random.standard_normal((rank, count))
    if piece.is_complex:
        directions = directions + 1j * random.standard_normal((rank, count))
    return np.hstack([np.eye(rank)[:, :1], directions])


def energies(stage, columns):
    """(k,) energies of candidates."""
    return stage.candidates.energies(columns, stage.matrix @ columns)


def best_columns(stage, columns, count):
    """The ``count`` columns of lowest energy, best first."""
    return columns[:, np.argsort(energies(stage, columns), kind="stable")[:count]]


def distinct_columns(stage, columns):
    """Columns sorted by energy, best first, without those that share theirs with the one before."""
    values = energies(stage, columns)
    order = np.argsort(values, kind="stable")
    apart = np.diff(values[order], prepend=-np.inf) > SAME_ENERGY * np.abs(values[order])
    return columns[:, order[apart]]


def polish(stage, columns, metric, monitor, steps=LONG_STEPS):
    """Descend on the unrelaxed problem from each column; returns columns sorted by energy, best first."""
    columns = columns.astype(stage.matrix.dtype)
    descent = descend(stage.matrix, stage.candidates, columns, metric, TOLERANCE, steps, monitor)
    return descent.point[:, np.argsort(descent.values, kind="stable")]


def finish(workspace, column, metric, monitor):
    """Descend from one field to the last digit that matters, in double precision."""
    column = column.astype(workspace.matrix.dtype)
    spheres = workspace.stages[0].candidates
    return descend(workspace.matrix, spheres, column, metric, FINAL_TOLERANCE, FINAL_STEPS, monitor).point


def continuation(workspace, lifted, samples, density, metric, random, monitor):
    """Fields by seeded continuation and crossing, best first.

    Parameters
    ----------
    workspace : Workspace
    lifted : (N, r) solution of the relaxation, in principal columns
    samples : random projections tried
    density : energy per mass of the relaxation, positive
    metric : Metric of candidates
    random : numpy Generator
    monitor : Monitor
    """
    stage = workspace.stages[0]
    times = TIMES / density
    directions = random_directions(workspace.piece, lifted.shape[1], samples, random)
    seeds = best_columns(stage, project(stage, lifted, directions), FRESH)
    if len(workspace.stages) > 1 and len(workspace.stages[1].row_mass) >= SMALLEST_EXPLORED * workspace.piece.block:
        seeds = np.hstack([seeds, _coarse_fields(workspace, lifted, directions, density, monitor)])
    found = seeds[:, :0]
    best = np.inf
    for round_number in range(1 + MOST_ROUNDS):
        carried = diffuse(stage, seeds, times, STEPS, monitor)
        carried = polish(stage, carried, metric, monitor, SHORT_STEPS)
        found = distinct_columns(stage, np.hstack([found, carried]))
        value = energies(stage, found[:, :1])[0]
        if found.shape[1] == 1 or (round_number >= FEWEST_ROUNDS and value > (1 - GAIN) * best):
            break
        best = value
        seeds = best_columns(stage, crossings(workspace, found[:, :CROSSED], density), CROSSINGS)
    finalists = polish(stage, found[:, :FINALISTS], metric, monitor)
    return distinct_columns(stage, np.hstack([finalists, found[:, FINALISTS:KEPT]]))


def _coarse_fields(workspace, lifted, directions, density, monitor):
    """Fields that went through the larger diffusion times on the coarser stage."""
    stage, coarse = workspace.stages[:2]
    restricted = coarse.lifted.normalize(coarse.restrict(lifted.astype(stage.matrix.dtype)))
    columns = best_columns(coarse, project(coarse, restricted, directions), COARSE_TRIED)
    columns = diffuse(coarse, columns, COARSE_TIMES / density, STEPS, monitor)
    return stage.candidates.normalize(coarse.prolong(best_columns(coarse, columns, COARSE)))


def crossings(workspace, columns, density):
    """All pairs of columns joined, each region mostly from the one whose energy is lower there.

    The pair is first turned to agree as well as it can. Local energies are compared after diffusion, so
    that a region holds a few defects.
    """
    stage = workspace.stages[0]
    block = workspace.piece.block
    first, second = np.triu_indices(columns.shape[1], 1)
    local = np.real(columns.conj() * (stage.matrix @ columns))
    local = local.reshape(-1, block, columns.shape[1]).sum(axis=1)
    smooth = workspace.smoothing(density / CROSSING_TIME).solve(local)
    sums = np.abs(smooth[:, first]) + np.abs(smooth[:, second])
    preference = np.tanh(SHARPNESS * (smooth[:, second] - smooth[:, first]) / np.where(sums > 0, sums, 1))
    preference = np.repeat(preference, block, axis=0)
    turned = _aligned(columns[:, second], columns[:, first])
    return stage.candidates.normalize((1 + preference) * columns[:, first] + (1 - preference) * turned)


def _aligned(columns, targets):
    """Columns times the global phase (a sign in real coordinates) that brings each nearest its target."""
    products = (targets * columns.conj()).sum(axis=0)
    sizes = np.abs(products)
    return columns * np.where(sizes > 0, products / np.where(sizes > 0, sizes, 1), 1).astype(columns.dtype)


def ground_to_one(piece, columns):
    """Turn every column so that the ground, where there is one, has the phase 1."""
    if piece.ground is None:
        return columns
    value = columns[piece.ground * piece.block]
    return columns * np.conj(value / np.abs(value))
