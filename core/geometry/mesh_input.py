# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh as it was read from an object, on which fields are solved."""

from dataclasses import dataclass

import numpy as np

from . import TriangleMesh
from .manifold_repair import Finding, seam_ends
from .polygons import Polygons


@dataclass(frozen=True)
class MeshInput:
    """A mesh as the core sees it.

    ``stretch`` is the (3, 3) scale that lengths were measured with. Where edges are cut, ``mesh`` and ``polygons``
    have them apart, and ``uncut`` is the whole surface, whose vertices come first. ``source`` is the (n,) vertex of
    the object that each vertex was: the object's own first, then their copies. There are copies where edges are cut,
    and where the object's mesh is no surface and ``uncut`` is its carrier; ``findings`` say where that differs from it,
    ``polygons`` have all faces, with the triangles of those alone that are part of it, and ``own``, where it is not
    None, is the vertex that stands for each of the object's: another one where two at one place count as one.
    ``across`` are the (s, 2) half-edges on the two sides along which a one-sided surface is open, None where there is
    none, and ``linked`` those of them that are not cut.
    """

    mesh: TriangleMesh
    polygons: Polygons
    stretch: np.ndarray
    uncut: TriangleMesh
    source: np.ndarray
    findings: tuple[Finding, ...] = ()
    own: np.ndarray | None = None
    across: np.ndarray | None = None
    linked: np.ndarray | None = None

    @property
    def vertex_count(self):
        """How many vertices the object has."""
        return int(self.source.max(initial=-1)) + 1

    @property
    def finding_counts(self):
        """How many elements each kind of finding has, as reports tell it."""
        return {finding.name: len(finding.elements) for finding in self.findings}

    @property
    def loose_vertices(self):
        """Indices of the object's vertices without a face."""
        faces = np.bincount(self.source[self.polygons.corner_vertices], minlength=self.vertex_count)
        return np.flatnonzero(self.at_object(faces) == 0)

    @property
    def has_copies(self):
        """Whether vertices of the object stand for several of the surface, which values at vertices cannot tell."""
        return len(self.source) > self.vertex_count

    @property
    def seam(self):
        """(k, 2) vertices of the mesh on the two sides of a one-sided surface's seam, no loop of them; None where there
        is none."""
        return None if self.linked is None or not len(self.linked) else seam_ends(self.mesh, self.linked)

    @property
    def euler_characteristic(self):
        """Of the surface, with the two sides of a seam as one."""
        characteristic, seam = self.mesh.euler_characteristic, self.seam
        return characteristic if seam is None or self.linked is None else characteristic + len(self.linked) - len(seam)

    @property
    def is_closed(self):
        """Whether the surface has no boundary, the two sides of a seam apart."""
        return len(self.mesh.boundary_edges) == (0 if self.linked is None else self.linked.size)

    @property
    def boundary_edges(self):
        """Indices of the boundary edges of the whole surface, the two sides of a seam left out."""
        edges = self.uncut.boundary_edges
        return edges if self.across is None else np.setdiff1d(edges, self.uncut.triangle_edges.ravel()[self.across])

    def at_object(self, values):
        """(k, ...) values at the object's vertices, for (n, ...) values at those of the mesh."""
        return values[: self.vertex_count] if self.own is None else values[self.own]

    def of_uncut(self, values):
        """(n, ...) values at the vertices of the mesh, for values at those of the whole surface."""
        carried = np.zeros((self.mesh.vertex_count, *values.shape[1:]), values.dtype)
        carried[: len(values)] = values
        carried[self.mesh.triangles] = values[self.uncut.triangles]
        return carried

    def edges_of(self, pairs):
        """Indices of the edges of the whole surface that (k, 2) edges of the object became, none or several each."""
        count = self.vertex_count
        pairs = pairs if self.own is None else self.own[pairs]
        known, asked = (np.sort(ends, axis=1) for ends in (self.source[self.uncut.edges], pairs))
        return np.flatnonzero(np.isin(known[:, 0] * count + known[:, 1], asked[:, 0] * count + asked[:, 1]))

    def to_object(self, vectors):
        """Unit vectors in object space at the object's vertices, for (n, 3) vectors of the measured mesh."""
        return unstretched(self.at_object(vectors), self.stretch)


def unstretched(vectors, stretch):
    """Unit vectors in object space for (k, 3) vectors of the measured space; zero stays zero."""
    turned = vectors @ np.linalg.inv(stretch).T
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.divide(turned, lengths, out=np.zeros_like(turned), where=lengths > 0)
