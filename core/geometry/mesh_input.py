# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh as it was read from an object, on which fields are solved."""

from dataclasses import dataclass

import numpy as np

from . import TriangleMesh
from .polygons import Polygons


@dataclass(frozen=True)
class MeshInput:
    """A mesh as the core sees it.

    ``stretch`` is the (3, 3) scale that lengths were measured with. Where edges are cut, ``mesh`` and ``polygons``
    have them apart, ``uncut`` is the whole mesh, and ``source`` the (n,) vertex of it that each vertex was: its
    own vertices first, then their second sides.
    """

    mesh: TriangleMesh
    polygons: Polygons
    stretch: np.ndarray
    uncut: TriangleMesh
    source: np.ndarray

    def to_object(self, vectors):
        """Unit vectors in object space at the object's vertices, for (n, 3) vectors of the measured mesh."""
        return unstretched(vectors[: self.uncut.vertex_count], self.stretch)


def unstretched(vectors, stretch):
    """Unit vectors in object space for (k, 3) vectors of the measured space; zero stays zero."""
    turned = vectors @ np.linalg.inv(stretch).T
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.divide(turned, lengths, out=np.zeros_like(turned), where=lengths > 0)
