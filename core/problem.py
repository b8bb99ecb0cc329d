# SPDX-License-Identifier: GPL-3.0-or-later
"""The one problem: find unit phases that agree as well as they can with a connection (Eqs. 17, 18).

Constraints are merged nodes, ``phi_i = g_i phi_root``, so that phases = P x with a sparse P of unit
blocks and the matrix that is solved is P^H L P. Fixed phases merge into a *ground* node, whose
value is then turned to 1 (Eqs. 25-27); soft wishes are weighted edges to it.
"""

from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from .connection import circle_transports, compose, make_arrays
from .errors import SettingError
from .gauge import balance
from .graphs import components
from .piece import Piece
from .problem_check import check_problem


@dataclass(frozen=True)
class Merged:
    """``phi[nodes] = transports * phi[roots]``: transports as in :class:`Connection`."""

    nodes: np.ndarray
    roots: np.ndarray
    transports: np.ndarray

    def __post_init__(self):
        make_arrays(self, "nodes", "roots", "transports")

    @classmethod
    def none(cls):
        """Of no node on the circle."""
        return cls(np.empty(0, int), np.empty(0, int), np.empty(0, complex))


@dataclass(frozen=True)
class Targets:
    """Values that nodes must have (weights None) or are drawn to: w |phi_i - value|^2.

    ``values`` are complex of unit modulus on the circle, otherwise (k, d) unit vectors.
    """

    nodes: np.ndarray
    values: np.ndarray
    weights: np.ndarray | None = None

    def __post_init__(self):
        make_arrays(self, "nodes", "values", "weights")

    @classmethod
    def none(cls):
        """Of no node on the circle, without weights."""
        return cls(np.empty(0, int), np.empty(0, complex))


def joined_targets(parts):
    """Several :class:`Targets` with weights as one, without those that do not draw."""
    parts = parts or [replace(Targets.none(), weights=np.empty(0))]
    arrays = [np.concatenate([getattr(part, name) for part in parts]) for name in ("nodes", "values", "weights")]
    return Targets(*(array[arrays[2] > 0] for array in arrays))


@dataclass(frozen=True)
class _Embedding:
    """Where the phases of nodes stand among the columns that are solved for.

    Attributes
    ----------
    columns : (n,) column that each node follows
    units : (n,) complex or (n, d, d) phase of each node where its column has the phase 1
    masses, components : (c,) of the columns: their mass, and the label of their component of the graph
    grounds : (labels,) column that is the ground of each component, -1 where there is none
    """

    columns: np.ndarray
    units: np.ndarray
    masses: np.ndarray
    components: np.ndarray
    grounds: np.ndarray


class SynchronizationProblem:
    """A connection with masses and constraints, and the sparse matrices that it comes to.

    Parameters
    ----------
    connection : Connection
    mass : (n,) positive array, optional (ones)
    merged : Merged, optional
    fixed : Targets without weights, optional
    drawn : Targets with weights, optional
    calmer : callable without arguments, optional; asked for (k,) radians that turn the first k transports further, so
        that they contradict each other as little as they can. Circle only.

    What is left out is of no node: the attributes ``merged``, ``fixed`` and ``drawn`` are never None.

    Raises
    ------
    SettingError
        for arrays that do not fit, numbers that are none, negative weights or masses, transports and values that are
        not of unit length; when a node is constrained twice, or merged into a node that is itself constrained
    """

    def __init__(self, connection, mass=None, merged=None, fixed=None, drawn=None, calmer=None):
        check_problem(connection, mass, merged, fixed, drawn)
        if merged is not None and merged.transports.ndim != connection.transports.ndim:
            connection = replace(connection, transports=as_matrices(connection.transports))
            merged = replace(merged, transports=as_matrices(merged.transports))
        self.connection = connection
        count = connection.node_count
        self.mass = np.ones(count) if mass is None else np.asarray(mass, float)
        nobody = np.empty(0, int)
        nothing = np.empty(0, complex) if connection.is_circle else np.empty((0, connection.block))
        self.merged = Merged(nobody, nobody, connection.transports[:0]) if merged is None else merged
        self.fixed = Targets(nobody, nothing) if fixed is None else fixed
        self.drawn = Targets(nobody, nothing, np.empty(0)) if drawn is None else drawn
        self.calmer = calmer
        self._check_constraints()

    def _check_constraints(self):
        constrained, counts = np.unique(np.append(self.merged.nodes, self.fixed.nodes), return_counts=True)
        if (counts > 1).any():
            raise SettingError(f"node {constrained[counts > 1][0]} is constrained twice: keep one of the constraints")
        roots = self.merged.roots[np.isin(self.merged.roots, constrained)]
        if len(roots):
            raise SettingError(f"node {roots[0]} leads a merged group and is constrained itself: fix the group instead")

    @property
    def is_circle(self):
        """Whether phases are given and returned as complex numbers."""
        return self.connection.is_circle

    def turned_by(self, turns):
        """The problem with the first transports turned further by (k,) radians; its pieces have the same rows."""
        twin = copy(self)  # with all that follows from the graph and its flips
        twin.__dict__.pop("factor", None)
        twin.__dict__.pop("pieces", None)
        transports = self.connection.transports.copy()
        units = circle_transports(turns)
        units = units if transports.ndim == 1 else as_matrices(units)
        transports[: len(turns)] = compose(units, transports[: len(turns)])
        twin.connection = replace(self.connection, transports=transports)
        return twin

    # Gauge: turn nodes over where that removes all flips of a component.

    @property
    def _pairs(self):
        """(p, 2) nodes that a transport joins: the edges, and roots with the nodes merged into them."""
        return np.concatenate([self.connection.edges, np.column_stack([self.merged.roots, self.merged.nodes])])

    @cached_property
    def _components(self):
        """(n,) label of the component of the graph that each node is in."""
        return components(self.connection.node_count, self._pairs)

    @cached_property
    def turned(self):
        """(n,) bool: nodes whose coordinates are the conjugate of their phase (circle only)."""
        return self._gauge[0]

    @cached_property
    def _gauge(self):
        count = self.connection.node_count
        if self.connection.block != 2:
            return np.zeros(count, bool), self.connection.transports.ndim == 1
        flips = np.append(_is_flip(self.connection.transports), _is_flip(self.merged.transports))
        turned, balanced = balance(count, self._pairs, flips)
        return turned, bool(balanced.all())

    @property
    def is_complex(self):
        """True when no flip remains, so that one complex row a node does."""
        return self._gauge[1]

    @property
    def block(self):
        return 1 if self.is_complex else self.connection.block

    # Coordinates

    def _transports(self, transports, tails, heads):
        """Transports in the coordinates that are solved: complex numbers or d x d blocks."""
        if not self.is_complex or transports.ndim == 1:
            return transports
        numbers = transports[:, 0, 0] + 1j * transports[:, 1, 0]
        return np.where(self.turned[heads], numbers.conj(), numbers)

    def _values(self, targets):
        """Target values as (k,) complex coordinates or (k, d) vectors."""
        values = np.asarray(targets.values)
        if self.is_complex:
            return np.where(self.turned[targets.nodes], values.conj(), values)
        if np.iscomplexobj(values):
            return np.column_stack([values.real, values.imag])
        return values

    @cached_property
    def _embedding(self):
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
        units[merged.nodes] = self._transports(merged.transports, merged.roots, merged.nodes)
        columns[fixed.nodes] = grounds[labels[fixed.nodes]]
        units[fixed.nodes] = _ground_blocks(self._values(fixed))
        column_count = free.sum() + len(grounded)
        masses = np.bincount(columns, weights=self.mass, minlength=column_count)
        masses[masses == 0] = self.mass.mean()
        column_labels = np.empty(column_count, int)
        column_labels[columns] = labels
        column_labels[free.sum() :] = grounded
        return _Embedding(columns, units, masses, column_labels, grounds)

    @cached_property
    def factor(self):
        """Sparse B with energy = |B x|^2: one block of rows an edge (Eq. 2 in the merged nodes)."""
        columns, units = self._embedding.columns, self._embedding.units
        i, j = self.connection.edges.T
        moved = compose(self._transports(self.connection.transports, i, j), units[i])
        scale = np.sqrt(self.connection.weights)
        parts = [
            (np.arange(len(i)), columns[j], _scaled(units[j], scale)),
            (np.arange(len(i)), columns[i], _scaled(moved, -scale)),
        ]
        nodes, scale = self.drawn.nodes, np.sqrt(np.asarray(self.drawn.weights))
        wished = len(i) + np.arange(len(nodes))
        grounds = self._embedding.grounds[self._components[nodes]]
        parts.append((wished, columns[nodes], _scaled(units[nodes], scale)))
        parts.append((wished, grounds, _scaled(_ground_blocks(self._values(self.drawn)), -scale)))
        rows, places, values = (np.concatenate(part) for part in zip(*parts, strict=True))
        return _block_matrix(rows, places, values, (rows.max(initial=-1) + 1, len(self._embedding.masses)))

    @cached_property
    def pieces(self):
        """The connected pieces that have at least one edge; the others keep the phase 1."""
        embedding = self._embedding
        order = np.lexsort((self._places, embedding.components))
        ends = np.cumsum(np.bincount(embedding.components))
        edge_rows = self._row_pieces(embedding.components)
        pieces = []
        for label, nodes in enumerate(np.split(order, ends[:-1])):
            if len(nodes) and len(edge_rows[label]):
                mass, ground = embedding.masses[nodes], embedding.grounds[label]
                pieces.append(self._piece(nodes, edge_rows[label], mass, ground))
        return pieces

    @cached_property
    def _places(self):
        """(columns,) places in an order in which neighbours are near, so that products find them in the cache."""
        count, edges = self.connection.node_count, self.connection.edges
        graph = coo_matrix((np.ones(len(edges)), edges.T), shape=(count, count))
        order = reverse_cuthill_mckee(graph.tocsr())
        places = np.full(len(self._embedding.masses), len(order))
        places[self._embedding.columns[order[::-1]]] = np.arange(len(order))[::-1]
        return places

    def _row_pieces(self, component):
        """Rows of the factor that belong to each component."""
        factor = self.factor
        filled = np.flatnonzero(np.diff(factor.indptr))
        label = component[factor.indices[factor.indptr[filled]] // self.block]
        order = np.argsort(label, kind="stable")
        return np.split(filled[order], np.cumsum(np.bincount(label, minlength=component.max() + 1))[:-1])

    def _piece(self, nodes, edge_rows, mass, ground_column):
        block = self.block
        rows = (nodes[:, None] * block + np.arange(block)).ravel()
        factor = self.factor if len(rows) == self.factor.shape[1] else self.factor[edge_rows]
        factor = _columns(factor, rows)
        matrix = (factor.conj().T @ factor).tocsr()
        matrix.sum_duplicates()
        ground = None
        if ground_column >= 0:
            ground = int(np.flatnonzero(rows[::block] == ground_column * block)[0])
            unused = ground * block + np.arange(1, block)
            # Rows of the ground beyond its first are zero at every optimum if they cost this much.
            penalty = np.zeros(len(rows))
            penalty[unused] = max(2 * abs(matrix[ground * block, ground * block]), abs(matrix.diagonal()).mean())
            matrix = (matrix + diags_array(penalty)).tocsr() if len(unused) else matrix
        return Piece(matrix, factor, mass, block, self.is_complex, ground, rows)

    def expand(self, coordinates):
        """Phases of all nodes from unit coordinates: (n,) complex on the circle, else (n, d).

        Parameters
        ----------
        coordinates : (N,) array in the rows of :attr:`factor`'s columns
        """
        columns, units = self._embedding.columns, self._embedding.units
        if self.is_complex:
            phases = units * coordinates[columns]
            return np.where(self.turned, phases.conj(), phases)
        vectors = np.einsum("nab,nb->na", units, coordinates.reshape(-1, self.block)[columns])
        return vectors[:, 0] + 1j * vectors[:, 1] if self.is_circle else vectors

    def coordinates(self, phases):
        """(N,) unit coordinates nearest to phases of all nodes: the inverse of :meth:`expand`.

        Parameters
        ----------
        phases : (n,) complex on the circle, else (n, d)
        """
        columns, units = self._embedding.columns, self._embedding.units
        if self.is_complex:
            values = np.where(self.turned, phases.conj(), phases) * units.conj()
        else:
            values = np.column_stack([phases.real, phases.imag]) if np.iscomplexobj(phases) else phases
            values = np.einsum("nba,nb->na", units, values)
        sums = np.zeros((len(self._embedding.masses), *values.shape[1:]), values.dtype)
        np.add.at(sums, columns, values * self.mass.reshape(-1, *[1] * (values.ndim - 1)))
        fallback = self.unit_coordinates().reshape(sums.shape)
        lengths = np.sqrt((np.abs(sums) ** 2).reshape(len(sums), -1).sum(axis=1)).reshape(-1, *[1] * (sums.ndim - 1))
        return np.where(lengths > 0, sums / np.where(lengths > 0, lengths, 1), fallback).ravel()

    def rows_of(self, nodes):
        """(k, block) rows of :meth:`expand`'s coordinates that (k,) nodes follow from."""
        return self._embedding.columns[nodes][:, None] * self.block + np.arange(self.block)

    def unit_coordinates(self):
        """(N,) coordinates with the phase 1 at every node."""
        count = self.factor.shape[1] // self.block
        return np.ones(count, complex) if self.is_complex else np.tile(np.eye(self.block)[0], count)

    def energy(self, phases):
        """Energy of phases as the user knows them: edges plus soft wishes."""
        difference = phases[self.drawn.nodes] - self.drawn.values
        squares = (difference * np.conj(difference)).real.sum(axis=tuple(range(1, difference.ndim)))
        return self.connection.energy(phases) + float(self.drawn.weights @ squares)


def as_matrices(transports):
    """Turns as 2 x 2 matrices; matrices as they are."""
    if transports.ndim == 3:
        return transports
    cosine, sine = transports.real, transports.imag
    return np.stack([np.stack([cosine, -sine], -1), np.stack([sine, cosine], -1)], -2)


def _is_flip(transports):
    if transports.ndim == 1:
        return np.zeros(len(transports), bool)
    return np.linalg.det(transports) < 0


def _ground_blocks(values):
    """The ground is one number; in real coordinates it is the first row of a block."""
    if values.ndim == 1:
        return values
    blocks = np.zeros((*values.shape, values.shape[1]))
    blocks[:, :, 0] = values
    return blocks


def _scaled(blocks, scale):
    return blocks * scale.reshape(-1, *[1] * (blocks.ndim - 1))


def _columns(matrix, columns):
    """Columns of a CSR matrix in a given order, which holds all that have entries."""
    places = np.empty(matrix.shape[1], matrix.indices.dtype)
    places[columns] = np.arange(len(columns))
    parts = (matrix.data.copy(), places[matrix.indices], matrix.indptr)
    return csr_matrix(parts, shape=(matrix.shape[0], len(columns)))


def _block_matrix(rows, columns, values, shape):
    """CSR of (k,) numbers or (k, d, d) blocks at block positions."""
    if values.ndim == 1:
        return coo_matrix((values, (rows, columns)), shape=shape).tocsr()
    block = values.shape[1]
    inner = np.arange(block)
    rows = np.broadcast_to(rows[:, None, None] * block + inner[:, None], values.shape).ravel()
    columns = np.broadcast_to(columns[:, None, None] * block + inner, values.shape).ravel()
    return coo_matrix((values.ravel(), (rows, columns)), shape=(shape[0] * block, shape[1] * block)).tocsr()
