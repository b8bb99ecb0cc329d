# SPDX-License-Identifier: GPL-3.0-or-later
"""Lifted fields of a given rank that minimize the energy (Eq. 24), from the lifted field of a solution."""

from contextlib import suppress
from functools import partial

import numpy as np

from ..algebra.workers import solving
from ..errors import SettingError
from ..monitor import Callback, Monitor, OutOfTime
from ..piece import Piece
from ..problem import SynchronizationProblem
from ..solution import Options, Solution
from .methods.descent import descend
from .methods.manifolds import Lifted, gaussian
from .methods.stage import Workspace

# Descents at a given rank end when the predicted relative decrease is below this share of the target gap, or after
# this many steps.
TOLERANCE, STEPS = 3e-6, 500
# Descents of a given rank that are started, in single precision, and how many times larger their tolerance is than that
# of the best one. A rough field ends there, after an eighth of the time; its energy is up to 1.3 % larger.
STARTS, EARLY = 4, 1000


def lifted_of_rank(
    problem: SynchronizationProblem,
    solution: Solution,
    rank: int,
    options: Options,
    callback: Callback | None = None,
    start: np.ndarray | None = None,
    is_rough: bool = False,
) -> np.ndarray:
    """(N, rank) lifted field whose energy is a local minimum at its rank (Eq. 24 at a given r).

    Unless a start is given, several projections of the relaxation descend some way, and the best of them to the end;
    where a rough field is enough, the leading columns descend some way.

    Parameters
    ----------
    problem : on the circle
    solution : of the problem, by the method sdp
    rank : columns, 2 for a spherical Clebsch map
    options : of that solution; this descent, too, ends when the time limit for both has passed
    callback : see :func:`core.solve.solve`
    start : (N, rank) lifted field of a nearby problem, optional

    Raises :class:`SettingError` for a solution without a lifted field.
    """
    if solution.lifted is None:
        raise SettingError("there is no lifted field: solve with the method sdp")
    lifted = solution.lifted
    count = 1 if is_rough else STARTS
    starts = _projections(lifted, rank, count, np.random.default_rng(options.seed)) if start is None else [start]
    result = np.array(starts[0])
    left = None if options.time_limit is None else max(options.time_limit - sum(solution.times.values()), 0.0)
    monitor = Monitor(callback, left)
    with solving():
        for piece in problem.pieces:
            points = [Lifted(piece.block).normalize(point[piece.rows]) for point in starts]
            result[piece.rows] = _descend_from(piece, points, TOLERANCE * options.target_gap, is_rough, monitor)
    return result


def _projections(lifted: np.ndarray, rank: int, count: int, random: np.random.Generator) -> list[np.ndarray]:
    """(N, rank) lifted fields: the leading columns, and projections on random directions."""
    if lifted.shape[1] <= rank:
        return [np.pad(lifted, [(0, 0), (0, rank - lifted.shape[1])])]
    shape = (lifted.shape[1], rank)
    return [lifted[:, :rank]] + [lifted @ gaussian(shape, np.iscomplexobj(lifted), random) for _ in range(count - 1)]


def _descend_from(
    piece: Piece, points: list[np.ndarray], tolerance: float, is_rough: bool, monitor: Monitor
) -> np.ndarray:
    """(N, r) the lowest field that descents from (N, r) points reach before time runs out. Unless rough, several points
    are tried on the stage's matrix first, and the best goes on to the full tolerance on the whole one."""
    scaled, _ = piece.scaled()
    best, least = points[0], np.inf
    with suppress(OutOfTime):
        monitor.at(f"rank {points[0].shape[1]}", 0.0)
        workspace = monitor.during(partial(Workspace, scaled))
        stage = workspace.stages[0]
        early = points if is_rough or len(points) > 1 else []
        for point in [*early, *([] if is_rough else [None])]:
            matrix, share = (workspace.matrix, 1) if point is None else (stage.matrix, EARLY)
            start = (best if point is None else point).astype(matrix.dtype)
            metric = monitor.during(partial(stage.metric_at, start))
            descent = descend(matrix, stage.lifted, start, metric, share * tolerance, STEPS, monitor)
            if point is None or descent.values[0] < least:
                best, least = stage.lifted.normalize(descent.point.astype(workspace.matrix.dtype)), descent.values[0]
    return best
