# SPDX-License-Identifier: GPL-3.0-or-later
"""What each of many processes holds of a connection on the circle, and its matrices."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from ..connection import Connection
from ..piece import Piece
from .rows import SpreadReductions, SpreadRows, petsc_matrix


@dataclass(frozen=True)
class Part:
    """What a process holds of a connected connection on the circle without flips: a range of its nodes.

    Attributes
    ----------
    first : number of the first node held here; the ranges follow one another in the order of the processes
    connection : Connection of all nodes, with those edges alone that have an end held here: an edge between two
        processes is given to both
    mass : (n,) positive, of the nodes held here
    """

    first: int
    connection: Connection
    mass: np.ndarray

    @property
    def count(self):
        """Nodes held here."""
        return len(self.mass)

    def holds(self, nodes):
        """(k,) bool: whether nodes are held here."""
        return (nodes >= self.first) & (nodes < self.first + self.count)


def parts_of(connection, mass, processes):
    """The :class:`Part` of each of so many processes, and the nodes of the connection in the order of the parts.

    Neighbours are near in that order, so that few edges are between processes.

    Parameters
    ----------
    connection : Connection on the circle without flips
    mass : (n,) positive
    processes : how many
    """
    count, (i, j) = connection.node_count, connection.edges.T
    graph = coo_matrix((np.ones(len(i), np.int8), (i, j)), shape=(count, count))
    order = reverse_cuthill_mckee((graph + graph.T).tocsr(), symmetric_mode=True)
    places = np.empty(count, int)
    places[order] = np.arange(count)
    edges, parts = places[connection.edges], []
    ends = np.arange(processes + 1) * count // processes
    for first, last in pairwise(ends):
        near = np.flatnonzero(((edges >= first) & (edges < last)).any(axis=1))
        own = Connection(count, edges[near], connection.weights[near], connection.transports[near])
        parts.append(Part(int(first), own, mass[order[first:last]]))
    return parts, order


def piece_of(part, comm):
    """The piece of all processes at a mean diagonal and a mean mass of 1.

    Parameters
    ----------
    part : Part of this process
    comm : MPI communicator

    Returns
    -------
    piece : Piece, of which this process holds its rows
    whole : PETSc.Mat, its matrix
    weight : what energies were divided by
    """
    held, count = SpreadReductions(comm), part.connection.node_count
    laplacian, factor = _laplacian(part), _factor(part)
    weight = float(held.sum(laplacian.diagonal(part.first).real.sum())) / count
    whole = petsc_matrix(laplacian / weight, comm, part.count)
    piece = Piece(
        SpreadRows.of(whole, complex),
        SpreadRows.of(petsc_matrix(factor / np.sqrt(weight), comm, part.count), complex),
        part.mass * (count / held.sum(part.mass.sum())),
        block=1,
        is_complex=True,
        ground=None,
        rows=np.arange(part.first, part.first + part.count),
        held=held,
    )
    return piece, whole, weight


def _laplacian(part):
    """(n, nodes) CSR, the rows of L (Eq. 17) that are held here."""
    connection, rows, columns, values = part.connection, [], [], []
    tails, heads = connection.edges.T
    for ends, others, links in ((heads, tails, connection.transports), (tails, heads, connection.transports.conj())):
        here = np.flatnonzero(part.holds(ends))
        weights = connection.weights[here]
        rows += 2 * [ends[here] - part.first]
        columns += [ends[here], others[here]]
        values += [weights, -weights * links[here]]
    places = np.concatenate(rows), np.concatenate(columns)
    return coo_matrix((np.concatenate(values), places), shape=(part.count, connection.node_count)).tocsr()


def _factor(part):
    """(e, nodes) CSR B with energy = |B x|^2 (Eq. 2), of the edges whose tail is held here: each is counted once."""
    connection = part.connection
    own = np.flatnonzero(part.holds(connection.edges[:, 0]))
    (tails, heads), scale = connection.edges[own].T, np.sqrt(connection.weights[own])
    values = np.concatenate([scale, -scale * connection.transports[own]])
    places = np.tile(np.arange(len(own)), 2), np.append(heads, tails)
    return coo_matrix((values, places), shape=(len(own), connection.node_count)).tocsr()
