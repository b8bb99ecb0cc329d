# SPDX-License-Identifier: GPL-3.0-or-later
"""Products of spheres, on which lifted phases and sets of candidates live.

An array has one group of ``block`` rows per node. *Lifted* (Eq. 24): the whole group, all columns,
is one unit vector. *Candidates*: each column is a field of its own with one unit vector per node.
Complex rows count as pairs of real coordinates. Node-wise results have the shape (nodes, k) with
k = 1 for a lifted field and k = number of columns for candidates, and spread over rows by
:meth:`Spheres.spread`.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Spheres:
    """Row products, normalization and projection for one layout; ``block`` rows per node."""

    block: int
    lifted: bool

    def node_products(self, first, second):
        """(nodes, k) real inner products per node."""
        nodes = first.shape[0] // self.block
        if self.lifted:
            # One einsum over contiguous floats: reductions over a short last axis are slow in NumPy.
            first, second = (np.ascontiguousarray(a).view(np.float64).reshape(nodes, -1) for a in (first, second))
            return np.einsum("ij,ij->i", first, second)[:, None]
        products = first.real * second.real
        if np.iscomplexobj(first):
            products += first.imag * second.imag
        if self.block == 1:
            return products
        return products.reshape(nodes, self.block, -1).sum(axis=1)

    def spread(self, node_values):
        """Node values (nodes, k) as factors for the rows."""
        return node_values if self.block == 1 else np.repeat(node_values, self.block, axis=0)

    def inner(self, first, second):
        """(k,) real inner products of whole fields."""
        return self.node_products(first, second).sum(axis=0)

    def normalize(self, array):
        """Nearest point: every unit vector scaled to length one; zero vectors stay zero."""
        lengths = np.sqrt(self.node_products(array, array))
        return array * self.spread(1 / np.where(lengths > 0, lengths, 1))

    def project(self, point, vector):
        """Part of ``vector`` that is tangent at ``point``."""
        return vector - point * self.spread(self.node_products(point, vector))


def random_columns(piece, columns, random):
    """(N, columns) Gaussian start for a piece; the ground's unused rows are zero."""
    shape = (piece.matrix.shape[0], columns)
    start = random.standard_normal(shape)
    if piece.is_complex:
        start = start + 1j * random.standard_normal(shape)
    start[piece.unused_rows] = 0
    return start
