# SPDX-License-Identifier: GPL-3.0-or-later
"""The semidefinite relaxation by Burer-Monteiro factorization, from coarse to fine and climbing in rank (Algorithm 1).

Each stage starts from the coarser one's lifted field and descends on the product of spheres (Eq. 24). On the
last, the certificate is asked: stop when the gap between value and lower bound is small enough,
otherwise add the most negative direction of the slack as a new column and go on. The target is
the certified gap, never the gradient: the digits beyond it are lost in rounding.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

from ..monitor import OutOfTime
from .certificate import depth_for_bound, lower_bound, measure_slack, provable_width, prove
from .descent import descend, rounding_noise
from .solution import Certificate
from .spheres import random_columns
from .stage import SHIFT

# Columns at the start: of complex rows (True), and of real ones, which hold half as much.
START_RANK = {True: 6, False: 9}
# Where no factorization proves, or a gap below this is asked for, more columns at first are cheaper than a second
# search for missing ones.
MORE_COLUMNS, SMALL_GAP = 4 / 3, 5e-3
MAX_RANK = 24
LEVELS = 12
# The shift of the metric that finds the first smooth point, as a share of the stiffness.
FIRST_SHIFT = 1e-3
LEVEL_STEPS = 300
# Predicted relative decrease at which a level's descent ends, as a share of the target gap to the power 3/2:
# the multipliers, and with them the bound, are off by the root of what the energy is off by. Where no factorization
# proves (False), more digits at first are cheaper than a second search for negative directions.
FIRST_TOLERANCE = {True: 0.05, False: 0.01}
# Proofs that fail cost the more the larger the problem is: the tolerance of this many rows, and how it falls.
USUAL_SIZE, FALL_WITH_SIZE = 10_000, 0.25
TIGHTENING = 0.3
# Nodes of the smallest stage that is solved on the way, and the tolerance of descents on coarser stages.
SMALLEST_START = 300
COARSE_TOLERANCE = 3e-3


@dataclass(frozen=True)
class Relaxation:
    """A solution of the relaxation (22) with its bound.

    ``lifted`` is (N, r) in principal columns, singular values descending; ``certificate`` is that of the bound;
    ``reached`` tells whether the target gap was.
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


def relax(workspace, target_gap, seed, monitor, clock, start=None):
    """Solve the relaxation of a piece to a certified relative gap.

    Parameters
    ----------
    workspace : Workspace
    target_gap : (value - bound) / value to reach
    seed : int
    monitor : Monitor
    clock : Clock, gets the seconds under "relax" and "certify"
    start : (N, r) lifted field to start from, optional; otherwise the coarser stages give one
    """
    random = np.random.default_rng(seed)
    piece, stage = workspace.piece, workspace.stages[0]
    lifted = stage.lifted
    steps = products = 0
    with clock("relax"):
        width = provable_width(piece)
        if start is None:
            point = _coarse_start(workspace, start_rank(piece, width is not None, target_gap), random, monitor)
        else:
            point = lifted.normalize(start)
        shift = stage.shift_at(point)
    best_bound, certificate = 0.0, Certificate.PROVED
    reached = out_of_time = precise = False
    memory: list[tuple] = []
    provable = width is not None
    first_tolerance = FIRST_TOLERANCE[provable] * target_gap**1.5
    if provable:
        first_tolerance *= (USUAL_SIZE / piece.matrix.shape[0]) ** FALL_WITH_SIZE
    try:
        for attempt in range(LEVELS):
            tolerance = first_tolerance * TIGHTENING**attempt
            with clock("relax"):
                metric = None  # before the next one takes its room
                metric = monitor.during(partial(stage.metric_at, point))
                for descent in _descents(workspace, point, metric, tolerance, precise, memory, monitor):
                    point, steps, products = descent.point, steps + descent.steps, products + descent.products
                precise = descent.point.dtype == workspace.matrix.dtype
                point = lifted.normalize(point.astype(piece.matrix.dtype))
                image = workspace.matrix @ point
                value = max(float(lifted.energies(point, image)[0]), 0.0)
            if descent.out_of_time:
                raise OutOfTime
            if value <= piece.noise:
                if float(piece.energy(point).sum()) <= piece.perfect:
                    reached = True  # zero is a bound: L is positive semidefinite
                    break
                continue
            with clock("certify"):
                duals = lifted.multipliers(point, image)
                allowed = depth_for_bound(piece, shift, duals, value * (1 - 0.95 * target_gap))
                if provable and monitor.during(partial(prove, piece, shift, duals, allowed, width)):
                    best_bound, certificate, reached = (
                        lower_bound(piece, shift, duals, allowed),
                        Certificate.PROVED,
                        True,
                    )
                    break
                if provable and attempt == 0:
                    continue  # most often a closer point is all that is missing
                enough = -np.inf if provable else allowed
                slack = measure_slack(workspace, shift, metric, point, duals, random, monitor, enough)
                bound = lower_bound(piece, shift, duals, max(slack.depth, 0.0) + slack.error)
            if bound > best_bound:
                best_bound, certificate = bound, Certificate.ESTIMATED
            if not provable and value - best_bound <= target_gap * value:
                reached = True
                break
            if attempt == 0 and slack.depth <= slack.error:
                continue
            with clock("relax"):
                climbed = _climb(workspace, point, slack.directions)
                if climbed is not point:
                    point, memory = climbed, []
        if provable and not reached and value > piece.noise:
            with clock("certify"):
                proved = _weaker_proof(piece, shift, duals, value, target_gap, width, monitor)
            if proved is not None:
                best_bound, certificate = proved, Certificate.PROVED
    except OutOfTime:
        out_of_time = True
    principal, singular_values = _principal(point)
    principal = lifted.normalize(principal)  # without the columns that were dropped
    value = float(piece.energy(principal).sum())
    return Relaxation(principal, singular_values, value, best_bound, certificate, reached, out_of_time, steps, products)


def _weaker_proof(piece, shift, duals, value, target_gap, width, monitor):
    """The tightest bound that can be proved when the target cannot, at tens, hundreds ... of the gap; or None."""
    for gap in target_gap * 10.0 ** np.arange(1, 1 + int(np.log10(0.5 / target_gap))):
        depth = depth_for_bound(piece, shift, duals, value * (1 - gap))
        if monitor.during(partial(prove, piece, shift, duals, depth, width)):
            return lower_bound(piece, shift, duals, depth)
    return None


def start_rank(piece, provable, target_gap):
    """Columns of the lifted field at the start."""
    rank = START_RANK[piece.is_complex]
    if not provable or target_gap < SMALL_GAP:
        rank = round(MORE_COLUMNS * rank)
    return min(rank, piece.matrix.shape[0])


def _coarse_start(workspace, rank, random, monitor):
    """A smooth lifted field, solved for on the coarser stages one after the other."""
    piece = workspace.piece
    stages = [workspace.stages[0]]
    point = random_columns(piece, rank, random)
    for stage in workspace.stages[1:]:
        if stage.node_count < SMALLEST_START:
            break
        stages.append(stage)
        point = stage.restrict(point)
    stage = stages[-1]
    point = _smooth(piece, stage, stage.lifted.normalize(point.astype(stage.matrix.dtype)))
    for stage, finer in zip(stages[:0:-1], stages[-2::-1], strict=True):
        metric = monitor.during(partial(stage.metric, stage.shift_at(point)))
        point = descend(stage.matrix, stage.lifted, point, metric, COARSE_TOLERANCE, LEVEL_STEPS, monitor).point
        point = finer.lifted.normalize(stage.prolong(point))
    return point.astype(workspace.matrix.dtype)


def _smooth(piece, stage, point):
    """A smooth field from a rough one.

    The shift has to be small against the energy per mass, which only the smooth field tells: a first metric
    with a guessed shift finds it.
    """
    density = FIRST_SHIFT * piece.stiffness / SHIFT
    for _ in range(2):
        metric = stage.metric(SHIFT * density)
        for _ in range(2):
            point = stage.lifted.normalize(metric.solve(point))
        density = stage.density(point)
    return point


def _descents(workspace, point, metric, tolerance, precise, memory, monitor):
    """A descent in single precision, and one in double where that is not enough, or was not the last time."""
    stage = workspace.stages[0]
    if not precise:
        start = point.astype(stage.matrix.dtype)
        descent = descend(stage.matrix, stage.lifted, start, metric, tolerance, LEVEL_STEPS, monitor, memory)
        yield descent
        if tolerance * descent.values[0] >= rounding_noise(stage.matrix) or descent.out_of_time:
            return
        point = descent.point.astype(workspace.matrix.dtype)
        memory.clear()
    yield descend(workspace.matrix, stage.lifted, point, metric, tolerance, LEVEL_STEPS, monitor, memory)


def _climb(workspace, point, directions):
    """Add the negative directions as columns, as far as they lower the energy most."""
    lifted = workspace.stages[0].lifted
    directions = directions[:, : max(MAX_RANK - point.shape[1], 0)]
    if directions.shape[1] == 0:
        return point
    directions = directions / np.abs(directions).max(axis=0)
    best, best_value = point, np.inf
    for length in 2.0 ** -np.arange(10):
        trial = lifted.normalize(np.hstack([point, length * directions]))
        trial_value = lifted.energies(trial, workspace.matrix @ trial)[0]
        if trial_value >= best_value:
            break
        best, best_value = trial, trial_value
    return best


def _principal(point):
    """Rotate the columns onto the singular directions, which leaves Y Y^H alone; drop empty ones."""
    squares, rotation = np.linalg.eigh(point.conj().T @ point)
    singular = np.sqrt(np.maximum(squares[::-1], 0))
    keep = singular > 1e-6 * singular[0]
    return point @ rotation[:, ::-1][:, keep], singular[keep]
