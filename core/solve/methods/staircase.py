# SPDX-License-Identifier: GPL-3.0-or-later
"""The semidefinite relaxation by Burer-Monteiro factorization, from coarse to fine and with rising rank (Algorithm 1).

Each stage starts from the coarser one's lifted field and descends on the product of spheres (Eq. 24). On the finest,
the certificate gives a lower bound: stop when its gap is small enough, otherwise add the most negative direction of the
slack as a new column and go on. The target is the certified gap, never the gradient: digits beyond it are lost in
rounding.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from ...algebra.metric import Metric
from ...algebra.products import Matrix
from ...memory import room
from ...monitor import Monitor, OutOfTime, Running
from ...piece import Piece
from ...solution import Certificate, Clock, Options
from .certificate import ProofPlan, depth_for_bound, lower_bound, measure_slack, plan_proof, prove
from .descent import Descent, Memory, descend, rounding_noise
from .initial_field import coarse_field
from .manifolds import principal
from .memory_estimate import search_bytes
from .stage import Workspace

# The constants were chosen by the number of products L Y to gaps of 1e-2 and 1e-3 with one of them halved or doubled,
# geometric means over n = 1, n = 4 and stripes on spot and cheburashka (3k and 7k vertices). For FALL_WITH_SIZE and
# TIGHTENING, and for FIRST_SHIFT, SMALLEST_START and COARSE_TOLERANCE in :mod:`.initial_field`, it changes by < 5 %.

# Columns at the start: of complex rows (True), and of real ones, which hold half as much. With half as many, 15 % fewer
# products, but up to 4 times as many on one of the twelve, and more time for directions; with twice as many, 2 times.
START_RANK = {True: 6, False: 9}
# Without a proof by factorization, or for a target gap below this, more columns at first are cheaper than a second
# search for missing ones.
MORE_COLUMNS, SMALL_GAP = 4 / 3, 5e-3
MAX_RANK = 24
# Descents, each followed by a bound, and steps of one at most.
ATTEMPTS, DESCENT_STEPS = 12, 300
# Predicted relative decrease at which the first descent ends, as a share of the target gap to the power 3/2: the error
# of the multipliers, and so of the bound, is the root of that of the energy. Without a proof by factorization (False),
# more digits at first are cheaper than a second search for negative directions. Halved, 22 % more products; doubled,
# 3 % fewer, but up to 29 % more.
FIRST_TOLERANCE = {True: 0.05, False: 0.01}
# Failed proofs cost more on larger problems: the size to which the tolerance applies, and the power by which it falls.
USUAL_SIZE, FALL_WITH_SIZE = 10_000, 0.25
# Ratio of the tolerances of consecutive descents.
TIGHTENING = 0.3
# The share of the target gap that a bound has to reach, so that the target still holds when the value is measured
# again in the end, as a sum of squares and without empty columns.
AIMED_AT = 0.95
# The largest gap at which a proof is still tried where the target cannot be proved.
WEAKEST_GAP = 0.5
# Lengths at which new columns, whose largest entries are 1, are tried.
NEW_LENGTHS = 2.0 ** -np.arange(10)


@dataclass(frozen=True)
class Relaxation:
    """A solution of the relaxation (22) with its bound.

    ``lifted`` is (N, r) in principal columns, singular values descending; ``certificate`` is that of the bound;
    ``reached`` says whether the target gap was reached; ``metric`` is that of the last descent.
    """

    lifted: np.ndarray
    singular_values: np.ndarray
    value: float
    lower_bound: float
    certificate: Certificate
    reached: bool
    out_of_time: bool
    steps: int
    products: int
    metric: Metric | None


# Called during a proof, with the result of the relaxation if the proof succeeds.
Meanwhile: TypeAlias = Callable[[Relaxation, Running[bool]], None]


def relax(
    workspace: Workspace,
    options: Options,
    monitor: Monitor,
    clock: Clock,
    start: np.ndarray | None = None,
    meanwhile: Meanwhile | None = None,
) -> Relaxation:
    """Solve the relaxation of a piece to a certified relative gap (Algorithm 1).

    It starts from an (N, r) lifted field, or from one of the coarser stages. The clock gets the seconds under "relax"
    and "certify". Of the options, gap, seed and ``long_proofs`` are used. Given ``meanwhile``, proofs to the target gap
    run beside it, in their own thread, if there is memory for both.
    """
    search = _Search(workspace, options, monitor, clock, start, meanwhile)
    try:
        for attempt in range(ATTEMPTS):
            search.descend(search.first_tolerance * TIGHTENING**attempt)
            if not search.out_of_time:
                search.certify(is_first=attempt == 0)
            if search.reached or search.out_of_time:
                break
        else:
            search.prove_weaker()
    except OutOfTime:
        search.out_of_time = True
    return search.result()


class _Search:
    """A point that descends and a bound that rises, until they meet.

    Attributes
    ----------
    point : (N, r) lifted field
    value : its energy, not negative
    bound, certificate : the best lower bound so far, and its Certificate
    reached : whether the gap between value and bound is at most the target
    out_of_time : whether the time limit ended the search
    first_tolerance : of the first descent
    """

    def __init__(
        self,
        workspace: Workspace,
        options: Options,
        monitor: Monitor,
        clock: Clock,
        start: np.ndarray | None,
        meanwhile: Meanwhile | None,
    ) -> None:
        self._workspace, self._monitor, self._clock, self._meanwhile = workspace, monitor, clock, meanwhile
        target_gap = self._target_gap = options.target_gap
        self._random = np.random.default_rng(options.seed)
        piece, stage = workspace.piece, workspace.stages[0]
        with clock("relax"):
            self._plan = monitor.during(partial(plan_proof, piece, options.long_proofs))
            if start is None:
                rank = start_rank(piece, self._is_provable, target_gap)
                self.point = _coarse_start(workspace, rank, self._random, monitor)
            else:
                self.point = stage.lifted.normalize(start)
            self._shift = stage.shift_at(self.point)
        self.bound, self.certificate = 0.0, Certificate.PROVED
        self.reached = self.out_of_time = False
        self._proved: Relaxation | None = None
        self._steps = self._products = 0
        self._needs_double = False
        self._memory: Memory = []
        self._metric: Metric | None = None
        self.first_tolerance = FIRST_TOLERANCE[self._is_provable] * target_gap**1.5
        if self._is_provable:
            self.first_tolerance *= (USUAL_SIZE / piece.matrix.shape[0]) ** FALL_WITH_SIZE

    @property
    def _is_provable(self) -> bool:
        return self._plan is not None

    def descend(self, tolerance: float) -> None:
        """Descend to a tolerance in the metric of the point, in double precision where single is not enough."""
        workspace, stage = self._workspace, self._workspace.stages[0]
        with self._clock("relax"):
            self._metric = None  # frees its memory before the next one is built
            self._metric = self._monitor.during(partial(stage.metric_at, self.point))
            if not self._needs_double:
                descent = self._descend_by(stage.matrix, tolerance)
                noise = rounding_noise(stage.matrix, stage.lifted.reductions)
                self._needs_double = not (tolerance * descent.values[0] >= noise or descent.out_of_time)
                if self._needs_double:
                    self._memory.clear()
            if self._needs_double:
                self._descend_by(workspace.matrix, tolerance)
            self._needs_double = self.point.dtype == workspace.matrix.dtype
            self.point = stage.lifted.normalize(self.point.astype(workspace.piece.matrix.dtype))
            image = workspace.matrix @ self.point
            self.value = max(float(stage.lifted.energies(self.point, image)[0]), 0.0)
            self._duals = stage.lifted.multipliers(self.point, image)

    def _descend_by(self, matrix: Matrix, tolerance: float) -> Descent:
        """Descend in the precision of a matrix, to a tolerance."""
        assert self._metric is not None
        start, lifted = self.point.astype(matrix.dtype), self._workspace.stages[0].lifted
        descent = descend(matrix, lifted, start, self._metric, tolerance, DESCENT_STEPS, self._monitor, self._memory)
        self.point, self.out_of_time = descent.point, descent.out_of_time
        self._steps, self._products = self._steps + descent.steps, self._products + descent.products
        return descent

    def certify(self, is_first: bool) -> None:
        """Compute a bound at the point; where it is too low, add columns along negative directions of the slack.

        The first point is often merely too far from the optimum: there only clearly negative directions are used.
        """
        workspace, piece = self._workspace, self._workspace.piece
        if self.value <= piece.noise:
            # Zero is a bound: L is positive semidefinite.
            self.reached = float(piece.energy(self.point).sum()) <= piece.perfect
            return
        allowed = self._depth_at(AIMED_AT * self._target_gap)
        if self._is_provable:
            self.reached = self._prove(allowed, self._meanwhile)
            if self.reached or is_first:
                return
        with self._clock("certify"):
            assert self._metric is not None  # there was a descent
            enough = -np.inf if self._is_provable else allowed
            state = self._shift, self._metric, self.point, self._duals
            slack = measure_slack(workspace, *state, self._random, self._monitor, enough)
            bound = lower_bound(piece, self._shift, self._duals, max(slack.depth, 0.0) + slack.error)
        if bound > self.bound:
            self.bound, self.certificate = bound, Certificate.ESTIMATED
        if not self._is_provable and self.value - self.bound <= self._target_gap * self.value:
            self.reached = True
        elif slack.depth > slack.error or not is_first:
            with self._clock("relax"):
                self._add_columns(slack.directions)

    def prove_weaker(self) -> None:
        """Where the target is out of reach, accept a gap that is only rounding, otherwise prove a weaker bound."""
        noise, target = self._workspace.piece.noise, self._target_gap * self.value
        if self.value - self.bound <= target + noise:
            self.reached = True
        elif self._is_provable:
            self.reached = self._prove(self._depth_to(self.value - target - noise))
            if self.reached:
                return
            weaker = 10.0 ** np.arange(1, 1 + int(np.log10(WEAKEST_GAP / self._target_gap)))
            for gap in self._target_gap * weaker:
                if self._prove(self._depth_at(gap)):
                    return

    def _depth_at(self, gap: float) -> float:
        """The depth of the slack below zero at which the bound has a relative gap from the value."""
        return self._depth_to(self.value * (1 - gap))

    def _depth_to(self, bound: float) -> float:
        return depth_for_bound(self._workspace.piece, self._shift, self._duals, bound)

    def _prove(self, depth: float, meanwhile: Meanwhile | None = None) -> bool:
        """Whether the bound of a depth can be proved; it then becomes the bound."""
        if self._plan is None:
            return False
        piece = self._workspace.piece
        proof = partial(prove, piece, self._shift, self._duals, depth, self._plan)
        bound = lower_bound(piece, self._shift, self._duals, depth)
        if meanwhile is None or not self._has_room_for_both(self._plan):
            with self._clock("certify"):
                is_proved = self._monitor.during(proof)
        else:
            running = Running(proof)
            with_bound = replace(self.result(), lower_bound=bound, certificate=Certificate.PROVED, reached=True)
            meanwhile(with_bound, running)
            with self._clock("certify"):
                is_proved = self._monitor.wait_for(running)
            self._proved = with_bound if is_proved else None
        if is_proved:
            self.bound, self.certificate = bound, Certificate.PROVED
        return is_proved

    def _has_room_for_both(self, plan: ProofPlan) -> bool:
        """Whether there is memory for a proof and the search for phases at the same time."""
        piece = self._workspace.piece
        rows, entries = piece.matrix.shape[0], piece.matrix.nnz
        both = search_bytes(rows, entries, piece.is_complex) + plan.bytes
        return both <= room().usable

    def _add_columns(self, directions: np.ndarray) -> None:
        """Add negative directions of the slack as columns, as far as they lower the energy most."""
        matrix, lifted = self._workspace.matrix, self._workspace.stages[0].lifted
        directions = directions[:, : max(MAX_RANK - self.point.shape[1], 0)]
        if directions.shape[1] == 0:
            return
        directions = directions / self._workspace.piece.reductions.max(np.abs(directions).max(axis=0))
        best, best_value = self.point, np.inf
        for length in NEW_LENGTHS:
            trial = lifted.normalize(np.hstack([self.point, length * directions]))
            trial_value = lifted.energies(trial, matrix @ trial)[0]
            if trial_value >= best_value:
                break
            best, best_value = trial, trial_value
        self.point, self._memory = best, []

    def result(self) -> Relaxation:
        """The :class:`Relaxation` at the point, in principal columns, or the one with the bound that :meth:`_prove` has
        proved."""
        if self._proved is not None:
            return self._proved
        point, singular_values = principal(self.point, self._workspace.piece.reductions)
        point = self._workspace.stages[0].lifted.normalize(point)  # without the columns that were dropped
        return Relaxation(
            point,
            singular_values,
            float(self._workspace.piece.energy(point).sum()),
            self.bound,
            self.certificate,
            self.reached,
            self.out_of_time,
            self._steps,
            self._products,
            self._metric,
        )


def start_rank(piece: Piece, provable: bool, target_gap: float) -> int:
    """Columns of the lifted field at the start: for frames more than twice as many as they have."""
    rank = max(START_RANK[piece.is_complex], 2 * piece.width + 3)
    if not provable or target_gap < SMALL_GAP:
        rank = round(MORE_COLUMNS * rank)
    return min(rank, int(piece.matrix.shape[0]))


def _coarse_start(workspace: Workspace, rank: int, random: np.random.Generator, monitor: Monitor) -> np.ndarray:
    """(N, rank) smooth lifted field on the finest stage."""
    stage, point = coarse_field(workspace, rank, random, monitor, DESCENT_STEPS)
    finest = workspace.stages[0]
    if stage is not finest:
        point = finest.lifted.normalize(stage.prolong(point))
    return point.astype(workspace.matrix.dtype)
