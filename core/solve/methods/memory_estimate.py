# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimates of the memory that a solve takes, before it begins.

Lifted fields and candidates grow with the rows of the matrix, the hierarchy with its entries, and a factorization for
a proof with its largest dense blocks. The numbers were measured on large meshes; small ones take up to
twice as much (bench/memory.py, bench/README.md).
"""

from ...memory import check_memory
from ...piece import Piece
from ...problem import SynchronizationProblem

# Bytes for each row, and for each entry of the matrix, of complex numbers (True) and of real ones.
_SEARCH = {True: (3000, 100), False: (1500, 80)}
# Bytes of the matrix whose definiteness a factorization by dense blocks shows, for each entry.
_ELIMINATED = 80


def search_bytes(rows: int, entries: int, is_complex: bool) -> int:
    """Bytes of the relaxation and its rounding at their peak, without a proof, by the largest piece's matrix."""
    of_row, of_entry = _SEARCH[is_complex]
    return rows * of_row + entries * of_entry


def connection_bytes(nodes: int, edges: int, block: int, is_complex: bool) -> int:
    """The same for a connection with ``block`` rows a node."""
    return search_bytes(nodes * block, (nodes + 2 * edges) * block**2, is_complex)


def elimination_bytes(piece: Piece, entries: int) -> int:
    """Additional bytes of a factorization by dense blocks, with ``entries`` at a time, and of its matrix."""
    return entries * piece.matrix.dtype.itemsize + _ELIMINATED * piece.matrix.nnz


def check_problem_memory(problem: SynchronizationProblem) -> None:
    """Refuse a problem whose largest piece needs more memory than is available."""
    connection, sizes = problem.connection, problem.component_sizes
    share = sizes.max(initial=0) / max(sizes.sum(), 1)
    whole = connection_bytes(connection.node_count, len(connection.edges), problem.block, problem.is_complex)
    check_memory(share * whole, f"a solve of {connection.node_count:,} phases")
