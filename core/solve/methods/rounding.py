# SPDX-License-Identifier: GPL-3.0-or-later
"""From the lifted field to unit phases (Section 4.5), and on to a local optimum of the problem itself.

Rounding can lose most of what the relaxation gained. Many random projections are tried at once; the best go through a
seeded continuation, diffusion steps with falling times that let defects pair up and settle, and then descend on the
unrelaxed problem (18). The fields found are crossed, each region from the one with less energy there, and continued
again, as long as that pays.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.sparse import csr_matrix

from ...algebra.columns import PAIR, split_columns
from ...algebra.metric import Metric
from ...algebra.workers import idle_workers, pool, share_out
from ...memory import room
from ...monitor import Monitor, OutOfTime
from ...piece import Piece
from .descent import descend
from .diffusion import diffuse
from .manifolds import fields_of, gaussian, principal
from .signs import Flips, knock_outs
from .stage import Stage, Workspace

# Diffusion times of the continuation, in units of 1 / (energy per mass), of which crossings, whose parents have settled
# already, need only the first; and longer times that some projections go through before.
TIMES = 0.3 * 0.1 ** np.arange(3)
LONG_TIMES = 0.7 * 0.6 ** np.arange(4)
# The share of diffused fields that go on to descend.
DESCENDING = 0.5
# Rounds of crossing at least, and the relative gain below which they end.
FEWEST_ROUNDS = 1
GAIN = 2e-3
# The numbers of :class:`Tries` apply to the usual number of nodes. They grow with the root of the size between these
# multiples, so that small meshes try enough and large ones do not take too long. From the large size on they fall to
# the usual ones again, for memory.
USUAL_SIZE, LEAST_EFFORT, MOST_EFFORT, LARGE_SIZE = 5_000, 0.8, 2.0, 1_000_000
# The diffusion time over which local energies are compared, and how sharply the better one is preferred.
CROSSING_TIME = 4.0
SHARPNESS = 5.0
# Fields that agree to this share count as the same.
SAME_FIELD = 0.999
# Descent of the lifted field on the problem with less curl, where rough candidates suffice.
CURL_TOLERANCE, CURL_STEPS = 1e-5, 8
# Steps of descent: between rounds, for the finalists, and for the best one in double precision.
SHORT_STEPS, LONG_STEPS, FINAL_STEPS = 6, 15, 200
FINALISTS = 2
TOLERANCE, FINAL_TOLERANCE = 3e-5, 1e-12
# Numbers in memory at once, and columns of a batch at least: memory, and how soon a solve can be stopped. More cores
# work at once where their batches, of ARRAYS arrays each, take at most this share of the memory.
MOST_AT_ONCE, SMALLEST_BATCH = 1_000_000, 4
ARRAYS, SHARE_OF_MEMORY = 20, 1 / 8
# Numbers, and columns, for which one more thread pays: with four columns a batch, threads wait for the interpreter more
# than they gain, and those that are left share rows instead.
WORTH_SHARING, SHARED_COLUMNS = 100_000, 8
# Metric shift of descents as a share of the energy per mass.
CANDIDATE_SHIFT = 1.0


@dataclass(frozen=True)
class Tries:
    """Numbers of fields that a search tries.

    Attributes
    ----------
    best, drawn : projections of the lifted field that are continued: the best, and for variety some random ones, these
        through longer times first
    kept, crossed : fields that are kept and crossed in pairs, crossings that are continued
    rounds : of crossing at most
    """

    best: int
    drawn: int
    kept: int
    crossed: int
    rounds: int

    def scaled(self, effort: float) -> "Tries":
        """The same search with ``effort`` times as many fields, and as many rounds."""
        more = {name: round(effort * getattr(self, name)) for name in ("best", "drawn", "kept", "crossed")}
        return replace(self, **more)


# For a search on the problem itself alone; for one on the problem with less curl, and the shorter one after it.
ALONE = Tries(14, 5, 7, 20, 5)
LESS_CURL, AFTER = Tries(12, 4, 7, 18, 4), Tries(5, 0, 7, 18, 2)


def random_directions(
    is_complex: bool, rank: int, count: int, random: np.random.Generator, width: int = 1
) -> np.ndarray:
    """(r * width, count + 1) directions: the dominant singular one, and Gaussian ones."""
    leading = np.eye(rank)[:, :width].reshape(-1, 1)
    return np.hstack([leading, gaussian((rank * width, count), is_complex, random)])


def projections(stage: Stage, lifted: np.ndarray, directions: np.ndarray, count: int, monitor: Monitor) -> np.ndarray:
    """The best ``count`` projections Y xi, normalized, best first, on (r * width, k) directions xi (Eq. 29)."""
    dtype = stage.matrix.dtype
    lifted, directions = lifted.astype(dtype), directions.astype(dtype)

    def project(numbers: np.ndarray, batch_monitor: Monitor) -> np.ndarray:
        batch_monitor.check()
        products = np.empty((len(lifted) * stage.width, len(numbers)), dtype)
        for first in range(0, len(numbers), PAIR):
            pair = directions[:, numbers[first : first + PAIR]]
            products[:, first : first + PAIR] = (lifted @ pair.reshape(lifted.shape[1], -1)).reshape(len(products), -1)
        return stage.candidates.normalize(products)

    def energies_of(numbers: np.ndarray, batch_monitor: Monitor) -> np.ndarray:
        return energies(stage, project(numbers, batch_monitor))

    values = _in_batches(stage, energies_of, np.arange(directions.shape[1]), monitor)
    return _in_batches(stage, project, np.argsort(values, kind="stable")[:count], monitor)


def crossings(stage: Stage, columns: np.ndarray, smoothing: Metric, count: int, monitor: Monitor) -> np.ndarray:
    """``count`` crossings of pairs of columns at most, each region mostly from the one with less energy there.

    Those pairs are crossed whose better local energies have the least sum. The pair is first turned to agree as well as
    possible. Local energies are compared after ``smoothing``, a metric of values on the nodes, so that a region holds a
    few defects.
    """
    numbers_a_node = stage.block * stage.width
    local = np.real(columns.conj() * (stage.matrix @ columns))
    local = local.reshape(-1, numbers_a_node, columns.shape[1]).sum(axis=1)
    smooth = smoothing.solve(local)
    pairs = np.transpose(np.triu_indices(columns.shape[1], 1))
    sums = [np.where(smooth[:, i] < smooth[:, j], local[:, i], local[:, j]).sum() for i, j in pairs]
    chosen = pairs[np.argsort(sums, kind="stable")[:count]].T

    def cross(batch: np.ndarray, batch_monitor: Monitor) -> np.ndarray:
        batch_monitor.check()
        first, second = batch
        both = np.abs(smooth[:, first]) + np.abs(smooth[:, second])
        preference = np.tanh(SHARPNESS * (smooth[:, second] - smooth[:, first]) / np.where(both > 0, both, 1))
        preference = np.repeat(preference, numbers_a_node, axis=0)
        kept, joined = np.take(columns, first, axis=1), np.take(columns, second, axis=1)
        joined = stage.candidates.aligned(joined, kept)
        return stage.candidates.normalize((1 + preference) * kept + (1 - preference) * joined)

    return _in_batches(stage, cross, chosen, monitor)


def lowest(stage: Stage, columns: np.ndarray, count: int) -> np.ndarray:
    """The ``count`` columns of least energy, one at least, best first."""
    order = np.argsort(energies(stage, columns), kind="stable")
    return np.take(columns, order[: max(count, 1)], axis=1)


def _in_batches(
    stage: Stage, work: Callable[[np.ndarray, Monitor], np.ndarray], columns: np.ndarray, monitor: Monitor
) -> np.ndarray:
    """The results of work(columns, monitor) on columns, or on their numbers, in batches that all cores share.

    What ``work`` makes of a column must not depend on those beside it: batches differ with the number of cores.
    """
    size, count = stage.matrix.shape[0] * stage.width, columns.shape[-1]
    most = max(MOST_AT_ONCE // 2 // size, SMALLEST_BATCH)
    threads = min(idle_workers(), 1 + size * count // WORTH_SHARING, max(-(-count // SHARED_COLUMNS), 1))
    parts = split_columns(count, threads * -(-count // (most * threads)))
    numbers = size * (parts[0].stop - parts[0].start)
    fitting = SHARE_OF_MEMORY * room().usable / (ARRAYS * stage.matrix.dtype.itemsize * numbers)
    at_once = max(MOST_AT_ONCE // numbers, int(min(fitting, len(parts))), 2)
    batches = [columns[..., part] for part in parts]
    return np.concatenate(share_out(work, batches, monitor, at_once), axis=-1)


def energies(stage: Stage, columns: np.ndarray) -> np.ndarray:
    """(k,) energies of candidates."""
    return stage.candidates.energies(columns, stage.matrix @ columns)


def distinct_columns(stage: Stage, columns: np.ndarray) -> np.ndarray:
    """Columns sorted by energy, best first, without those that equal a better one up to a turn of the whole."""
    columns = lowest(stage, columns, columns.shape[1])
    agreement = stage.candidates.agreements(columns) / stage.node_count
    kept: list[int] = []
    for number in range(columns.shape[1]):
        if not (agreement[number, kept] > SAME_FIELD).any():
            kept.append(number)
    return np.take(columns, kept, axis=1)


def polish(stage: Stage, columns: np.ndarray, metric: Metric, monitor: Monitor, steps: int = LONG_STEPS) -> np.ndarray:
    """Descend on the unrelaxed problem from each column."""
    columns = columns.astype(stage.matrix.dtype)
    if stage.flips is not None:
        return stage.flips.descend(columns)
    return descend(stage.matrix, stage.candidates, columns, metric, TOLERANCE, steps, monitor).point


def finish(workspace: Workspace, column: np.ndarray, metric: Metric, monitor: Monitor) -> np.ndarray:
    """Descend from one field in double precision, down to rounding."""
    stage = workspace.stages[0]
    if stage.flips is not None:
        return stage.flips.descend(column).astype(workspace.matrix.dtype)
    column = column.astype(workspace.matrix.dtype)
    spheres = stage.candidates
    return descend(workspace.matrix, spheres, column, metric, FINAL_TOLERANCE, FINAL_STEPS, monitor).point


def continuation(
    stage: Stage,
    lifted: np.ndarray,
    samples: int,
    density: float,
    random: np.random.Generator,
    monitor: Monitor,
    less_curl: csr_matrix | None = None,
    metric_of_lifted: Metric | None = None,
) -> tuple[np.ndarray, bool]:
    """Fields of low energy by seeded continuation and crossing, best first, and whether time ran out.

    Given ``less_curl``, most of the search is made there, where fewer defects block one another; a shorter search on
    the problem itself starts from the fields found.

    Raises :class:`OutOfTime` when there is no field yet.

    Parameters
    ----------
    stage : of the piece itself
    lifted : (N, r) solution of the relaxation, in principal columns
    samples : random projections tried
    density : energy per mass of the relaxation, positive
    less_curl : matrix of the same problem with less curl
    metric_of_lifted : metric of the lifted field's descent on that problem
    """
    search = _Search(stage, samples, density, random, monitor)
    try:
        if less_curl is None or metric_of_lifted is None:
            search.run(stage, lifted, ALONE, (0.4, 0.9))
        else:
            calmer, point = stage.turned(less_curl), lifted.astype(stage.matrix.dtype)
            limits = CURL_TOLERANCE, CURL_STEPS
            point = descend(calmer.matrix, calmer.lifted, point, metric_of_lifted, *limits, monitor).point
            search.run(calmer, principal(point)[0], LESS_CURL, (0.4, 0.75))
            search.run(stage, lifted, AFTER, (0.75, 0.9))
        if stage.flips is not None:
            search.knock_out(stage.flips, lifted)
        found, metric = search.found, search.metric
        found = np.hstack([polish(stage, found[:, :FINALISTS], metric, monitor), found[:, FINALISTS:]])
    except OutOfTime:
        if search.found.shape[1] == 0:
            raise
        return lowest(stage, search.found, search.found.shape[1]), True
    return distinct_columns(stage, found), False


class _Search:
    """Fields that are continued and crossed, on the matrix itself or on one with less curl.

    Attributes
    ----------
    found : (N, k) fields so far, best first, from which the next search starts
    metric : of descents
    """

    def __init__(
        self, stage: Stage, samples: int, density: float, random: np.random.Generator, monitor: Monitor
    ) -> None:
        self._problem, self._samples, self._density = stage, samples, density
        self._random, self._monitor = random, monitor
        self.found = np.empty((stage.matrix.shape[0] * stage.width, 0), stage.matrix.dtype)
        self.metric = monitor.during(partial(stage.candidate_metric, CANDIDATE_SHIFT * density))
        self._diffusion = monitor.during(partial(pool.map, stage.metric, shifts(stage, TIMES, density)))
        self._smoothing = monitor.during(partial(stage.smoothing, density / CROSSING_TIME))

    def run(self, stage: Stage, lifted: np.ndarray, tries: Tries, fractions: tuple[float, float]) -> None:
        """Find fields of low energy on a stage, from projections of a lifted field and from the fields found before.

        All of them go through diffusion and a short descent. Then, in rounds, the best are kept, crossed in pairs, and
        the crossings diffused and descended again, until the energy hardly falls. ``fractions`` are the parts of the
        whole work, for the monitor, that are done before the first round and after the last.
        """
        tries, monitor = tries.scaled(_effort(stage.node_count)), self._monitor
        directions = random_directions(stage.is_complex, lifted.shape[1], self._samples, self._random, stage.width)
        seeds = projections(stage, lifted, directions, tries.best, monitor)
        before, self.found, best = self.found, np.hstack([seeds[:, :1], self.found]), np.inf
        continued = self._diffuse_and_descend(
            stage, np.hstack([seeds, self._diffuse_random_projections(stage, lifted, directions, tries)])
        )
        if before.shape[1]:
            continued = np.hstack([self._descend(stage, before), continued])
        self.found = seeds[:, :1]  # those found before are in ``continued``, descended
        for round_number in range(1 + tries.rounds):
            self.found = distinct_columns(stage, np.hstack([self.found, continued]))[:, : tries.kept]
            value = energies(stage, self.found[:, :1])[0]
            monitor.found(float(energies(self._problem, self.found[:, :1])[0]), self.found[:, :1])
            monitor.at("continuation", float(np.interp(1 + round_number, (0, 1 + tries.rounds), fractions)))
            settled = round_number >= FEWEST_ROUNDS and value > (1 - GAIN) * best
            if self.found.shape[1] == 1 or settled or round_number == tries.rounds:
                break
            best = value
            seeds = crossings(stage, self.found, self._smoothing, tries.crossed, monitor)
            continued = self._diffuse_and_descend(stage, seeds, self._diffusion[:1])

    def knock_out(self, flips: Flips, lifted: np.ndarray) -> None:
        """Find signs of less energy by crossing many projections of the lifted field (:mod:`.signs`)."""
        stage = self._problem

        def random_projections(most: int) -> np.ndarray:
            count = min(most, self._samples)
            directions = gaussian((lifted.shape[1], count), False, self._random)
            return projections(stage, lifted, directions, count, self._monitor)

        found = knock_outs(flips, random_projections, self.found, self._random, self._monitor)
        self.found = distinct_columns(stage, found)

    def _diffuse_random_projections(
        self, stage: Stage, lifted: np.ndarray, directions: np.ndarray, tries: Tries
    ) -> np.ndarray:
        """Random projections after diffusion with the longer times."""
        if not tries.drawn:
            return self.found[:, :0]
        fields = projections(stage, lifted, directions[:, -tries.drawn :], tries.drawn, self._monitor)
        for shift in shifts(stage, LONG_TIMES, self._density):  # one metric at a time, for memory
            fields = self._diffuse(stage, fields, [stage.metric(shift)])
        return fields

    def _diffuse_and_descend(
        self, stage: Stage, seeds: np.ndarray, diffusion: list[Metric] | None = None
    ) -> np.ndarray:
        """The better part of the seeds after diffusion, and some steps of descent."""
        settled = self._diffuse(stage, seeds, self._diffusion if diffusion is None else diffusion)
        return self._descend(stage, lowest(stage, settled, round(DESCENDING * seeds.shape[1])))

    def _diffuse(self, stage: Stage, columns: np.ndarray, diffusion: list[Metric]) -> np.ndarray:
        """Columns after a diffusion step with each metric."""

        def diffuse_batch(batch: np.ndarray, batch_monitor: Monitor) -> np.ndarray:
            return diffuse(stage, batch, diffusion, 1, batch_monitor)

        return _in_batches(stage, diffuse_batch, columns, self._monitor)

    def _descend(self, stage: Stage, columns: np.ndarray) -> np.ndarray:
        """Columns after a short descent each."""

        def polish_batch(batch: np.ndarray, batch_monitor: Monitor) -> np.ndarray:
            return polish(stage, batch, self.metric, batch_monitor, SHORT_STEPS)

        return _in_batches(stage, polish_batch, columns, self._monitor)


def _effort(size: int) -> float:
    """The multiple of the usual numbers of fields that is tried on ``size`` nodes."""
    effort = float(np.clip(np.sqrt(size / USUAL_SIZE), LEAST_EFFORT, MOST_EFFORT))
    return min(effort, max(LARGE_SIZE / size, 1.0))


def shifts(stage: Stage, times: np.ndarray, density: float) -> np.ndarray:
    """Shifts of the metrics for times in units of 1 / density: the first, and those that reach past the next node.

    In shorter times hardly anything moves: diffusion is pinned to the nodes.
    """
    times = times / density
    longest = times[: max(np.count_nonzero(times * stage.stiffness >= 1), 1)]
    return 1 / longest


def ground_to_one(piece: Piece, columns: np.ndarray) -> np.ndarray:
    """Turn every column so that the ground, if any, has the phase 1."""
    return columns if piece.ground is None else fields_of(piece).ground_to_one(columns, piece.ground)
