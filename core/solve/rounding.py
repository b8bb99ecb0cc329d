# SPDX-License-Identifier: GPL-3.0-or-later
"""From the lifted field to unit phases (Section 4.5), and on to a local optimum of the problem itself.

Rounding is where most of what the relaxation won can be lost. Many random projections are tried at
once; the best are carried through a seeded continuation, diffusion steps with falling times, which
lets defects pair up and settle, and then descend on the unrelaxed problem (18). The fields so found are
crossed, each region from the one that does better there, and carried again, as long as that pays.
"""

from dataclasses import astuple, dataclass
from functools import partial

import numpy as np

from ..algebra.workers import idle_workers, share_out
from ..monitor import OutOfTime
from .descent import descend
from .diffusion import diffuse
from .spheres import gaussian, principal

# Diffusion times of the continuation, in units of 1 / (energy per mass), the first of which does for crossings, whose
# parents have settled already; and a slower fall that some go through before.
TIMES = 0.3 * 0.1 ** np.arange(3)
LONG_TIMES = 0.7 * 0.6 ** np.arange(4)
# The share of carried fields that go on to descend.
DESCENDING = 0.5
# Rounds of crossing at least and at most, and the relative gain below which they end.
FEWEST_ROUNDS, MOST_ROUNDS = 1, 5
GAIN = 2e-3
# The numbers of :class:`Tries` are for so many nodes. As what there is to choose from, they grow with the size, as its
# root, between these multiples: small meshes would wait for little, and large ones for long. From the last number of
# nodes on, they are these again, for memory.
USUAL_SIZE, LEAST_EFFORT, MOST_EFFORT, LARGE_SIZE = 5_000, 0.8, 2.0, 1_000_000
# Over which diffusion time local energies are compared, and how sharply the better one is preferred.
CROSSING_TIME = 4.0
SHARPNESS = 5.0
# Fields that agree to this share are taken for one.
SAME_FIELD = 0.999
# Descent of the lifted field on calmed problems: what roughly follows does for candidates.
CALM_TOLERANCE, CALM_STEPS = 1e-5, 8
# Steps of descent: between rounds, for the finalists, and for the best one in double precision.
SHORT_STEPS, LONG_STEPS, FINAL_STEPS = 6, 15, 200
FINALISTS = 2
TOLERANCE, FINAL_TOLERANCE = 3e-5, 1e-12
# Numbers that are worked on at once, and columns of a batch at least: memory, and how soon a solve can be stopped.
# Numbers from which on a thread is worth its while.
MOST_AT_ONCE, SMALLEST_BATCH = 1_000_000, 4
WORTH_SHARING = 60_000
# Metric shift of descents as a share of the energy per mass.
CANDIDATE_SHIFT = 1.0


@dataclass(frozen=True)
class Tries:
    """How many fields are tried.

    Attributes
    ----------
    best, drawn : projections of the lifted field that are carried: the best, and for variety some at random, through
        the slower fall first
    calmed : projections of each calmed problem's lifted field that are carried, the best
    kept, crossed : fields that are kept and crossed in pairs, crossings that go on
    """

    best: int
    drawn: int
    calmed: int
    kept: int
    crossed: int

    def times(self, effort):
        return Tries(*(round(effort * number) for number in astuple(self)))


# Without calmed problems, and with them.
ALONE, TOGETHER = Tries(14, 5, 0, 7, 20), Tries(8, 2, 5, 8, 15)


def random_directions(is_complex, rank, count, random):
    """(r, count + 1) directions: the dominant singular one, and Gaussian ones."""
    return np.hstack([np.eye(rank)[:, :1], gaussian((rank, count), is_complex, random)])


def projections(stage, lifted, directions, count, monitor):
    """The best ``count`` of the fields seen along (r, k) directions xi, which are Y xi, normalized (Eq. 29)."""
    dtype = stage.matrix.dtype
    lifted, directions = lifted.astype(dtype), directions.astype(dtype)

    def project(numbers):
        return stage.candidates.normalize(lifted @ directions[:, numbers])

    return _best_of(stage, project, directions.shape[1], count, monitor)


def crossings(stage, columns, smoothing, count, monitor):
    """The best ``count`` of all pairs of columns joined, each region mostly from the one whose energy is lower there.

    The pair is first turned to agree as well as it can. Local energies are compared after ``smoothing``, a metric of
    values on the nodes, so that a region holds a few defects.
    """
    block = stage.block
    local = np.real(columns.conj() * (stage.matrix @ columns))
    local = local.reshape(-1, block, columns.shape[1]).sum(axis=1)
    smooth = smoothing.solve(local)
    pairs = np.transpose(np.triu_indices(columns.shape[1], 1))

    def cross(numbers):
        first, second = pairs[numbers].T
        sums = np.abs(smooth[:, first]) + np.abs(smooth[:, second])
        preference = np.tanh(SHARPNESS * (smooth[:, second] - smooth[:, first]) / np.where(sums > 0, sums, 1))
        preference = np.repeat(preference, block, axis=0)
        kept, joined = np.take(columns, first, axis=1), np.take(columns, second, axis=1)
        return stage.candidates.normalize((1 + preference) * kept + (1 - preference) * _aligned(joined, kept))

    return _best_of(stage, cross, len(pairs), count, monitor)


def _best_of(stage, make, total, count, monitor):
    """Of ``total`` columns, which make(numbers) makes, the best ``count``, best first; few are held at once."""

    def making(numbers, work):
        def make_batch(batch, batch_monitor):
            batch_monitor.check()
            return work(make(batch))

        return _in_batches(stage, make_batch, numbers, monitor)

    values = making(np.arange(total), partial(energies, stage))
    return making(np.argsort(values, kind="stable")[:count], lambda columns: columns)


def _best(stage, columns, count):
    """The ``count`` columns of least energy, one at least, best first."""
    order = np.argsort(energies(stage, columns), kind="stable")
    return np.take(columns, order[: max(count, 1)], axis=1)


def _in_batches(stage, work, columns, monitor):
    """What work(columns, monitor) makes of columns, or of their numbers, in batches that all cores share."""
    size, count = stage.matrix.shape[0], columns.shape[-1]
    most = max(MOST_AT_ONCE // 2 // size, SMALLEST_BATCH)
    fewest = min(size * count // WORTH_SHARING, count // SMALLEST_BATCH, idle_workers())
    batches = np.array_split(columns, max(-(-count // most), fewest, 1), axis=-1)
    at_once = max(MOST_AT_ONCE // (size * batches[0].shape[-1]), 2)
    return np.concatenate(share_out(work, batches, monitor, at_once), axis=-1)


def _aligned(columns, targets):
    """Columns times the global phase (a sign in real coordinates) that brings each nearest its target."""
    products = (targets * columns.conj()).sum(axis=0)
    sizes = np.abs(products)
    return columns * np.where(sizes > 0, products / np.where(sizes > 0, sizes, 1), 1).astype(columns.dtype)


def energies(stage, columns):
    """(k,) energies of candidates."""
    return stage.candidates.energies(columns, stage.matrix @ columns)


def distinct_columns(stage, columns):
    """Columns sorted by energy, best first, without those that agree with a better one but for a turn of the whole."""
    columns = _best(stage, columns, columns.shape[1])
    agreement = np.abs(columns.conj().T @ columns) / stage.node_count
    kept: list[int] = []
    for number in range(columns.shape[1]):
        if not (agreement[number, kept] > SAME_FIELD).any():
            kept.append(number)
    return np.take(columns, kept, axis=1)


def polish(stage, columns, metric, monitor, steps=LONG_STEPS):
    """Descend on the unrelaxed problem from each column; returns columns sorted by energy, best first."""
    columns = columns.astype(stage.matrix.dtype)
    descent = descend(stage.matrix, stage.candidates, columns, metric, TOLERANCE, steps, monitor)
    return np.take(descent.point, np.argsort(descent.values, kind="stable"), axis=1)


def finish(workspace, column, metric, monitor):
    """Descend from one field to the last digit that matters, in double precision."""
    column = column.astype(workspace.matrix.dtype)
    spheres = workspace.stages[0].candidates
    return descend(workspace.matrix, spheres, column, metric, FINAL_TOLERANCE, FINAL_STEPS, monitor).point


def continuation(stage, lifted, samples, density, random, monitor, calmed=(), metric_of_lifted=None):
    """Fields by seeded continuation and crossing, best first, and whether time ran out on the way.

    Parameters
    ----------
    stage : Stage of the piece itself
    lifted : (N, r) solution of the relaxation, in principal columns
    samples : random projections tried
    density : energy per mass of the relaxation, positive
    random : numpy Generator
    monitor : Monitor
    calmed : matrices of calmed problems on the same rows, the least calmed first; their fields join the others
    metric_of_lifted : in which lifted fields descend on these
    """
    tries = (TOGETHER if calmed else ALONE).times(_effort(stage.node_count))
    metric = monitor.during(partial(stage.candidate_metric, CANDIDATE_SHIFT * density))
    directions = random_directions(stage.is_complex, lifted.shape[1], samples, random)
    seeds = projections(stage, lifted, directions, tries.best, monitor)
    found, best = seeds[:, :1], np.inf
    try:
        drawn = projections(stage, lifted, directions[:, -tries.drawn :], tries.drawn, monitor)
        seeds = np.hstack([seeds, diffuse(stage, drawn, _metrics(stage, LONG_TIMES, density), 1, monitor)])
        diffusion = monitor.during(partial(list, _metrics(stage, TIMES, density)))
        smoothing = monitor.during(partial(stage.smoothing, density / CROSSING_TIME))
        carried = _carried(stage, seeds, diffusion, metric, monitor)
        for calm, field in _calmed_fields(stage, lifted, calmed, metric_of_lifted, monitor):
            directions = random_directions(stage.is_complex, field.shape[1], samples, random)
            seeds = projections(calm, field, directions, tries.calmed, monitor)
            settled = _carried(calm, seeds, diffusion, metric, monitor)
            carried = np.hstack([carried, _in_batches(stage, _descent(stage, metric), settled, monitor)])
        for round_number in range(1 + MOST_ROUNDS):
            found = distinct_columns(stage, np.hstack([found, carried]))[:, : tries.kept]
            value = energies(stage, found[:, :1])[0]
            monitor.found(float(value))
            monitor.at("continuation", 0.4 + 0.5 * (1 + round_number) / (1 + MOST_ROUNDS))
            settled = round_number >= FEWEST_ROUNDS and value > (1 - GAIN) * best
            if found.shape[1] == 1 or settled or round_number == MOST_ROUNDS:
                break
            best = value
            seeds = crossings(stage, found, smoothing, tries.crossed, monitor)
            carried = _carried(stage, seeds, diffusion[:1], metric, monitor)
        found = np.hstack([polish(stage, found[:, :FINALISTS], metric, monitor), found[:, FINALISTS:]])
    except OutOfTime:
        return found, True
    return distinct_columns(stage, found), False


def _calmed_fields(stage, lifted, matrices, metric, monitor):
    """The stage of each calmed matrix, and what the lifted field descends to there, in principal columns."""
    point = lifted.astype(stage.matrix.dtype)
    for matrix in matrices:
        calm = stage.turned(matrix)
        point = descend(calm.matrix, calm.lifted, point, metric, CALM_TOLERANCE, CALM_STEPS, monitor).point
        yield calm, principal(point)[0]


def _effort(size):
    """How many times the usual numbers of fields are tried on so many nodes."""
    effort = float(np.clip(np.sqrt(size / USUAL_SIZE), LEAST_EFFORT, MOST_EFFORT))
    return min(effort, max(LARGE_SIZE / size, 1.0))


def _carried(stage, seeds, diffusion, metric, monitor):
    """The better part of the seeds after diffusion, carried on by some steps of descent."""

    def settle(batch, batch_monitor):
        return diffuse(stage, batch, diffusion, 1, batch_monitor)

    settled = _in_batches(stage, settle, seeds, monitor)
    settled = _best(stage, settled, round(DESCENDING * seeds.shape[1]))
    return _in_batches(stage, _descent(stage, metric), settled, monitor)


def _descent(stage, metric):
    """The short descent of a batch."""

    def go_on(batch, batch_monitor):
        return polish(stage, batch, metric, batch_monitor, SHORT_STEPS)

    return go_on


def _metrics(stage, times, density):
    """The stage's metrics for times in units of 1 / density, the first and those that reach past the next node.

    In shorter ones hardly anything moves: diffusion is pinned to the nodes.
    """
    times = times / density
    return (stage.metric(1 / tau) for tau in times[: max(np.count_nonzero(times * stage.stiffness >= 1), 1)])


def ground_to_one(piece, columns):
    """Turn every column so that the ground, where there is one, has the phase 1."""
    if piece.ground is None:
        return columns
    value = columns[piece.ground * piece.block]
    return columns * np.conj(value / np.abs(value))
