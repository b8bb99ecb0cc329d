# SPDX-License-Identifier: GPL-3.0-or-later
"""The semidefinite relaxation by Burer-Monteiro factorization, climbing in rank (Algorithm 1).

Each level descends on the product of spheres (Eq. 24), then asks the certificate: stop when the
gap between value and lower bound is small enough, otherwise add the most negative direction of
the slack as a new column and go on. The target is the certified gap, never the gradient: the digits
beyond it are lost in rounding.
"""

from dataclasses import dataclass

import numpy as np

from .certificate import lower_bound, measure_slack, multipliers, prove
from .descent import descend
from .metric import Metric
from .monitor import OutOfTime
from .spheres import Spheres, random_columns

START_RANK = 4
MAX_RANK = 16
# Metric shift as a share of the mean energy per mass: small enough to leave the metric alone.
SHIFT = 0.1
LEVEL_STEPS = 200


@dataclass(frozen=True)
class Relaxation:
    """A solution of the relaxation (22) with its bound.

    ``lifted`` is (N, r) in principal columns, singular values descending; ``certificate`` is "proved",
    "estimated"; ``reached`` tells whether the target gap was.
    """

    lifted: np.ndarray
    singular_values: np.ndarray
    value: float
    lower_bound: float
    certificate: str
    reached: bool
    out_of_time: bool
    steps: int
    products: int


def relax(piece, target_gap, seed, monitor, clock, start=None):
    """Solve the relaxation of a piece to a certified relative gap.

    Parameters
    ----------
    piece : Piece
    target_gap : (value - bound) / value to reach
    seed : int
    monitor : Monitor
    clock : Clock, gets the seconds under "relax" and "certify"
    start : (N, r) array, optional warm start
    """
    random = np.random.default_rng(seed)
    spheres = Spheres(piece.block, lifted=True)
    with clock("relax"):
        metric, point = _start(piece, spheres, random, start)
        noise = 1e-13 * np.abs(piece.matrix.diagonal()).sum()
    tolerance, best_bound, certificate = target_gap, -np.inf, "estimated"
    steps = products = 0
    reached = out_of_time = False
    value = np.inf
    try:
        for _ in range(MAX_RANK):
            with clock("relax"):
                descent = descend(piece.matrix, spheres, point, metric, tolerance, LEVEL_STEPS, monitor)
            point, image, value = descent.point, descent.image, float(descent.values[0])
            steps, products = steps + descent.steps, products + descent.products
            if value <= noise:
                best_bound, certificate, reached = 0.0, "proved", True  # L is positive semidefinite
                break
            with clock("certify"):
                duals = multipliers(spheres, point, image)
                slack = measure_slack(piece, metric, duals, 0.1 * target_gap, random)
                monitor.check()
                bound, kind = _certify(piece, metric, duals, slack, value, target_gap)
            if bound > best_bound:
                best_bound, certificate = bound, kind
            if value - best_bound <= target_gap * value:
                reached = True
                break
            if point.shape[1] >= MAX_RANK:
                break
            with clock("relax"):
                point = _climb(piece, spheres, point, slack.direction)
            tolerance = max(0.3 * tolerance, 1e-3 * target_gap)
    except OutOfTime:
        out_of_time = True
    if best_bound <= 0:
        best_bound, certificate = 0.0, "proved"  # L is positive semidefinite
    lifted, singular_values = _principal(point)
    if not np.isfinite(value):
        value = float(piece.energy(point).sum())
    return Relaxation(
        lifted, singular_values, value, best_bound, certificate, reached, out_of_time, steps, products
    )


def _start(piece, spheres, random, start):
    """The metric, and a smooth first point: the inverse metric applied to random columns.

    The shift has to be small against the energy per mass, which only the smooth point tells: a
    first metric with a guessed shift finds it.
    """
    guess = np.abs(piece.matrix.diagonal()).sum() / piece.row_mass.sum() * 1e-3
    if start is None:
        metric = Metric(piece, guess)
        point = random_columns(piece, min(START_RANK, piece.matrix.shape[0]), random)
        point = _smooth(metric, spheres, point)
    else:
        point = spheres.normalize(start)
    energy = spheres.inner(point, piece.matrix @ point)[0]
    metric = Metric(piece, SHIFT * max(energy, 1e-12) / piece.mass.sum())
    return metric, point if start is not None else _smooth(metric, spheres, point)


def _smooth(metric, spheres, point):
    for _ in range(2):
        point = spheres.normalize(metric.solve(point))
    return point


def _certify(piece, metric, duals, slack, value, target_gap):
    """Best bound and its kind: a factorization proves it, or it rests on the Lanczos estimate."""
    estimated_depth = max(slack.depth, 0.0)
    for depth in (max(1.1 * (estimated_depth + slack.error), 0.25 * target_gap), 2 * estimated_depth + target_gap):
        bound = lower_bound(piece, metric, duals, depth)
        if not np.isfinite(depth) or value - bound > 0.9 * value:
            break
        if prove(piece, metric, duals, depth):
            return bound, "proved"
    return lower_bound(piece, metric, duals, estimated_depth + slack.error), "estimated"


def _climb(piece, spheres, point, direction):
    """Add the negative direction as a column, as far as it lowers the energy most."""
    column = direction[:, None] / np.abs(direction).max()
    wider = np.hstack([point, np.zeros_like(column)])
    best, best_value = wider, np.inf
    for length in 2.0 ** -np.arange(0, 10):
        trial = wider.copy()
        trial[:, -1:] = length * column
        trial = spheres.normalize(trial)
        trial_value = spheres.inner(trial, piece.matrix @ trial)[0]
        if trial_value >= best_value:
            break
        best, best_value = trial, trial_value
    return best


def _principal(point):
    """Rotate the columns onto the singular directions, which leaves Y Y^H alone; drop empty ones."""
    left, singular, _ = np.linalg.svd(point, full_matrices=False)
    keep = singular > 1e-6 * singular[0]
    return (left * singular)[:, keep], singular[keep]
