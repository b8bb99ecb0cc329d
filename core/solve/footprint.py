# SPDX-License-Identifier: GPL-3.0-or-later
"""How much memory a solve takes, from what is known before it begins.

Measured by bench/memory.py, whose figures stand in bench/README.md: lifted fields and candidates grow with the rows of
the matrix, the hierarchy with its entries, and a factorization that proves with the rows and the width of their front.
"""

# Bytes for each row, and for each entry of the matrix, of complex numbers (True) and of real ones.
SEARCH = {True: (2400, 160), False: (1200, 80)}
# Bytes of the factorization for each row and root of the width of its front.
PROOF = {True: 400, False: 200}


def search_bytes(rows, entries, is_complex):
    """Bytes that the relaxation and its rounding take at their peak, without a proof.

    Parameters
    ----------
    rows, entries : of the matrix of the largest piece
    is_complex : whether its numbers are complex
    """
    of_row, of_entry = SEARCH[is_complex]
    return rows * of_row + entries * of_entry


def proof_bytes(rows, width, is_complex):
    """Bytes that a factorization with so many rows, and at most so many in a front, adds to the search."""
    return PROOF[is_complex] * rows * width**0.5


def connection_bytes(nodes, edges, block, is_complex):
    """Bytes of the search for a connection of so many nodes and edges."""
    return search_bytes(nodes * block, (nodes + 2 * edges) * block**2, is_complex)
