# SPDX-License-Identifier: GPL-3.0-or-later
"""A piece prepared for solving: its matrix in both precisions, and its coarser stages."""

from copy import copy
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from ...algebra.blocks import clip_eigenvalues, on_rows
from ...algebra.coarsening import graph_laplacian, scalar_aggregates, turning_laplacian
from ...algebra.metric import SMALLEST_SHIFT, Hierarchy, Metric, definite_metric
from ...algebra.products import SharedRows
from ...piece import Piece
from .manifolds import Lifted, fields_of
from .signs import Flips

# Shift of the metric of lifted fields as a share of the mean energy per mass. Halved or doubled, the products L Y to a
# gap change by less than 4 % (measured as in :mod:`.staircase`).
LIFTED_SHIFT = 0.1
# The part of the multipliers that is subtracted: with 0, 6 % more products; with 0.6, as many.
SUBTRACTED = 0.4


class Stage:
    """One level of a piece's hierarchy, as a smaller problem of the same kind in single precision.

    Attributes
    ----------
    matrix : in single precision
    row_mass : (N,)
    block, is_complex, is_circle, width, reductions : as in Piece
    lifted, candidates : the manifolds of a lifted field, and of fields in columns
    stiffness : mean diagonal of the matrix per mass
    """

    def __init__(self, piece: Piece, hierarchy: Hierarchy, depth: int) -> None:
        self._hierarchy, self._depth = hierarchy, depth
        self._level = hierarchy.levels[depth]
        self._smallest_shift = SMALLEST_SHIFT * piece.stiffness
        self.matrix: SharedRows = hierarchy.rows(depth)
        self.row_mass: np.ndarray = self._level.row_mass
        self.reductions = piece.reductions
        self.stiffness = float(
            self.reductions.sum(self._level.matrix.diagonal().real.sum()) / self.reductions.sum(self.row_mass.sum())
        )
        self.block, self.is_complex, self.is_circle = piece.block, piece.is_complex, piece.is_circle
        self.width = piece.width
        self.lifted = Lifted(piece.block, piece.width, piece.reductions)
        self.candidates = fields_of(piece)

    @cached_property
    def flips(self) -> Flips | None:
        """:class:`Flips` where fields are signs, which no small move changes, otherwise None."""
        return Flips(self.matrix.matrix) if self.block == 1 and not self.is_complex else None

    @property
    def node_count(self) -> int:
        return int(self.reductions.sum(len(self.row_mass))) // self.block

    def turned(self, matrix: csr_matrix) -> "Stage":
        """The stage with another matrix, whose entries have the same sizes, and the same metrics."""
        stage = copy(self)
        stage.matrix = SharedRows(matrix.astype(self.matrix.dtype))
        return stage

    def metric(self, shift: float) -> Metric:
        """L + shift M with its inverse."""
        return definite_metric(self._hierarchy, max(shift, self._smallest_shift), self._depth)

    def density(self, point: np.ndarray) -> float:
        """Energy per mass of a lifted field."""
        energy = float(self.lifted.energies(point, self.matrix @ point)[0])
        return max(energy, 0.0) * self.block / (self.width * float(self.reductions.sum(self.row_mass.sum())))

    def shift_at(self, point: np.ndarray) -> float:
        """Shift of the metric L + shift M at a lifted field: a small share of its energy per mass."""
        return max(LIFTED_SHIFT * self.density(point), self._smallest_shift)

    def metric_at(self, point: np.ndarray) -> Metric:
        """The metric in which a lifted field descends from a point: L + shift M, less a part of the multipliers.

        The Hessian of the energy on the spheres is the slack S = L - diag(lambda). At the optimum, L less a share t of
        the multipliers is (1 - t) L + t S, which is positive semidefinite. At a point far from the optimum they may be
        too large: then they are left in place.
        """
        point = point.astype(self.matrix.dtype, copy=False)
        diagonal = self._level.matrix.diagonal().real
        duals = clip_eigenvalues(on_rows(self.lifted.multipliers(point, self.matrix @ point), self.block), diagonal)
        shift = self.shift_at(point)
        lowered = self._hierarchy.lowered(SUBTRACTED * duals, self._depth)
        if lowered is not None:
            metric = Metric(lowered, (1 - SUBTRACTED) * shift)
            if metric.is_definite:
                return metric
        return self.metric(shift)

    @cached_property
    def _graph_hierarchy(self) -> Hierarchy:
        return self._scalar_hierarchy(graph_laplacian(self._level.matrix, self.block), turns=False)

    @cached_property
    def _turning_hierarchy(self) -> Hierarchy:
        if self.block == 1:
            return self._graph_hierarchy
        laplacian = turning_laplacian(self._level.matrix, self.block, self._level.ground)
        return self._scalar_hierarchy(laplacian, turns=True)

    def _scalar_hierarchy(self, laplacian: csr_matrix, turns: bool) -> Hierarchy:
        """A hierarchy of one number a node, on the aggregates of the fields' hierarchy."""
        fields = [level.tentative for level in self._hierarchy.levels[self._depth : -1]]
        tentatives = [scalar_aggregates(tentative, self.block, turns) for tentative in fields]
        return Hierarchy(laplacian, self.row_mass[:: self.block], 1, tentatives=tentatives)

    def candidate_metric(self, shift: float) -> Metric:
        """The metric in which candidates descend: of turns on the circle, otherwise of vectors."""
        if not self.is_circle:
            return self.metric(shift)
        return definite_metric(self._turning_hierarchy, max(shift, self._smallest_shift))

    def prepare_candidates(self) -> None:
        """Build what the metrics of candidates and :meth:`smoothing` share, ahead of their first use."""
        _ = self._graph_hierarchy
        if self.is_circle:
            _ = self._turning_hierarchy

    def smoothing(self, shift: float) -> Metric:
        """G + shift M for values on the nodes, with its inverse; G is the Laplacian of the graph."""
        return definite_metric(self._graph_hierarchy, max(shift, self._smallest_shift))

    def prolong(self, fields: np.ndarray) -> np.ndarray:
        """Fields of this stage on the next finer one, not normalized."""
        return self._hierarchy.levels[self._depth - 1].prolongation @ fields

    def restrict(self, fields: np.ndarray) -> np.ndarray:
        """Fields of the next finer stage on this one: weighted sums, not normalized."""
        return self._hierarchy.restricted(fields, self._depth)


class Workspace:
    """A piece with everything that is built once for its solve.

    Attributes
    ----------
    matrix : the piece's matrix in double precision
    stages : the piece itself first, then coarser ones
    """

    def __init__(self, piece: Piece, hierarchy: Hierarchy | None = None, is_rough: bool = False) -> None:
        self.piece = piece
        self.matrix: SharedRows = SharedRows(piece.matrix) if piece.reductions.is_whole else piece.matrix
        hierarchy = hierarchy or Hierarchy(piece.matrix, piece.row_mass, piece.block, piece.ground, is_rough=is_rough)
        self.stages = [Stage(piece, hierarchy, depth) for depth in range(len(hierarchy.levels))]
