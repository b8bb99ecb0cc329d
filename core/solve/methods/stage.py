# SPDX-License-Identifier: GPL-3.0-or-later
"""A piece prepared for solving: its matrix in both precisions, and its coarser stages."""

from copy import copy
from functools import cached_property

from ...algebra.blocks import clip_eigenvalues, on_rows
from ...algebra.coarsening import graph_laplacian, scalar_aggregates, turning_laplacian
from ...algebra.metric import SMALLEST_SHIFT, Hierarchy, Metric, definite_metric
from ...algebra.products import SharedRows
from .manifolds import Lifted, fields_of
from .signs import Flips

# Shift of the metric of lifted fields as a share of the mean energy per mass. Halved or doubled, the products L Y to a
# gap change by less than 4 % (measured as in :mod:`.staircase`).
LIFTED_SHIFT = 0.1
# The part of the multipliers that is taken off: with none 6 % more products, with 0.6 as many.
TAKEN_OFF = 0.4


class Stage:
    """One level of a piece's hierarchy, as a smaller problem of the same kind in single precision.

    Attributes
    ----------
    matrix : SharedRows, single precision
    row_mass : (N,)
    block, is_complex, is_circle, width : as in Piece
    lifted, candidates : the spheres of a lifted field, and of fields in columns
    held : what adds up over all who hold rows
    stiffness : mean diagonal of the matrix per mass
    """

    def __init__(self, piece, hierarchy, depth):
        self._hierarchy, self._depth = hierarchy, depth
        self._level = hierarchy.levels[depth]
        self._smallest_shift = SMALLEST_SHIFT * piece.stiffness
        self.matrix = hierarchy.rows(depth)
        self.row_mass = self._level.row_mass
        self.held = piece.held
        self.stiffness = float(
            self.held.sum(self._level.matrix.diagonal().real.sum()) / self.held.sum(self.row_mass.sum())
        )
        self.block, self.is_complex, self.is_circle = piece.block, piece.is_complex, piece.is_circle
        self.width = piece.width
        self.lifted = Lifted(piece.block, piece.width, piece.held)
        self.candidates = fields_of(piece)

    @cached_property
    def flips(self):
        """:class:`Flips` where fields are signs, which nothing else changes, otherwise None."""
        return Flips(self.matrix.matrix) if self.block == 1 and not self.is_complex else None

    @property
    def node_count(self):
        return self.held.sum(len(self.row_mass)) // self.block

    def turned(self, matrix):
        """The stage with another matrix of the same sizes of entries, which keeps this one's metrics."""
        stage = copy(self)
        stage.matrix = SharedRows(matrix.astype(self.matrix.dtype))
        return stage

    def metric(self, shift):
        """L + shift M with its inverse."""
        return definite_metric(self._hierarchy, max(shift, self._smallest_shift), self._depth)

    def density(self, point):
        """Energy per mass of a lifted field."""
        energy = float(self.lifted.energies(point, self.matrix @ point)[0])
        return max(energy, 0.0) * self.block / (self.width * float(self.held.sum(self.row_mass.sum())))

    def shift_at(self, point):
        """Shift of the metric of lifted fields: small enough to leave the metric alone."""
        return max(LIFTED_SHIFT * self.density(point), self._smallest_shift)

    def metric_at(self, point):
        """The metric in which a lifted field descends from a point: L + shift M, less a part of the multipliers.

        The Hessian of the energy on the spheres is the slack S = L - diag(lambda). Where the multipliers are those of
        the optimum, L less a share of them is positive semidefinite, being the other share of L and that one of S. At a
        point that is far from it, as a rough one, they may be too large: then none are taken off.
        """
        point = point.astype(self.matrix.dtype, copy=False)
        diagonal = self._level.matrix.diagonal().real
        duals = clip_eigenvalues(on_rows(self.lifted.multipliers(point, self.matrix @ point), self.block), diagonal)
        shift = self.shift_at(point)
        lowered = self._hierarchy.lowered(TAKEN_OFF * duals, self._depth)
        if lowered is not None:
            metric = Metric(lowered, (1 - TAKEN_OFF) * shift)
            if metric.is_definite:
                return metric
        return self.metric(shift)

    @cached_property
    def _graph_hierarchy(self):
        return self._scalar_hierarchy(graph_laplacian(self._level.matrix, self.block), turns=False)

    @cached_property
    def _turning_hierarchy(self):
        if self.block == 1:
            return self._graph_hierarchy
        laplacian = turning_laplacian(self._level.matrix, self.block, self._level.ground)
        return self._scalar_hierarchy(laplacian, turns=True)

    def _scalar_hierarchy(self, laplacian, turns):
        """A hierarchy of one number a node, with the aggregates of the fields'."""
        fields = [level.tentative for level in self._hierarchy.levels[self._depth : -1]]
        tentatives = [scalar_aggregates(tentative, self.block, turns) for tentative in fields]
        return Hierarchy(laplacian, self.row_mass[:: self.block], 1, tentatives=tentatives)

    def candidate_metric(self, shift):
        """The metric in which candidates descend: of turns on the circle, otherwise of vectors."""
        if not self.is_circle:
            return self.metric(shift)
        return definite_metric(self._turning_hierarchy, max(shift, self._smallest_shift))

    def smoothing(self, shift):
        """G + shift M for values on the nodes, with its inverse; G is the Laplacian of the graph."""
        return definite_metric(self._graph_hierarchy, max(shift, self._smallest_shift))

    def prolong(self, fields):
        """Fields of this stage on the next finer one, not normalized."""
        return self._hierarchy.levels[self._depth - 1].prolongation @ fields

    def restrict(self, fields):
        """Fields of the next finer stage on this one: weighted sums, not normalized."""
        return self._hierarchy.restricted(fields, self._depth)


class Workspace:
    """A piece with everything that is made once for its solve.

    Attributes
    ----------
    piece : Piece
    matrix : SharedRows, the piece's matrix in double precision
    stages : list of Stage, the piece itself first
    """

    def __init__(self, piece):
        self.piece = piece
        self.matrix = SharedRows(piece.matrix)
        hierarchy = Hierarchy(piece.matrix, piece.row_mass, piece.block, piece.ground)
        self.stages = [Stage(piece, hierarchy, depth) for depth in range(len(hierarchy.levels))]
