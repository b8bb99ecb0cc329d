# SPDX-License-Identifier: GPL-3.0-or-later
"""Warm start: from a field to one of a problem that differs little, as when a slider moves, faster than a solve.

The metric of descent, that of turns, depends on the weights of the edges but not on their angles. A new spacing changes
only these, so the metric is made once, and a change costs some steps in single precision. They need not converge,
since the next change goes on from there. The matrix is a constant and a linear function of the cosines and sines of the
angles, and is computed as such.
"""

from dataclasses import replace
from functools import partial

import numpy as np
from scipy.sparse import csr_matrix

from ..algebra.coarsening import turning_laplacian
from ..algebra.metric import SMALLEST_SHIFT, Hierarchy, Metric, definite_metric
from ..algebra.products import SharedRows
from ..algebra.workers import solving
from ..monitor import Callback, Monitor
from ..piece import Piece
from ..problem import SynchronizationProblem
from ..solution import DESCENT, Clock, Options, Solution
from .angle_matrix import AngleMatrix
from .batched.parts import PartResult, Start, combine
from .methods import rounding
from .methods.descent import descend
from .methods.manifolds import fields_of

# Steps of descent after a change, and the predicted relative decrease below which there are fewer.
STEPS, TOLERANCE = 12, 1e-5
# Pieces up to which it pays to treat each by itself.
MOST_PIECES = 32


class Follower:
    """Keeps metrics and matrices of a problem's pieces for the problems that follow it. Pickled, it is empty."""

    def __init__(self) -> None:
        self._metrics: dict[int, tuple[tuple[int, int], Metric]] = {}
        self._matrices: dict[int, tuple[Piece, AngleMatrix]] = {}
        self._before: SynchronizationProblem | None = None
        self._repeats = False

    def __reduce__(self) -> tuple[type["Follower"], tuple[()]]:
        return Follower, ()

    def follow(self, problem: SynchronizationProblem) -> bool:
        """Make a problem the next one to follow; False if :meth:`solve` cannot start from a field of the one before.

        It can on the circle, with at most ``MOST_PIECES`` connected pieces. A problem that differs from the one before
        in angles alone takes over its pieces and hierarchies.
        """
        self._repeats = self._before is not None and problem.adopt(self._before)
        is_followed = problem.is_circle and len(problem.layout) <= MOST_PIECES  # the layout is computed and kept
        self._before = problem.without_matrices
        return is_followed

    def solve(self, problem: SynchronizationProblem, phases: np.ndarray, callback: Callback | None = None) -> Solution:
        """Descend some steps from (n,) complex phases; the solution has no bound.

        Raises :class:`~core.errors.Cancelled` when the callback says so.
        """
        clock, monitor = Clock(), Monitor(callback)
        options = Options(method=DESCENT)
        with solving():
            with clock("build"):
                begin = Start.of(problem, phases)
                pieces = [self._scaled(number, problem) for number in range(len(problem.layout))]
            with clock("round"):
                monitor.at("descent", 0.0)
                results = [
                    self._descend(number, piece, begin.on(piece), monitor) for number, piece in enumerate(pieces)
                ]
        return combine(problem, results, options, clock.seconds)

    def _scaled(self, number: int, problem: SynchronizationProblem) -> Piece:
        """A piece, scaled. Problems that follow one which differs in angles only share its factor and the layout of its
        matrix."""
        if not self._repeats:
            self._matrices.pop(number, None)
        if number in self._matrices:
            piece, matrix = self._matrices[number]
            return replace(piece, matrix=matrix.at(problem.connection.transports))
        piece = problem.pieces[number]
        if piece.total_weight > 0:
            piece, weight = piece.scaled()
            if self._repeats:
                self._matrices[number] = piece, AngleMatrix(problem, piece, weight)
        return piece

    def _descend(self, number: int, piece: Piece, start: Start, monitor: Monitor) -> PartResult:
        """Descend in single precision from the start, on a scaled piece."""
        assert start.column is not None
        spheres = fields_of(piece)
        column = spheres.normalize(start.column)
        if number in self._matrices or piece.total_weight > 0:
            matrix = piece.matrix.astype(np.complex64 if piece.is_complex else np.float32, copy=False)
            metric = self._metric(number, piece, matrix, column, monitor)
            point = column.astype(matrix.dtype)
            point = descend(SharedRows(matrix), spheres, point, metric, TOLERANCE, STEPS, monitor).point
            column = spheres.normalize(point.astype(column.dtype))
        return PartResult(piece.rows, piece.node_count, rounding.ground_to_one(piece, column))

    def _metric(self, number: int, piece: Piece, matrix: csr_matrix, column: np.ndarray, monitor: Monitor) -> Metric:
        """The metric of a piece, kept as long as the size of its matrix does not change."""
        key = matrix.shape[0], matrix.nnz
        known = self._metrics.get(number)
        if known is None or (known[0] != key and not self._repeats):
            density = float(piece.energy(column)[0]) / piece.total_mass
            make = partial(_turning_metric, piece, matrix, rounding.CANDIDATE_SHIFT * density)
            self._metrics[number] = key, monitor.during(make)
        return self._metrics[number][1]


def _turning_metric(piece: Piece, matrix: csr_matrix, shift: float) -> Metric:
    hierarchy = Hierarchy(turning_laplacian(matrix, piece.block, piece.ground), piece.mass, 1)
    return definite_metric(hierarchy, max(shift, SMALLEST_SHIFT * piece.stiffness))
