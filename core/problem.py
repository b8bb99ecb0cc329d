# SPDX-License-Identifier: GPL-3.0-or-later
"""The one problem: find unit phases that agree as well as they can with a connection (Eqs. 17, 18).

Constraints are merged nodes, ``phi_i = g_i phi_root``, so that phases = P x with a sparse P of unit
blocks and the matrix that is solved is P^H L P. Fixed phases merge into a *ground* node, whose
value is then turned to 1 (Eqs. 25-27); soft wishes are weighted edges to it.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from .connection import compose, make_arrays
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


def joined_targets(parts):
    """Several :class:`Targets` with weights as one, None where there is nothing to draw."""
    parts = [(part.nodes, part.values, part.weights) for part in parts]
    arrays = [np.concatenate(columns) for columns in zip(*parts, strict=True)]
    drawing = arrays[2] > 0 if arrays else np.empty(0, bool)
    return Targets(*(array[drawing] for array in arrays)) if drawing.any() else None


class SynchronizationProblem:
    """A connection with masses and constraints, and the sparse matrices that it comes to.

    Parameters
    ----------
    connection : Connection
    mass : (n,) positive array, optional (ones)
    merged : Merged, optional
    fixed : Targets without weights, optional
    drawn : Targets with weights, optional

    Raises
    ------
    SettingError
        for arrays that do not fit, numbers that are none, negative weights or masses, transports and values that are
        not of unit length; when a node is constrained twice, or merged into a node that is itself constrained
    """

    def __init__(self, connection, mass=None, merged=None, fixed=None, drawn=None):
        check_problem(connection, mass, merged, fixed, drawn)
        if merged is not None and merged.transports.ndim != connection.transports.ndim:
            connection = replace(connection, transports=as_matrices(connection.transports))
            merged = replace(merged, transports=as_matrices(merged.transports))
        self.connection = connection
        count = connection.node_count
        self.mass = np.ones(count) if mass is None else np.asarray(mass, float)
        self.merged, self.fixed, self.drawn = merged, fixed, drawn
        self._check_constraints()

    def _check_constraints(self):
        constrained = [c.nodes for c in (self.merged, self.fixed) if c is not None]
        nodes = np.concatenate([*constrained, np.empty(0, int)]).astype(int)
        unique, counts = np.unique(nodes, return_counts=True)
        if (counts > 1).any():
            raise SettingError(f"node {unique[counts > 1][0]} is constrained twice: keep one of the constraints")
        if self.merged is not None and np.isin(self.merged.roots, unique).any():
            root = self.merged.roots[np.isin(self.merged.roots, unique)][0]
            raise SettingError(f"node {root} leads a merged group and is constrained itself: fix the group instead")

    @property
    def is_circle(self):
        """Whether phases are given and returned as complex numbers."""
        return self.connection.is_circle

    # Gauge: turn nodes over where that removes all flips of a component.

    @cached_property
    def _links(self):
        """All pairs that a transport joins, with node_count standing for the ground."""
        count = self.connection.node_count
        pairs, transports = [self.connection.edges], [self.connection.transports]
        if self.merged is not None:
            pairs.append(np.column_stack([self.merged.roots, self.merged.nodes]))
            transports.append(self.merged.transports)
        joined = np.concatenate(pairs)
        return joined, transports, components(count, joined)

    @cached_property
    def turned(self):
        """(n,) bool: nodes whose coordinates are the conjugate of their phase (circle only)."""
        return self._gauge[0]

    @cached_property
    def _gauge(self):
        count = self.connection.node_count
        pairs, transports, _ = self._links
        if self.connection.block != 2:
            return np.zeros(count, bool), self.connection.transports.ndim == 1
        flips = np.concatenate([_is_flip(t) for t in transports])
        turned, balanced = balance(count, pairs, flips)
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
        """Column node and unit block of every node, with the count of columns and their masses."""
        count, block = self.connection.node_count, self.block
        components = self._links[2]
        free = np.ones(count, bool)
        for constraint in (self.merged, self.fixed):
            if constraint is not None:
                free[constraint.nodes] = False
        column = np.full(count, -1)
        column[free] = np.arange(free.sum())
        grounded = [t.nodes for t in (self.fixed, self.drawn) if t is not None]
        grounds = np.unique(components[np.concatenate([*grounded, np.empty(0, int)]).astype(int)])
        ground_of = np.full(components.max() + 1, -1)
        ground_of[grounds] = free.sum() + np.arange(len(grounds))
        units = np.ones(count, complex) if self.is_complex else np.tile(np.eye(block), (count, 1, 1))
        if self.merged is not None:
            roots, nodes = self.merged.roots, self.merged.nodes
            column[nodes] = column[roots]
            units[nodes] = self._transports(self.merged.transports, roots, nodes)
        if self.fixed is not None:
            column[self.fixed.nodes] = ground_of[components[self.fixed.nodes]]
            units[self.fixed.nodes] = _ground_blocks(self._values(self.fixed))
        column_count = free.sum() + len(grounds)
        mass = np.bincount(column, weights=self.mass, minlength=column_count)
        mass[mass == 0] = self.mass.mean()
        column_component = np.empty(column_count, int)
        column_component[column] = components
        column_component[free.sum() :] = grounds
        return column, units, mass, column_component, ground_of

    @cached_property
    def factor(self):
        """Sparse B with energy = |B x|^2: one block of rows an edge (Eq. 2 in the merged nodes)."""
        column, units, mass, _, ground_of = self._embedding
        i, j = self.connection.edges.T
        moved = compose(self._transports(self.connection.transports, i, j), units[i])
        scale = np.sqrt(self.connection.weights)
        parts = [
            (np.arange(len(i)), column[j], _scaled(units[j], scale)),
            (np.arange(len(i)), column[i], _scaled(moved, -scale)),
        ]
        if self.drawn is not None:
            nodes = self.drawn.nodes
            scale = np.sqrt(self.drawn.weights)
            ground = ground_of[self._links[2][nodes]]
            wished = len(i) + np.arange(len(nodes))
            parts.append((wished, column[nodes], _scaled(units[nodes], scale)))
            parts.append((wished, ground, _scaled(_ground_blocks(self._values(self.drawn)), -scale)))
        rows, columns, values = (np.concatenate(part) for part in zip(*parts, strict=True))
        return _block_matrix(rows, columns, values, (rows.max(initial=-1) + 1, len(mass)))

    @cached_property
    def pieces(self):
        """The connected pieces that have at least one edge; the others keep the phase 1."""
        _, _, mass, component, ground_of = self._embedding
        order = np.lexsort((self._places, component))
        ends = np.cumsum(np.bincount(component))
        edge_rows = self._row_pieces(component)
        pieces = []
        for label, nodes in enumerate(np.split(order, ends[:-1])):
            if len(nodes) and len(edge_rows[label]):
                pieces.append(self._piece(nodes, edge_rows[label], mass[nodes], ground_of[label]))
        return pieces

    @cached_property
    def _places(self):
        """(columns,) places in an order in which neighbours are near, so that products find them in the cache."""
        column, _, mass = self._embedding[:3]
        order = reverse_cuthill_mckee(_graph(self.connection.node_count, self.connection.edges).tocsr())
        places = np.full(len(mass), len(order))
        places[column[order[::-1]]] = np.arange(len(order))[::-1]
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
        column, units = self._embedding[:2]
        if self.is_complex:
            phases = units * coordinates[column]
            return np.where(self.turned, phases.conj(), phases)
        vectors = np.einsum("nab,nb->na", units, coordinates.reshape(-1, self.block)[column])
        return vectors[:, 0] + 1j * vectors[:, 1] if self.is_circle else vectors

    def coordinates(self, phases):
        """(N,) unit coordinates nearest to phases of all nodes: the inverse of :meth:`expand`.

        Parameters
        ----------
        phases : (n,) complex on the circle, else (n, d)
        """
        column, units, mass = self._embedding[:3]
        if self.is_complex:
            values = np.where(self.turned, phases.conj(), phases) * units.conj()
        else:
            values = np.column_stack([phases.real, phases.imag]) if np.iscomplexobj(phases) else phases
            values = np.einsum("nba,nb->na", units, values)
        sums = np.zeros((len(mass), *values.shape[1:]), values.dtype)
        np.add.at(sums, column, values * self.mass.reshape(-1, *[1] * (values.ndim - 1)))
        fallback = self.unit_coordinates().reshape(sums.shape)
        lengths = np.sqrt((np.abs(sums) ** 2).reshape(len(sums), -1).sum(axis=1)).reshape(-1, *[1] * (sums.ndim - 1))
        return np.where(lengths > 0, sums / np.where(lengths > 0, lengths, 1), fallback).ravel()

    def rows_of(self, nodes):
        """(k, block) rows of :meth:`expand`'s coordinates that (k,) nodes follow from."""
        return self._embedding[0][nodes][:, None] * self.block + np.arange(self.block)

    def unit_coordinates(self):
        """(N,) coordinates with the phase 1 at every node."""
        count = self.factor.shape[1] // self.block
        return np.ones(count, complex) if self.is_complex else np.tile(np.eye(self.block)[0], count)

    def energy(self, phases):
        """Energy of phases as the user knows them: edges plus soft wishes."""
        total = self.connection.energy(phases)
        if self.drawn is not None:
            difference = phases[self.drawn.nodes] - self.drawn.values
            squares = (difference * np.conj(difference)).real.sum(axis=tuple(range(1, difference.ndim)))
            total += float(self.drawn.weights @ squares)
        return total


def as_matrices(transports):
    """Turns as 2 x 2 matrices; matrices as they are."""
    if transports.ndim == 3:
        return transports
    cosine, sine = transports.real, transports.imag
    return np.stack([np.stack([cosine, -sine], -1), np.stack([sine, cosine], -1)], -2)


def _graph(count, pairs):
    return coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count))


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
