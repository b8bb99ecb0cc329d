# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimates of the memory that a solve takes, before it begins.

Lifted fields and candidates grow with the rows of the matrix, the hierarchy with its entries, and a factorization for
a proof with the rows and the width of its front. The numbers were measured on large meshes; small ones take up to
twice as much (bench/memory.py, bench/README.md).
"""

import numpy as np

from ...memory import check_memory
from ...piece import Piece
from ...problem import SynchronizationProblem

# Bytes for each row, and for each entry of the matrix, of complex numbers (True) and of real ones.
_SEARCH = {True: (3000, 100), False: (1500, 80)}
# Bytes of a factorization for each row, and row of the widest front: on surfaces, and in solids, where nearly whole
# fronts fill in (measured there: 26 to 57, complex).
_PROOF = {True: 5, False: 3}
_SOLID_PROOF = {True: 45, False: 27}
# Bytes of the matrix whose definiteness a factorization by dense blocks shows, for each entry.
_ELIMINATED = 80
# In solids, fronts have more nodes than this multiple of the root of all nodes (on surfaces at most 4.04 was measured),
# or rows have more blocks: 7 on surfaces, 11 to 15 between tetrahedra.
SURFACE_FRONT, SURFACE_ROW = 4.1, 10.0


def search_bytes(rows: int, entries: int, is_complex: bool) -> int:
    """Bytes of the relaxation and its rounding at their peak, without a proof, by the largest piece's matrix."""
    of_row, of_entry = _SEARCH[is_complex]
    return rows * of_row + entries * of_entry


def connection_bytes(nodes: int, edges: int, block: int, is_complex: bool) -> int:
    """The same for a connection with ``block`` rows a node."""
    return search_bytes(nodes * block, (nodes + 2 * edges) * block**2, is_complex)


def proof_bytes(piece: Piece, width: int) -> int:
    """Additional bytes of a factorization by columns whose widest front has ``width`` rows."""
    bytes_of_entry = (_SOLID_PROOF if is_solid(piece, width) else _PROOF)[piece.is_complex]
    return int(bytes_of_entry * piece.matrix.shape[0] * width)


def elimination_bytes(piece: Piece, entries: int) -> int:
    """Additional bytes of a factorization by dense blocks, with ``entries`` at a time, and of its matrix."""
    return entries * piece.matrix.dtype.itemsize + _ELIMINATED * piece.matrix.nnz


def is_solid(piece: Piece, width: int) -> bool:
    """Whether fronts, the widest with ``width`` rows, or rows of a piece have more nodes than on a surface."""
    nodes, block = piece.node_count, piece.block
    return is_solid_front(nodes, width / block) or piece.matrix.nnz > SURFACE_ROW * nodes * block**2


def is_solid_front(nodes: float, width: float) -> bool:
    """Whether the widest front of a mesh of ``nodes`` nodes is wider than on a surface."""
    return bool(width > SURFACE_FRONT * np.sqrt(nodes))


def check_problem_memory(problem: SynchronizationProblem) -> None:
    """Refuse a problem whose largest piece needs more memory than is available."""
    connection, sizes = problem.connection, problem.component_sizes
    share = sizes.max(initial=0) / max(sizes.sum(), 1)
    whole = connection_bytes(connection.node_count, len(connection.edges), problem.block, problem.is_complex)
    check_memory(share * whole, f"a solve of {connection.node_count:,} phases")
