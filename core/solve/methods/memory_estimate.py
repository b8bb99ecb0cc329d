# SPDX-License-Identifier: GPL-3.0-or-later
"""How much memory a solve takes, from what is known before it begins.

Lifted fields and candidates grow with the rows of the matrix, the hierarchy with its entries, and a factorization that
proves with the rows and the width of their front. The numbers are those of large meshes; smaller ones take up to twice
as much (bench/memory.py, bench/README.md).
"""

# Bytes for each row, and for each entry of the matrix, of complex numbers (True) and of real ones.
_SEARCH = {True: (3000, 100), False: (1500, 80)}
# Bytes of a factorization for each row, and row of the widest front.
_PROOF = {True: 5, False: 3}


def search_bytes(rows, entries, is_complex):
    """Bytes that the relaxation and its rounding take at their peak, without a proof.

    Parameters
    ----------
    rows, entries : of the matrix of the largest piece
    is_complex : whether its numbers are complex
    """
    of_row, of_entry = _SEARCH[is_complex]
    return rows * of_row + entries * of_entry


def connection_bytes(nodes, edges, block, is_complex):
    """The same for a connection of so many nodes and edges, with so many rows for each node."""
    return search_bytes(nodes * block, (nodes + 2 * edges) * block**2, is_complex)


def proof_bytes(rows, width, is_complex):
    """Bytes that a factorization of so many rows, with so many in its widest front, takes besides."""
    return _PROOF[is_complex] * rows * width
