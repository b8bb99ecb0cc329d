# SPDX-License-Identifier: GPL-3.0-or-later
"""From a field to one of a problem that differs little, in a part of the time of a solve: what follows a slider.

Descent goes in the metric of turns, which knows of the problem how strongly its edges hold, but not by which angles:
those change with the spacing, the metric does not. So it is made once, and a change costs some steps in single
precision. They need not end where nothing moves any more, since the next change goes on from there.
"""

from functools import partial

import numpy as np

from ..algebra.coarsening import turning_laplacian
from ..algebra.metric import SMALLEST_SHIFT, Hierarchy, definite_metric
from ..algebra.products import SharedRows
from ..algebra.workers import solving
from ..monitor import Monitor
from ..solution import DESCENT, Clock, Options
from .batched.parts import PartResult, Start, combine
from .methods import rounding
from .methods.descent import descend
from .methods.manifolds import fields_of

# Steps of descent after a change, and the predicted relative decrease below which there are fewer.
STEPS, TOLERANCE = 12, 1e-5
# Pieces up to which it pays to go on with each by itself.
MOST_PIECES = 32


class Follower:
    """Keeps the metrics of a problem's pieces for the problems that follow it; to another process it goes empty."""

    def __init__(self):
        self._metrics = {}

    def __reduce__(self):
        return Follower, ()

    def suits(self, problem):
        """Whether a problem is one of turns, in few pieces."""
        return problem.is_circle and len(problem.pieces) <= MOST_PIECES

    def solve(self, problem, phases, callback=None):
        """The :class:`Solution` that some steps from (n,) complex phases lead to, without a bound.

        Raises
        ------
        Cancelled
            when the callback says so
        """
        clock, monitor = Clock(), Monitor(callback)
        options = Options(method=DESCENT)
        with solving():
            with clock("build"):
                pieces, begin = problem.pieces, Start.of(problem, phases)
            with clock("round"):
                monitor.at("descent", 0.0)
                results = [
                    self._followed(n, pieces[n], begin.on(pieces[n]).column, monitor) for n in range(len(pieces))
                ]
        return combine(problem, results, options, clock.seconds)

    def _followed(self, number, piece, column, monitor):
        spheres = fields_of(piece)
        column = spheres.normalize(column)
        if piece.total_weight > 0:
            scaled, _ = piece.scaled()
            matrix = scaled.matrix.astype(np.complex64 if piece.is_complex else np.float32)
            metric = self._metric(number, scaled, matrix, column, monitor)
            start = column.astype(matrix.dtype)
            found = descend(SharedRows(matrix), spheres, start, metric, TOLERANCE, STEPS, monitor).point
            column = spheres.normalize(found.astype(piece.matrix.dtype))
        return PartResult(piece.rows, piece.node_count, rounding.ground_to_one(piece, column))

    def _metric(self, number, piece, matrix, column, monitor):
        """That of a piece with as many numbers, or a new one."""
        key = matrix.shape[0], matrix.nnz
        if number not in self._metrics or self._metrics[number][0] != key:
            density = float(piece.energy(column)[0]) / piece.total_mass
            make = partial(_metric_of_turns, piece, matrix, rounding.CANDIDATE_SHIFT * density)
            self._metrics[number] = key, monitor.during(make)
        return self._metrics[number][1]


def _metric_of_turns(piece, matrix, shift):
    hierarchy = Hierarchy(turning_laplacian(matrix, piece.block, piece.ground), piece.mass, 1)
    return definite_metric(hierarchy, max(shift, SMALLEST_SHIFT * piece.stiffness))
