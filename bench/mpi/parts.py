# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of a connection on the circle that processes hold, and their matrices."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from synch_fields.bench.mpi.rows import SpreadReductions, SpreadRows, petsc_matrix
from synch_fields.core.connection import Connection
from synch_fields.core.piece import Piece


@dataclass(frozen=True)
class Part:
    """The part that a process holds of a connected connection on the circle without flips: a range of its nodes.

    Attributes
    ----------
    first : number of the first node held here; ranges are in the order of the processes
    connection : of all nodes, but only edges with an end held here, so that both processes have an edge between them
    mass : (n,) positive, of the nodes held here
    """

    first: int
    connection: Connection
    mass: np.ndarray

    @property
    def count(self) -> int:
        """Number of nodes held here."""
        return len(self.mass)

    def holds(self, nodes: np.ndarray) -> np.ndarray:
        """Tell which nodes are held here, (k,) bool."""
        return (nodes >= self.first) & (nodes < self.first + self.count)


def parts_of(connection: Connection, mass: np.ndarray, processes: int) -> tuple[list[Part], np.ndarray]:
    """Split a connection on the circle without flips, with (n,) masses, into a :class:`Part` for each process.

    Also returns the nodes in the order of the parts, which keeps neighbours close, so that few edges join processes.
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


def piece_of(part: Part, comm: MPI.Comm) -> tuple[Piece, PETSc.Mat, float]:
    """Build the piece of all processes, scaled to a mean diagonal and a mean mass of 1, from this process's part.

    Returns
    -------
    piece : with the rows of this process
    whole : the matrix of all processes
    weight : divisor of the energies
    """
    reductions, count = SpreadReductions(comm), part.connection.node_count
    laplacian, factor = _laplacian(part), _factor(part)
    weight = float(reductions.sum(laplacian.diagonal(part.first).real.sum())) / count
    whole = petsc_matrix(laplacian / weight, comm, part.count)
    piece = Piece(
        SpreadRows.of(whole, complex),
        SpreadRows.of(petsc_matrix(factor / np.sqrt(weight), comm, part.count), complex),
        part.mass * (count / reductions.sum(part.mass.sum())),
        block=1,
        is_complex=True,
        ground=None,
        rows=np.arange(part.first, part.first + part.count),
        reductions=reductions,
    )
    return piece, whole, weight


def _laplacian(part: Part) -> csr_matrix:
    """Build the (n, nodes) rows of L (Eq. 17) that are held here."""
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


def _factor(part: Part) -> csr_matrix:
    """Build the (e, nodes) rows of B, with energy = |B x|^2 (Eq. 2), for edges whose tail is held here."""
    connection = part.connection
    own = np.flatnonzero(part.holds(connection.edges[:, 0]))
    (tails, heads), scale = connection.edges[own].T, np.sqrt(connection.weights[own])
    values = np.concatenate([scale, -scale * connection.transports[own]])
    places = np.tile(np.arange(len(own)), 2), np.append(heads, tails)
    return coo_matrix((values, places), shape=(len(own), connection.node_count)).tocsr()
