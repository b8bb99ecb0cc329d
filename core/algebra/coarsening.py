# SPDX-License-Identifier: GPL-3.0-or-later
"""Aggregates of a connection Laplacian, and the Laplacian of turns.

A connection Laplacian has no constant near its null space, but it has one locally: a field that agrees with the
transports of the few edges around a node. An aggregate carries the phase of its root outward along
strong edges, so that a smooth field has a smooth coarse one, of one unit vector a node again, in
whatever coordinates it was given.
"""

import numpy as np
from scipy.sparse import bsr_matrix, coo_matrix, csr_matrix

from ..connection import compose

# An edge is strong when its weight is at least this share of the geometric mean of the two diagonals, or, in graphs
# of many neighbours, this share of the largest beside it at either end. Half the first takes 11 % more products of the
# relaxation, twice of it 7 % fewer, but on one of twelve 67 % more (measured as in `staircase`).
STRENGTH, STRONGEST = 0.05, 0.5
# A hub (ground, leader of a merged group) is a row with this many times the entries of the mean one.
HUB = 10


def hubs(matrix):
    """(rows,) bool: rows of a CSR or BSR matrix with very many entries."""
    lengths = np.diff(matrix.indptr)
    return lengths > HUB * lengths.mean()


class StrongGraph:
    """The strong edges of a block matrix, as a graph on its nodes with one transport an edge.

    Attributes
    ----------
    tails, heads : (e,) nodes, every edge once in each direction, sorted by tail
    weights : (e,) sizes of the blocks
    transports : (e,) complex or (e, d, d) blocks of -matrix[tail, head]: what carries a value from
        head to tail, times the weight
    """

    def __init__(self, matrix, block, ground=None):
        blocks = matrix.tocsr() if block == 1 else bsr_matrix(matrix, blocksize=(block, block))
        count = matrix.shape[0] // block
        tails = np.repeat(np.arange(count), np.diff(blocks.indptr))
        heads = blocks.indices
        sizes = _sizes(blocks.data)
        on_diagonal = tails == heads
        diagonal = np.zeros(count, sizes.dtype)
        diagonal[tails[on_diagonal]] = sizes[on_diagonal]
        largest = _largest_of_rows(np.where(on_diagonal, 0, sizes), blocks.indptr, 0)
        # Hubs have no strong edges of their own: they would draw everything around them into one aggregate.
        largest[hubs(blocks)] = np.inf
        strong = sizes >= STRENGTH * np.sqrt(diagonal[tails] * diagonal[heads])
        strong |= sizes >= STRONGEST * np.maximum(largest[tails], largest[heads])
        strong &= ~on_diagonal
        if ground is not None:  # one hub, whose block may be singular
            strong &= (tails != ground) & (heads != ground)
        self.count = count
        self.tails, self.heads = tails[strong], heads[strong]
        self.weights, self.transports = sizes[strong], -blocks.data[strong]
        self._starts = np.concatenate([[0], np.cumsum(np.bincount(self.tails, minlength=count))])

    def largest_beside(self, values):
        """(n,) largest value of each node and its neighbours."""
        return np.maximum(values, _largest_of_rows(values[self.heads], self._starts, values.min()))

    def independent_nodes(self, distance, random):
        """(n,) bool: a maximal set of nodes that are more than ``distance`` edges apart, drawn at random (Luby)."""
        waiting = random.permutation(self.count).astype(np.int32) + 1
        chosen = np.zeros(self.count, bool)
        while (waiting > 0).any():
            reach = waiting
            for _ in range(distance):
                reach = self.largest_beside(reach)
            winners = (waiting > 0) & (reach == waiting)
            chosen |= winners
            near = winners.astype(np.int8)
            for _ in range(distance):
                near = self.largest_beside(near)
            waiting = np.where(near > 0, 0, waiting)
        return chosen

    def strongest_labelled(self, label):
        """For every node without a label that has a neighbour with one: the edge to the strongest such."""
        usable = np.flatnonzero((label[self.heads] >= 0) & (label[self.tails] < 0))
        usable = usable[np.lexsort((self.weights[usable], self.tails[usable]))]
        return usable[np.diff(self.tails[usable], append=-1) != 0]


def _largest_of_rows(values, starts, otherwise):
    """Largest of the values of each row, which begin at ``starts``; a number for empty ones."""
    result = np.full(len(starts) - 1, otherwise, values.dtype)
    filled = np.flatnonzero(np.diff(starts))
    if len(filled):
        result[filled] = np.maximum.reduceat(values, starts[filled])
    return result


def aggregates(matrix, block, ground, random):
    """Tentative prolongation of smoothed aggregation: every node follows a root at most two edges away.

    Parameters
    ----------
    matrix : (N, N) CSR, Hermitian
    block : rows per node
    ground : node that stays alone, or None
    random : numpy Generator

    Returns
    -------
    prolongation : (N, coarse * block) CSR with one unit block a node
    coarse_ground : the ground's coarse node, or None
    """
    graph = StrongGraph(matrix, block, ground)
    roots = graph.independent_nodes(2, random)
    label = np.full(graph.count, -1)
    label[roots] = np.arange(roots.sum())
    units = _identities(graph.count, matrix, block)
    while (label < 0).any():
        edges = graph.strongest_labelled(label)
        tails, heads = graph.tails[edges], graph.heads[edges]
        units[tails] = compose(_nearest_unit(graph.transports[edges]), units[heads])
        label[tails] = label[heads]
    starts = np.arange(graph.count + 1)
    return _sparse(units, label, starts, int(roots.sum())), None if ground is None else int(label[ground])


def scalar_aggregates(tentative, block, turns):
    """Aggregates as those of fields, for one number a node.

    Parameters
    ----------
    tentative : (N, coarse * block) CSR, of :func:`aggregates`
    block : rows per node
    turns : whether the numbers are turns of 2x2 blocks, whose sign a reflection changes

    Returns
    -------
    (n, coarse) CSR with one entry a node, 1 or -1
    """
    blocks = tentative if block == 1 else bsr_matrix(tentative, blocksize=(block, block))
    values = np.sign(np.linalg.det(blocks.data)) if turns else np.ones(len(blocks.indices))
    shape = (tentative.shape[0] // block, tentative.shape[1] // block)
    return csr_matrix((values.astype(blocks.data.real.dtype), blocks.indices, blocks.indptr), shape=shape)


def graph_laplacian(matrix, block):
    """Real Laplacian (n, n) of the graph, weighted by the sizes of the blocks."""
    tails, heads, blocks = _links(matrix, block)
    sizes = _sizes(blocks)
    return _laplacian(tails, heads, sizes, sizes, matrix.shape[0] // block)


def turning_laplacian(matrix, block, ground=None):
    """Real Laplacian (n, n) of the turns that a field on the circle can make: the metric of its descent.

    A small turn of one end of an edge asks for the same turn of the other, or for the opposite one across a
    flip. With all edges in agreement this is the Hessian of the energy in angles. A ground in real
    coordinates does not turn.
    """
    if block == 1:
        return graph_laplacian(matrix, block)
    tails, heads, blocks = _links(matrix, block)
    determinants = np.linalg.det(blocks)
    links = np.sign(determinants) * np.sqrt(np.abs(determinants))
    sizes = np.where(heads == ground, np.sqrt(2) * _sizes(blocks), np.abs(links))
    return _laplacian(tails, heads, links, sizes, matrix.shape[0] // block)


def _links(matrix, block):
    """Nodes and blocks beside the diagonal."""
    blocks = matrix.tocsr() if block == 1 else bsr_matrix(matrix, blocksize=(block, block))
    tails = np.repeat(np.arange(len(blocks.indptr) - 1), np.diff(blocks.indptr))
    apart = tails != blocks.indices
    return tails[apart], blocks.indices[apart], blocks.data[apart]


def _sizes(blocks):
    """Sizes of numbers; of blocks, the one that makes a multiple of an orthogonal matrix that multiple."""
    return np.abs(blocks) if blocks.ndim == 1 else np.sqrt((blocks**2).sum(axis=(1, 2)) / blocks.shape[1])


def _laplacian(tails, heads, links, sizes, count):
    diagonal = np.bincount(tails, sizes, count)
    diagonal[diagonal == 0] = diagonal.max(initial=1)
    nodes = np.arange(count)
    rows, columns = np.concatenate([tails, nodes]), np.concatenate([heads, nodes])
    return coo_matrix((np.concatenate([-links, diagonal]), (rows, columns)), shape=(count, count)).tocsr()


def _identities(count, matrix, block):
    """Unit numbers, or unit blocks, in the matrix's dtype."""
    if block == 1:
        return np.ones(count, matrix.dtype)
    return np.tile(np.eye(block, dtype=matrix.dtype), (count, 1, 1))


def _nearest_unit(blocks):
    """The unit number or orthogonal matrix nearest to each block."""
    if blocks.ndim == 1:
        return blocks / np.abs(blocks)
    left, _, right = np.linalg.svd(blocks)
    return left @ right


def _sparse(blocks, columns, starts, coarse_count):
    """CSR from blocks sorted by row."""
    count = len(starts) - 1
    if blocks.ndim == 1:
        return csr_matrix((blocks, columns, starts), shape=(count, coarse_count))
    block = blocks.shape[1]
    return bsr_matrix((blocks, columns, starts), shape=(count * block, coarse_count * block)).tocsr()
