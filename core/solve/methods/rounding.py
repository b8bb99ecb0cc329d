# SPDX-License-Identifier: GPL-3.0-or-later
"""From the lifted field to unit phases (Section 4.5), and on to a local optimum of the problem itself.

Rounding is where most of what the relaxation won can be lost. Many random projections are tried at
once; the best are carried through a seeded continuation, diffusion steps with falling times, which
lets defects pair up and settle, and then descend on the unrelaxed problem (18). The fields so found are
crossed, each region from the one that does better there, and carried again, as long as that pays.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...algebra.workers import idle_workers, share_out
from ...monitor import OutOfTime
from .descent import descend
from .diffusion import diffuse
from .manifolds import fields_of, gaussian, principal
from .signs import knock_outs

# Diffusion times of the continuation, in units of 1 / (energy per mass), the first of which does for crossings, whose
# parents have settled already; and a slower fall that some go through before.
TIMES = 0.3 * 0.1 ** np.arange(3)
LONG_TIMES = 0.7 * 0.6 ** np.arange(4)
# The share of carried fields that go on to descend.
DESCENDING = 0.5
# Rounds of crossing at least, and the relative gain below which they end.
FEWEST_ROUNDS = 1
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
    """How many fields a search tries.

    Attributes
    ----------
    best, drawn : projections of the lifted field that are carried: the best, and for variety some at random, through
        the slower fall first
    kept, crossed : fields that are kept and crossed in pairs, crossings that go on
    rounds : of crossing at most
    """

    best: int
    drawn: int
    kept: int
    crossed: int
    rounds: int

    def times(self, effort):
        more = {name: round(effort * getattr(self, name)) for name in ("best", "drawn", "kept", "crossed")}
        return replace(self, **more)


# On a matrix that cannot be calmed; on a calmed one, and on the asked one after it.
ALONE = Tries(14, 5, 7, 20, 5)
CALMED, AFTER = Tries(12, 4, 7, 18, 4), Tries(5, 0, 7, 18, 2)


def random_directions(is_complex, rank, count, random, width=1):
    """(r * width, count + 1) directions: the dominant singular one, and Gaussian ones."""
    leading = np.eye(rank)[:, :width].reshape(-1, 1)
    return np.hstack([leading, gaussian((rank * width, count), is_complex, random)])


def projections(stage, lifted, directions, count, monitor):
    """The best ``count`` of the fields seen along (r * width, k) directions xi, which are Y xi, normalized (Eq. 29)."""
    dtype = stage.matrix.dtype
    lifted, directions = lifted.astype(dtype), directions.astype(dtype)

    def project(numbers):
        seen = lifted @ directions[:, numbers].reshape(lifted.shape[1], -1)
        return stage.candidates.normalize(seen.reshape(-1, len(numbers)))

    return _best_of(stage, project, directions.shape[1], count, monitor)


def crossings(stage, columns, smoothing, count, monitor):
    """The best ``count`` of all pairs of columns joined, each region mostly from the one whose energy is lower there.

    The pair is first turned to agree as well as it can. Local energies are compared after ``smoothing``, a metric of
    values on the nodes, so that a region holds a few defects.
    """
    numbers_a_node = stage.block * stage.width
    local = np.real(columns.conj() * (stage.matrix @ columns))
    local = local.reshape(-1, numbers_a_node, columns.shape[1]).sum(axis=1)
    smooth = smoothing.solve(local)
    pairs = np.transpose(np.triu_indices(columns.shape[1], 1))

    def cross(numbers):
        first, second = pairs[numbers].T
        sums = np.abs(smooth[:, first]) + np.abs(smooth[:, second])
        preference = np.tanh(SHARPNESS * (smooth[:, second] - smooth[:, first]) / np.where(sums > 0, sums, 1))
        preference = np.repeat(preference, numbers_a_node, axis=0)
        kept, joined = np.take(columns, first, axis=1), np.take(columns, second, axis=1)
        joined = stage.candidates.aligned(joined, kept)
        return stage.candidates.normalize((1 + preference) * kept + (1 - preference) * joined)

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


def lowest(stage, columns, count):
    """The ``count`` columns of least energy, one at least, best first."""
    order = np.argsort(energies(stage, columns), kind="stable")
    return np.take(columns, order[: max(count, 1)], axis=1)


def _in_batches(stage, work, columns, monitor):
    """What work(columns, monitor) makes of columns, or of their numbers, in batches that all cores share."""
    size, count = stage.matrix.shape[0] * stage.width, columns.shape[-1]
    most = max(MOST_AT_ONCE // 2 // size, SMALLEST_BATCH)
    fewest = min(size * count // WORTH_SHARING, count // SMALLEST_BATCH, idle_workers())
    batches = np.array_split(columns, max(-(-count // most), fewest, 1), axis=-1)
    at_once = max(MOST_AT_ONCE // (size * batches[0].shape[-1]), 2)
    return np.concatenate(share_out(work, batches, monitor, at_once), axis=-1)


def energies(stage, columns):
    """(k,) energies of candidates."""
    return stage.candidates.energies(columns, stage.matrix @ columns)


def distinct_columns(stage, columns):
    """Columns sorted by energy, best first, without those that agree with a better one but for a turn of the whole."""
    columns = lowest(stage, columns, columns.shape[1])
    agreement = stage.candidates.agreements(columns) / stage.node_count
    kept: list[int] = []
    for number in range(columns.shape[1]):
        if not (agreement[number, kept] > SAME_FIELD).any():
            kept.append(number)
    return np.take(columns, kept, axis=1)


def polish(stage, columns, metric, monitor, steps=LONG_STEPS):
    """Descend on the unrelaxed problem from each column; returns columns sorted by energy, best first."""
    columns = columns.astype(stage.matrix.dtype)
    if stage.flips is not None:
        return lowest(stage, stage.flips.descended(columns), columns.shape[1])
    descent = descend(stage.matrix, stage.candidates, columns, metric, TOLERANCE, steps, monitor)
    return np.take(descent.point, np.argsort(descent.values, kind="stable"), axis=1)


def finish(workspace, column, metric, monitor):
    """Descend from one field to the last digit that matters, in double precision."""
    stage = workspace.stages[0]
    if stage.flips is not None:
        return stage.flips.descended(column).astype(workspace.matrix.dtype)
    column = column.astype(workspace.matrix.dtype)
    spheres = stage.candidates
    return descend(workspace.matrix, spheres, column, metric, FINAL_TOLERANCE, FINAL_STEPS, monitor).point


def continuation(stage, lifted, samples, density, random, monitor, calmed=None, metric_of_lifted=None):
    """Fields by seeded continuation and crossing, best first, and whether time ran out on the way.

    On a slightly calmed problem fewer defects stand in one another's way: what is found there leads to less energy.

    Parameters
    ----------
    stage : Stage of the piece itself
    lifted : (N, r) solution of the relaxation, in principal columns
    samples : random projections tried
    density : energy per mass of the relaxation, positive
    random : numpy Generator
    monitor : Monitor
    calmed : matrix of a calmed problem on the same rows, on which most of the search is made
    metric_of_lifted : in which lifted fields descend on it

    Raises
    ------
    OutOfTime
        when there is no field yet
    """
    search = _Search(stage, samples, density, random, monitor)
    try:
        if calmed is None:
            search.on(stage, lifted, ALONE, (0.4, 0.9))
        else:
            calm = stage.turned(calmed)
            point = lifted.astype(stage.matrix.dtype)
            point = descend(
                calm.matrix, calm.lifted, point, metric_of_lifted, CALM_TOLERANCE, CALM_STEPS, monitor
            ).point
            search.on(calm, principal(point)[0], CALMED, (0.4, 0.75))
            search.on(stage, lifted, AFTER, (0.75, 0.9))
        if stage.flips is not None:
            search.knock_out(lifted)
        found, metric = search.found, search.metric
        found = np.hstack([polish(stage, found[:, :FINALISTS], metric, monitor), found[:, FINALISTS:]])
    except OutOfTime:
        if search.found.shape[1] == 0:
            raise
        return lowest(stage, search.found, search.found.shape[1]), True
    return distinct_columns(stage, found), False


class _Search:
    """Fields that are carried and crossed, on the asked matrix or on one that is calmed.

    Attributes
    ----------
    found : (N, k) fields so far, best first, where a next search goes on
    metric : of descents
    """

    def __init__(self, stage, samples, density, random, monitor):
        self._asked, self._samples, self._density = stage, samples, density
        self._random, self._monitor = random, monitor
        self.found = np.empty((stage.matrix.shape[0] * stage.width, 0), stage.matrix.dtype)
        self.metric = monitor.during(partial(stage.candidate_metric, CANDIDATE_SHIFT * density))
        self._diffusion = monitor.during(partial(list, metrics(stage, TIMES, density)))
        self._smoothing = monitor.during(partial(stage.smoothing, density / CROSSING_TIME))

    def on(self, stage, lifted, tries, fractions):
        """Find fields of low energy on a stage: from projections of a lifted field, and from those found before.

        ``fractions`` of the whole work, which the monitor is told, are done at the start and at the end.
        """
        tries, monitor = tries.times(_effort(stage.node_count)), self._monitor
        directions = random_directions(stage.is_complex, lifted.shape[1], self._samples, self._random, stage.width)
        seeds = projections(stage, lifted, directions, tries.best, monitor)
        before, self.found, best = self.found, np.hstack([seeds[:, :1], self.found]), np.inf
        carried = self._carried(stage, np.hstack([seeds, self._drawn(stage, lifted, directions, tries)]))
        if before.shape[1]:
            carried = np.hstack([self._descended(stage, before), carried])
        self.found = seeds[:, :1]
        for round_number in range(1 + tries.rounds):
            self.found = distinct_columns(stage, np.hstack([self.found, carried]))[:, : tries.kept]
            value = energies(stage, self.found[:, :1])[0]
            monitor.found(float(energies(self._asked, self.found[:, :1])[0]), self.found[:, :1])
            monitor.at("continuation", float(np.interp(1 + round_number, (0, 1 + tries.rounds), fractions)))
            settled = round_number >= FEWEST_ROUNDS and value > (1 - GAIN) * best
            if self.found.shape[1] == 1 or settled or round_number == tries.rounds:
                break
            best = value
            seeds = crossings(stage, self.found, self._smoothing, tries.crossed, monitor)
            carried = self._carried(stage, seeds, self._diffusion[:1])

    def knock_out(self, lifted):
        """Find signs of less energy by crossing many projections of the lifted field."""
        stage = self._asked

        def seeds(most):
            count = min(most, self._samples)
            directions = gaussian((lifted.shape[1], count), False, self._random)
            return projections(stage, lifted, directions, count, self._monitor)

        found = knock_outs(stage.flips, seeds, self.found, self._random, self._monitor)
        self.found = distinct_columns(stage, found)

    def _drawn(self, stage, lifted, directions, tries):
        """Projections at random that have been through the slower fall."""
        drawn = directions[:, directions.shape[1] - tries.drawn :]
        fields = projections(stage, lifted, drawn, tries.drawn, self._monitor) if tries.drawn else self.found[:, :0]
        return diffuse(stage, fields, metrics(stage, LONG_TIMES, self._density), 1, self._monitor)

    def _carried(self, stage, seeds, diffusion=None):
        """The better part of the seeds after diffusion, carried on by some steps of descent."""
        diffusion = self._diffusion if diffusion is None else diffusion

        def settle(batch, batch_monitor):
            return diffuse(stage, batch, diffusion, 1, batch_monitor)

        settled = _in_batches(stage, settle, seeds, self._monitor)
        return self._descended(stage, lowest(stage, settled, round(DESCENDING * seeds.shape[1])))

    def _descended(self, stage, columns):
        """Columns after a short descent each."""

        def go_on(batch, batch_monitor):
            return polish(stage, batch, self.metric, batch_monitor, SHORT_STEPS)

        return _in_batches(stage, go_on, columns, self._monitor)


def _effort(size):
    """How many times the usual numbers of fields are tried on so many nodes."""
    effort = float(np.clip(np.sqrt(size / USUAL_SIZE), LEAST_EFFORT, MOST_EFFORT))
    return min(effort, max(LARGE_SIZE / size, 1.0))


def metrics(stage, times, density):
    """The stage's metrics for times in units of 1 / density, the first and those that reach past the next node.

    In shorter ones hardly anything moves: diffusion is pinned to the nodes.
    """
    times = times / density
    return (stage.metric(1 / tau) for tau in times[: max(np.count_nonzero(times * stage.stiffness >= 1), 1)])


def ground_to_one(piece, columns):
    """Turn every column so that the ground, where there is one, has the phase 1."""
    return columns if piece.ground is None else fields_of(piece).ground_to_one(columns, piece.ground)
