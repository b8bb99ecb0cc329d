# SPDX-License-Identifier: GPL-3.0-or-later
"""The semidefinite relaxation by Burer-Monteiro factorization, climbing in rank (Algorithm 1).

Each level descends on the product of spheres (Eq. 24), then asks the certificate: stop when the
gap between value and lower bound is small enough, otherwise add the most negative direction of
the slack as a new column and go on. The target is the certified gap, never the gradient: the digits
beyond it are lost in rounding.
"""

from dataclasses import dataclass

import numpy as np

from .certificate import LARGEST_PROOF, depth_for_bound, lower_bound, measure_slack, multipliers, prove
from .descent import descend
from .metric import Metric
from .monitor import OutOfTime
from .spheres import Spheres, random_columns

START_RANK = 6
MAX_RANK = 24
LEVELS = 12
# Metric shift as a share of the mean energy per mass: small enough to leave the metric alone.
SHIFT = 0.1
# The shift of the metric that finds the first smooth point, as a share of the stiffness.
FIRST_SHIFT = 1e-3
LEVEL_STEPS = 300
# Predicted relative decrease at which a level's descent ends, as a share of the target gap.
FIRST_TOLERANCE = 1e-2
TIGHTENING = 0.1


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


def relax(piece, target_gap, seed, monitor, clock):
    """Solve the relaxation of a piece to a certified relative gap.

    Parameters
    ----------
    piece : Piece
    target_gap : (value - bound) / value to reach
    seed : int
    monitor : Monitor
    clock : Clock, gets the seconds under "relax" and "certify"
    """
    random = np.random.default_rng(seed)
    spheres = Spheres(piece.block, lifted=True)
    with clock("relax"):
        metric, point = _start(piece, spheres, random)
    tolerance, best_bound, certificate = FIRST_TOLERANCE * target_gap, 0.0, "proved"
    steps = products = 0
    reached = out_of_time = False
    value = np.inf
    try:
        for _ in range(LEVELS):
            with clock("relax"):
                descent = descend(piece.matrix, spheres, point, metric, tolerance, LEVEL_STEPS, monitor)
            # A sum of squares: <Y, L Y> may fall below zero where the fit is perfect.
            point, value = descent.point, float(piece.energy(descent.point).sum())
            steps, products = steps + descent.steps, products + descent.products
            if value <= piece.noise:
                reached = True  # zero is a bound: L is positive semidefinite
                break
            with clock("certify"):
                duals = multipliers(spheres, point, descent.image)
                slack = measure_slack(piece, metric, duals, random)
                monitor.check()
                bound, kind = _certify(piece, metric, duals, slack, value, target_gap)
            if bound > best_bound or kind == "proved":
                best_bound, certificate = bound, kind
            provable = piece.matrix.shape[0] <= LARGEST_PROOF
            if value - best_bound <= target_gap * value and (certificate == "proved" or not provable):
                reached = True
                break
            with clock("relax"):
                point = _climb(piece, spheres, point, slack.directions)
            tolerance *= TIGHTENING
    except OutOfTime:
        out_of_time = True
    lifted, singular_values = _principal(point)
    if not np.isfinite(value):
        value = float(piece.energy(point).sum())
    return Relaxation(lifted, singular_values, value, best_bound, certificate, reached, out_of_time, steps, products)


def _start(piece, spheres, random):
    """The metric, and a smooth first point: the inverse metric applied to random columns.

    The shift has to be small against the energy per mass, which only the smooth point tells: a
    first metric with a guessed shift finds it.
    """
    point = random_columns(piece, min(START_RANK, piece.matrix.shape[0]), random)
    point = _smooth(Metric(piece, FIRST_SHIFT * piece.stiffness), spheres, point)
    energy = spheres.inner(point, piece.matrix @ point)[0]
    metric = Metric(piece, SHIFT * energy / piece.mass.sum())
    return metric, _smooth(metric, spheres, point)


def _smooth(metric, spheres, point):
    for _ in range(2):
        point = spheres.normalize(metric.solve(point))
    return point


def _certify(piece, metric, duals, slack, value, target_gap):
    """Best bound and its kind.

    "proved" when a factorization shows the slack to be no deeper than the target gap allows; one is
    tried when the estimate says that it may succeed. Otherwise the bound rests on the estimate.
    """
    depth = max(slack.depth, 0.0)
    allowed = depth_for_bound(piece, metric, duals, value * (1 - 0.95 * target_gap))
    if depth <= 0.9 * allowed and prove(piece, metric, duals, allowed):
        return lower_bound(piece, metric, duals, allowed), "proved"
    return lower_bound(piece, metric, duals, depth + slack.error), "estimated"


def _climb(piece, spheres, point, directions):
    """Add the negative directions as columns, as far as they lower the energy most."""
    directions = directions[:, : max(MAX_RANK - point.shape[1], 0)]
    if directions.shape[1] == 0:
        return point
    directions = directions / np.abs(directions).max(axis=0)
    best, best_value = point, np.inf
    for length in 2.0 ** -np.arange(10):
        trial = spheres.normalize(np.hstack([point, length * directions]))
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
