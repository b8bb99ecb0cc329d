# SPDX-License-Identifier: GPL-3.0-or-later
"""The synchronization problem: unit phases that agree as well as possible with a connection (Eqs. 17, 18).

Constraints are merged nodes, ``phi_i = g_i phi_root``, so that phases = P x with a sparse P of unit
blocks and the matrix of the solve is P^H L P. Fixed phases merge into a *ground* node, whose
value is then turned to 1 (Eqs. 25-27); soft constraints are weighted edges to it.
"""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from .algebra.blocks import block_matrix, scale_blocks
from .algebra.orthonormal import nearest
from .connection import (
    Connection,
    Fibre,
    Merged,
    Targets,
    are_flips,
    as_matrices,
    circle_transports,
    compose,
    join_targets,
)
from .errors import SettingError
from .gauge import balance
from .graphs import components
from .pieces import Pieces
from .problem_check import check_problem
from .trees import along_trees

__all__ = ["Merged", "SynchronizationProblem", "Targets", "join_targets"]


@dataclass(frozen=True)
class _Embedding:
    """The columns of the solve that the phases of nodes follow from.

    Attributes
    ----------
    columns : (n,) column that each node follows
    units : (n,) complex or (n, d, d) phase of each node when its column has the phase 1
    masses, components : (c,) mass and component label of each column
    grounds : (labels,) column of each component's ground, or -1
    """

    columns: np.ndarray
    units: np.ndarray
    masses: np.ndarray
    components: np.ndarray
    grounds: np.ndarray


@dataclass(frozen=True)
class ColumnLinks:
    """Energy terms weight |after x_head - before x_tail|^2 with (e,) numbers or (e, d, d) blocks.

    The block of a ground has one column only; a ground is a tail or a head of edges, and the tail of soft constraints.
    """

    tails: np.ndarray
    heads: np.ndarray
    before: np.ndarray
    after: np.ndarray
    weights: np.ndarray

    @property
    def scales(self) -> np.ndarray:
        """(r,) weight of each of the factor's rows, both ends together: the scale of its rounding error."""
        squares = np.abs(self.before) ** 2 + np.abs(self.after) ** 2
        if squares.ndim == 3:
            return (self.weights[:, None] * squares.sum(axis=2)).ravel()
        return self.weights * squares


class SynchronizationProblem:
    """A connection with masses and constraints, and the sparse matrices of its energy.

    Raises SettingError for arrays that do not fit, NaN, negative weights or masses, transports and values that are not
    of unit length, a node that is constrained twice, or merged into a constrained node.

    Parameters
    ----------
    mass : (n,) positive, by default ones
    fixed : Targets without weights
    drawn : soft targets: values that nodes are drawn to, with weights
    calmer : computes (k,) radians that turn the first k transports to contradict each other as little as possible.
        Circle only.
    fibre : values of the nodes where transports are d x d matrices

    The attributes ``merged``, ``fixed`` and ``drawn`` are never None.
    """

    def __init__(
        self,
        connection: Connection,
        mass: np.ndarray | None = None,
        merged: Merged | None = None,
        fixed: Targets | None = None,
        drawn: Targets | None = None,
        calmer: Callable[[], np.ndarray] | None = None,
        fibre: str = Fibre.VECTORS,
    ) -> None:
        self.fibre = check_problem(connection, mass, merged, fixed, drawn, fibre)
        if merged is not None and merged.transports.ndim != connection.transports.ndim:
            connection = replace(connection, transports=as_matrices(connection.transports))
            merged = replace(merged, transports=as_matrices(merged.transports))
        self.connection = connection
        count = connection.node_count
        self.mass = np.ones(count) if mass is None else np.asarray(mass, float)
        nobody = np.empty(0, int)
        nothing = np.empty((0, *self.value_shape), complex if self.is_circle else float)
        self.merged = Merged(nobody, nobody, connection.transports[:0]) if merged is None else merged
        self.fixed = Targets(nobody, nothing) if fixed is None else fixed
        self.drawn = Targets(nobody, nothing, np.empty(0)) if drawn is None else drawn
        self.calmer = calmer
        self._check_constraints()

    def _check_constraints(self) -> None:
        constrained, counts = np.unique(np.append(self.merged.nodes, self.fixed.nodes), return_counts=True)
        if (counts > 1).any():
            raise SettingError(f"node {constrained[counts > 1][0]} is constrained twice: keep one of the constraints")
        roots = self.merged.roots[np.isin(self.merged.roots, constrained)]
        if len(roots):
            raise SettingError(f"node {roots[0]} leads a merged group and is constrained itself: fix the group instead")

    @property
    def is_circle(self) -> bool:
        """Whether phases are given and returned as complex numbers."""
        return self.connection.is_circle and self.fibre is Fibre.VECTORS

    @property
    def width(self) -> int:
        """Columns of a node's phase: 1, or d for frames."""
        return self.fibre.width(self.block)

    @property
    def value_shape(self) -> tuple[int, ...]:
        """Shape of a node's phase: () on the circle, (d,) or (d, d)."""
        return () if self.is_circle else (self.block, self.block)[: 1 if self.fibre is Fibre.VECTORS else 2]

    def turned_by(self, turns: np.ndarray) -> Self:
        """Turn the first k transports by (k,) radians more; the pieces keep their rows."""
        transports = self.connection.transports.copy()
        units = circle_transports(turns)
        units = units if transports.ndim == 1 else as_matrices(units)
        transports[: len(turns)] = compose(units, transports[: len(turns)])
        return self.with_transports(transports)

    def with_transports(self, transports: np.ndarray) -> Self:
        """The problem with transports that differ from its own in their angles."""
        twin = self.without_matrices  # keeps all that depends only on the graph and its flips
        twin.connection = replace(self.connection, transports=transports)
        return twin

    def adopt(self, other: "SynchronizationProblem") -> bool:
        """Take what another problem knows if only angles of transports between nodes differ; return whether it did."""
        if (self.fibre, self.connection.node_count, self.connection.transports.shape) != (
            other.fibre,
            other.connection.node_count,
            other.connection.transports.shape,
        ):
            return False
        parts = [
            (
                problem.connection.edges,
                are_flips(problem.connection.transports),
                problem.connection.weights,
                problem.mass,
                *(problem.merged.nodes, problem.merged.roots, problem.merged.transports),
                *(problem.fixed.nodes, problem.fixed.values),
                *(problem.drawn.nodes, problem.drawn.values, problem.drawn.weights),
            )
            for problem in (self, other)
        ]
        if not all(np.array_equal(own, known) for own, known in zip(*parts, strict=True)):
            return False
        names = ("_components", "_gauge", "_embedding", "_places", "layout")
        self.__dict__ |= {name: other.__dict__[name] for name in names if name in other.__dict__}
        return True

    @property
    def without_matrices(self) -> Self:
        """A copy that has to make its matrices again, to be kept for :meth:`adopt`."""
        twin = copy(self)
        kept = {name: value for name, value in self.__dict__.items() if name not in ("factor", "pieces")}
        twin.__dict__ |= kept
        return twin

    def __getstate__(self) -> dict[str, object]:
        """What the problem was made of: in another process, the rest is made again where it is needed."""
        names = ("fibre", "connection", "mass", "merged", "fixed", "drawn", "calmer")
        return {name: self.__dict__[name] for name in names}

    # Gauge: turn nodes over where this removes all flips of a component.

    @property
    def _pairs(self) -> np.ndarray:
        """(p, 2) nodes that a transport joins: edges, and roots with the nodes merged into them."""
        return np.concatenate([self.connection.edges, np.column_stack([self.merged.roots, self.merged.nodes])])

    @cached_property
    def _components(self) -> np.ndarray:
        """(n,) component label of each node."""
        return components(self.connection.node_count, self._pairs)

    @property
    def component_sizes(self) -> np.ndarray:
        """(c,) number of nodes of each component."""
        return np.bincount(self._components)

    @cached_property
    def turned(self) -> np.ndarray:
        """(n,) bool: nodes whose coordinates are the conjugate of their phase (circle only)."""
        return self._gauge[0]

    @cached_property
    def _gauge(self) -> tuple[np.ndarray, bool]:
        count = self.connection.node_count
        if self.connection.block != 2 or not self.is_circle:
            return np.zeros(count, bool), self.connection.transports.ndim == 1
        flips = np.append(are_flips(self.connection.transports), are_flips(self.merged.transports))
        turned, balanced = balance(count, self._pairs, flips)
        return turned, bool(balanced.all())

    @property
    def is_complex(self) -> bool:
        """Whether no flip remains, so that one complex row per node is enough."""
        return self._gauge[1]

    @property
    def block(self) -> int:
        return 1 if self.is_complex else self.connection.block

    # Coordinates

    def _transports(self, transports: np.ndarray, heads: np.ndarray) -> np.ndarray:
        """Convert transports to the coordinates of the solve: complex numbers or d x d blocks."""
        if not self.is_complex or transports.ndim == 1:
            return transports
        numbers = transports[:, 0, 0] + 1j * transports[:, 1, 0]
        return np.where(self.turned[heads], numbers.conj(), numbers)

    def _values(self, targets: Targets) -> np.ndarray:
        """Convert target values to (k,) complex coordinates, (k, d) vectors or (k, d, d) frames."""
        values = np.asarray(targets.values)
        if self.is_complex:
            return np.where(self.turned[targets.nodes], values.conj(), values)
        if np.iscomplexobj(values):
            return np.column_stack([values.real, values.imag])
        return values

    @cached_property
    def _embedding(self) -> _Embedding:
        """Map nodes to columns: free nodes have one each, merged ones their root's, fixed ones the ground's of their
        component."""
        count, labels = self.connection.node_count, self._components
        merged, fixed = self.merged, self.fixed
        free = np.ones(count, bool)
        free[merged.nodes] = free[fixed.nodes] = False
        columns = np.full(count, -1)
        columns[free] = np.arange(free.sum())
        grounded = np.unique(labels[np.append(fixed.nodes, self.drawn.nodes)])
        grounds = np.full(labels.max() + 1, -1)
        grounds[grounded] = free.sum() + np.arange(len(grounded))
        units = np.ones(count, complex) if self.is_complex else np.tile(np.eye(self.block), (count, 1, 1))
        columns[merged.nodes] = columns[merged.roots]
        units[merged.nodes] = self._transports(merged.transports, merged.nodes)
        columns[fixed.nodes] = grounds[labels[fixed.nodes]]
        units[fixed.nodes] = _ground_blocks(self._values(fixed))
        column_count = free.sum() + len(grounded)
        masses = np.bincount(columns, weights=self.mass, minlength=column_count)
        masses[masses == 0] = self.mass.mean()
        column_labels = np.empty(column_count, int)
        column_labels[columns] = labels
        column_labels[free.sum() :] = grounded
        return _Embedding(columns, units, masses, column_labels, grounds)

    @property
    def links(self) -> ColumnLinks:
        """The :class:`ColumnLinks` of edges and soft constraints."""
        columns, units = self._embedding.columns, self._embedding.units
        i, j = self.connection.edges.T
        moved = compose(self._transports(self.connection.transports, j), units[i])
        nodes = self.drawn.nodes
        return ColumnLinks(
            np.append(columns[i], self._embedding.grounds[self._components[nodes]]),
            np.append(columns[j], columns[nodes]),
            np.concatenate([moved, _ground_blocks(self._values(self.drawn))]),
            np.concatenate([units[j], units[nodes]]),
            np.append(self.connection.weights, np.asarray(self.drawn.weights)),
        )

    @cached_property
    def factor(self) -> csr_matrix:
        """Sparse B with energy = |B x|^2, one block of rows per edge: Eq. (2) in the merged nodes."""
        links = self.links
        numbers, scale = np.arange(len(links.tails)), np.sqrt(links.weights)
        rows, places = np.append(numbers, numbers), np.append(links.heads, links.tails)
        values = np.concatenate([scale_blocks(links.after, scale), scale_blocks(links.before, -scale)])
        return block_matrix(rows, places, values, (len(numbers), len(self._embedding.masses)))

    @cached_property
    def pieces(self) -> Pieces:
        """The connected pieces with at least one edge each; other nodes keep the phase 1."""
        return self.layout.with_factor(self.factor)

    @cached_property
    def layout(self) -> Pieces:
        """The :attr:`pieces` without their matrices, which do not depend on how far transports turn."""
        embedding, links = self._embedding, self.links
        labels = np.repeat(embedding.components[links.tails], self.block)
        shape = (embedding.masses, embedding.components, embedding.grounds)
        return Pieces(labels, links.scales, *shape, self._places, self.block, self.is_complex, self.fibre)

    @cached_property
    def _places(self) -> np.ndarray:
        """(columns,) positions in an order that keeps neighbours close, for the cache."""
        count, edges = self.connection.node_count, self.connection.edges
        order = reverse_cuthill_mckee(coo_matrix((np.ones(len(edges)), edges.T), shape=(count, count)).tocsr())
        places = np.full(len(self._embedding.masses), len(order))
        places[self._embedding.columns[order[::-1]]] = np.arange(len(order))[::-1]
        return places

    def along_trees(self) -> np.ndarray:
        """Compute (N,) or (N, d) unit coordinates that fit fixed values and all edges of a spanning tree of each piece.

        They fit all edges of a piece where this is possible.
        """
        links, pieces = self.links, self.pieces
        if links.before.ndim == 1:
            transports = np.conj(links.after) * links.before
        else:
            transports = np.einsum("eba,ebc->eac", links.after, links.before)
        count = len(self._embedding.masses)
        frames = along_trees(count, links.tails, links.heads, transports, pieces.roots)
        return pieces.aligned(frames.reshape(self.block * count, self.block))

    def expand(self, coordinates: np.ndarray) -> np.ndarray:
        """Compute the phases of all nodes from unit coordinates: (n,) complex on the circle, else (n, d) or (n, d, d).

        ``coordinates``: (N,), one for each column of :attr:`factor`; (N, d) for frames.
        """
        columns, units = self._embedding.columns, self._embedding.units
        if self.is_complex:
            phases = units * coordinates[columns]
            return np.where(self.turned, phases.conj(), phases)
        if coordinates.ndim == 2:
            return units @ coordinates.reshape(-1, self.block, self.block)[columns]
        vectors = np.einsum("nab,nb->na", units, coordinates.reshape(-1, self.block)[columns])
        return vectors[:, 0] + 1j * vectors[:, 1] if self.is_circle else vectors

    def coordinates(self, phases: np.ndarray) -> np.ndarray:
        """Find the (N,) or (N, d) unit coordinates nearest to phases of all nodes: the inverse of :meth:`expand`.

        ``phases``: (n,) complex on the circle, else (n, d) or (n, d, d).
        """
        columns, units = self._embedding.columns, self._embedding.units
        if self.is_complex:
            values = np.where(self.turned, phases.conj(), phases) * units.conj()
        else:
            values = np.column_stack([phases.real, phases.imag]) if np.iscomplexobj(phases) else phases
            values = np.einsum("nba,nb...->na...", units, values)
        sums = np.zeros((len(self._embedding.masses), *values.shape[1:]), values.dtype)
        np.add.at(sums, columns, values * self.mass.reshape(-1, *[1] * (values.ndim - 1)))
        if self.width > 1:
            return nearest(sums, self.fibre is Fibre.ROTATIONS).reshape(-1, self.width)
        fallback = self.unit_coordinates().reshape(sums.shape)
        lengths = np.sqrt((np.abs(sums) ** 2).reshape(len(sums), -1).sum(axis=1)).reshape(-1, *[1] * (sums.ndim - 1))
        return np.where(lengths > 0, sums / np.where(lengths > 0, lengths, 1), fallback).ravel()

    def unit_coordinates(self) -> np.ndarray:
        """Build (N,) or (N, d) coordinates with the phase 1 at every node."""
        count = len(self._embedding.masses)
        if self.width > 1:
            return np.tile(np.eye(self.block), (count, 1))
        return np.ones(count, complex) if self.is_complex else np.tile(np.eye(self.block)[0], count)

    def energy(self, phases: np.ndarray) -> float:
        """Compute the energy (Eq. 17) of phases of all nodes: edges plus soft constraints."""
        difference = phases[self.drawn.nodes] - self.drawn.values
        squares = (difference * np.conj(difference)).real.sum(axis=tuple(range(1, difference.ndim)))
        return self.connection.energy(phases) + float(self.drawn.weights @ squares)


def _ground_blocks(values: np.ndarray) -> np.ndarray:
    """Put vectors into the first column of blocks: the ground of vectors is the first row of its block."""
    if values.ndim != 2:
        return values
    blocks = np.zeros((*values.shape, values.shape[1]))
    blocks[:, :, 0] = values
    return blocks
