# SPDX-License-Identifier: GPL-3.0-or-later
"""Aggregates of a connection Laplacian, and the Laplacian of turns.

A connection Laplacian has no near null vector globally, but it has one locally: a field that agrees with the transports
of the few edges around a node. An aggregate carries the phase of its root outward along strong edges, so that a smooth
field has a smooth coarse field, again with one unit vector per node, in any coordinates.
"""

import numpy as np
from scipy.sparse import bsr_matrix, coo_matrix, csr_matrix

from ..connection import compose
from .blocks import block_matrix, scale_blocks

# An edge is strong if its weight is at least the first share of the geometric mean of the two diagonals or, in graphs
# with many neighbours, the second share of the largest weight at either end. Half the first value takes 11 % more
# products of the relaxation, twice the value 7 % fewer, but on one of twelve 67 % more (measured as in `staircase`).
STRENGTH, STRONGEST = 0.05, 0.5
# Blocks of a prolongation are small below this share of the largest in their row.
TRUNCATED = 0.2
# A hub (ground, leader of a merged group) is a row with this many times the mean number of entries.
HUB = 10


def hubs(matrix: csr_matrix) -> np.ndarray:
    """Find the rows of a CSR or BSR matrix with very many entries, (rows,) bool."""
    lengths = np.diff(matrix.indptr)
    return lengths > HUB * lengths.mean()


class StrongGraph:
    """The strong edges of a block matrix, as a graph on its nodes with one transport per edge.

    Attributes
    ----------
    tails, heads : (e,) nodes, every edge once in each direction, sorted by tail
    weights : (e,) sizes of the blocks
    transports : (e,) complex or (e, d, d) blocks of -matrix[tail, head]: transports from head to tail times weights
    """

    def __init__(self, matrix: csr_matrix, block: int, ground: int | None = None) -> None:
        blocks = matrix.tocsr() if block == 1 else bsr_matrix(matrix, blocksize=(block, block))
        count = matrix.shape[0] // block
        tails = np.repeat(np.arange(count), np.diff(blocks.indptr))
        heads = blocks.indices
        sizes = _sizes(blocks.data)
        on_diagonal = tails == heads
        diagonal = np.zeros(count, sizes.dtype)
        diagonal[tails[on_diagonal]] = sizes[on_diagonal]
        largest = _largest_of_rows(np.where(on_diagonal, 0, sizes), blocks.indptr, 0)
        # Hubs have no strong edges: they would join all their neighbours into one aggregate.
        largest[hubs(blocks)] = np.inf
        strong = sizes >= STRENGTH * np.sqrt(diagonal[tails] * diagonal[heads])
        strong |= sizes >= STRONGEST * np.maximum(largest[tails], largest[heads])
        strong &= ~on_diagonal
        if ground is not None:  # a hub whose block may be singular
            strong &= (tails != ground) & (heads != ground)
        self.count = count
        self.tails, self.heads = tails[strong], heads[strong]
        self.weights, self.transports = sizes[strong], -blocks.data[strong]
        self._starts = np.concatenate([[0], np.cumsum(np.bincount(self.tails, minlength=count))])

    def largest_beside(self, values: np.ndarray) -> np.ndarray:
        """Compute the (n,) largest value of each node and its neighbours."""
        return np.maximum(values, _largest_of_rows(values[self.heads], self._starts, values.min()))

    def independent_nodes(self, distance: int, random: np.random.Generator) -> np.ndarray:
        """Draw a maximal set of nodes more than ``distance`` edges apart (Luby 1986), (n,) bool."""
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

    def strongest_labelled(self, label: np.ndarray) -> np.ndarray:
        """Find the strongest edges from nodes without a label to labelled neighbours, one per node."""
        usable = np.flatnonzero((label[self.heads] >= 0) & (label[self.tails] < 0))
        usable = usable[np.lexsort((self.weights[usable], self.tails[usable]))]
        return usable[np.diff(self.tails[usable], append=-1) != 0]


def _largest_of_rows(values: np.ndarray, starts: np.ndarray, otherwise: float) -> np.ndarray:
    """Compute the largest value of each row, with (rows + 1,) starts; ``otherwise`` for empty rows."""
    result = np.full(len(starts) - 1, otherwise, values.dtype)
    filled = np.flatnonzero(np.diff(starts))
    if len(filled):
        result[filled] = np.maximum.reduceat(values, starts[filled])
    return result


def aggregates(
    matrix: csr_matrix, block: int, ground: int | None, random: np.random.Generator
) -> tuple[csr_matrix, int | None]:
    """Build the tentative prolongation of smoothed aggregation: every node follows a root at most two edges away.

    Parameters
    ----------
    matrix : (N, N), Hermitian
    block : rows per node
    ground : node that stays alone

    Returns
    -------
    prolongation : (N, coarse * block) with one unit block per node
    coarse_ground : the ground's coarse node
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


def truncated(prolongation: csr_matrix, tentative: csr_matrix, block: int) -> csr_matrix:
    """Leave out the small blocks in each row of a prolongation, and scale the others so that their sizes add up to the
    same.

    Blocks of the tentative prolongation, which has the same (N, coarse) shape, are kept, so that no column is empty.
    """
    blocks, own = (
        (part if block == 1 else bsr_matrix(part, blocksize=(block, block))) for part in (prolongation, tentative)
    )
    sizes, count = _sizes(blocks.data), len(own.indices)
    rows = np.repeat(np.arange(count), np.diff(blocks.indptr))
    kept = sizes >= TRUNCATED * _largest_of_rows(sizes, blocks.indptr, 0)[rows]
    kept |= blocks.indices == own.indices[rows]
    factors = np.bincount(rows, sizes, count) / np.bincount(rows[kept], sizes[kept], count)
    values = scale_blocks(blocks.data[kept], factors[rows[kept]].astype(sizes.dtype))
    return block_matrix(rows[kept], blocks.indices[kept], values, (count, tentative.shape[1] // block))


def scalar_aggregates(tentative: csr_matrix, block: int, turns: bool) -> csr_matrix:
    """Convert aggregates of fields, by :func:`aggregates`, to aggregates of one number per node.

    Returns an (n, coarse) matrix with one entry per node: 1, or -1 where the numbers are turns of 2 x 2 blocks, whose
    sign a reflection changes.
    """
    blocks = tentative if block == 1 else bsr_matrix(tentative, blocksize=(block, block))
    values = np.sign(np.linalg.det(blocks.data)) if turns else np.ones(len(blocks.indices))
    shape = (tentative.shape[0] // block, tentative.shape[1] // block)
    return csr_matrix((values.astype(blocks.data.real.dtype), blocks.indices, blocks.indptr), shape=shape)


def graph_laplacian(matrix: csr_matrix, block: int) -> csr_matrix:
    """Build the real (n, n) Laplacian of the graph, weighted by the sizes of the blocks."""
    tails, heads, blocks = _links(matrix, block)
    sizes = _sizes(blocks)
    return _laplacian(tails, heads, sizes, sizes, matrix.shape[0] // block)


def turning_laplacian(matrix: csr_matrix, block: int, ground: int | None = None) -> csr_matrix:
    """Build the real (n, n) Laplacian of turns of a field on the circle: the metric of its descent.

    A small turn of one end of an edge asks for the same turn of the other, or for the opposite one across a flip. If
    all edges agree, this is the Hessian of the energy in angles. A ground in real coordinates does not turn.
    """
    if block == 1:
        return graph_laplacian(matrix, block)
    tails, heads, blocks = _links(matrix, block)
    determinants = np.linalg.det(blocks)
    links = np.sign(determinants) * np.sqrt(np.abs(determinants))
    sizes = np.where(heads == ground, np.sqrt(2) * _sizes(blocks), np.abs(links))
    return _laplacian(tails, heads, links, sizes, matrix.shape[0] // block)


def _links(matrix: csr_matrix, block: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """List the nodes and blocks beside the diagonal."""
    blocks = matrix.tocsr() if block == 1 else bsr_matrix(matrix, blocksize=(block, block))
    tails = np.repeat(np.arange(len(blocks.indptr) - 1), np.diff(blocks.indptr))
    apart = tails != blocks.indices
    return tails[apart], blocks.indices[apart], blocks.data[apart]


def _sizes(blocks: np.ndarray) -> np.ndarray:
    """Compute sizes of numbers, or of blocks: c for c times an orthogonal matrix."""
    return np.abs(blocks) if blocks.ndim == 1 else np.sqrt((blocks**2).sum(axis=(1, 2)) / blocks.shape[1])


def _laplacian(tails: np.ndarray, heads: np.ndarray, links: np.ndarray, sizes: np.ndarray, count: int) -> csr_matrix:
    diagonal = np.bincount(tails, sizes, count)
    diagonal[diagonal == 0] = diagonal.max(initial=1)
    nodes = np.arange(count)
    rows, columns = np.concatenate([tails, nodes]), np.concatenate([heads, nodes])
    return coo_matrix((np.concatenate([-links, diagonal]), (rows, columns)), shape=(count, count)).tocsr()


def _identities(count: int, matrix: csr_matrix, block: int) -> np.ndarray:
    """Build unit numbers, or unit blocks, in the matrix's dtype."""
    if block == 1:
        return np.ones(count, matrix.dtype)
    return np.tile(np.eye(block, dtype=matrix.dtype), (count, 1, 1))


def _nearest_unit(blocks: np.ndarray) -> np.ndarray:
    """Find the unit number or orthogonal matrix nearest to each block."""
    if blocks.ndim == 1:
        return blocks / np.abs(blocks)
    left, _, right = np.linalg.svd(blocks)
    return left @ right


def _sparse(blocks: np.ndarray, columns: np.ndarray, starts: np.ndarray, coarse_count: int) -> csr_matrix:
    """Build a CSR matrix from blocks sorted by row."""
    count = len(starts) - 1
    if blocks.ndim == 1:
        return csr_matrix((blocks, columns, starts), shape=(count, coarse_count))
    block = blocks.shape[1]
    return bsr_matrix((blocks, columns, starts), shape=(count * block, coarse_count * block)).tocsr()
