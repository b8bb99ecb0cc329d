# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh as it was read from an object, on which fields are solved."""

from dataclasses import dataclass

import numpy as np

from . import TriangleMesh
from .manifold_repair import Finding, find_seam_ends
from .polygons import Polygons


@dataclass(frozen=True)
class MeshInput:
    """A mesh as the core uses it.

    Vertices of the object have copies where edges are cut, and where its mesh had to be repaired.

    Attributes
    ----------
    mesh : cut open along the edges that are cut
    polygons : all faces; those that the repair left out have no triangles
    stretch : (3, 3) scale of the measured space
    uncut : the repaired mesh before cuts, whose vertices come first
    source : (n,) vertex of the object of each vertex: the object's own first, then their copies
    findings : differences between the repaired and the object's mesh
    own : (k,) vertex that represents each of the object's, which may be another at the same place; None for itself
    across : (s, 2) half-edges on the two sides along which a one-sided surface is open
    linked : those of ``across`` that are not cut
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
    def vertex_count(self) -> int:
        """Number of the object's vertices."""
        return int(self.source.max(initial=-1)) + 1

    @property
    def finding_counts(self) -> dict[str, int]:
        """Number of elements of each kind of finding, for reports."""
        return {finding.name: len(finding.elements) for finding in self.findings}

    @property
    def loose_vertices(self) -> np.ndarray:
        """Indices of the object's vertices without a face."""
        faces = np.bincount(self.source[self.polygons.corner_vertices], minlength=self.vertex_count)
        return np.flatnonzero(self.at_object(faces) == 0)

    @property
    def seam(self) -> np.ndarray | None:
        """(k, 2) vertices on the two sides of a one-sided surface's seam, without loops; None without a seam."""
        return None if self.linked is None or not len(self.linked) else find_seam_ends(self.mesh, self.linked)

    @property
    def euler_characteristic(self) -> int:
        """Euler characteristic of the surface with the two sides of a seam joined."""
        characteristic, seam = self.mesh.euler_characteristic, self.seam
        return characteristic if seam is None or self.linked is None else characteristic + len(self.linked) - len(seam)

    @property
    def is_closed(self) -> bool:
        """Whether the surface has no boundary except the two sides of a seam."""
        return len(self.mesh.boundary_edges) == (0 if self.linked is None else self.linked.size)

    @property
    def boundary_edges(self) -> np.ndarray:
        """Indices of the boundary edges of the uncut surface, without the two sides of a seam."""
        edges = self.uncut.boundary_edges
        return edges if self.across is None else np.setdiff1d(edges, self.uncut.triangle_edges.ravel()[self.across])

    def at_object(self, values: np.ndarray) -> np.ndarray:
        """Take values at the object's vertices, (k, ...), from values at those of the mesh, (n, ...)."""
        return values[: self.vertex_count] if self.own is None else values[self.own]

    def of_uncut(self, values: np.ndarray) -> np.ndarray:
        """Take values at the vertices of the mesh, (n, ...), from values at those of the uncut surface."""
        carried = np.zeros((self.mesh.vertex_count, *values.shape[1:]), values.dtype)
        carried[: len(values)] = values
        carried[self.mesh.triangles] = values[self.uncut.triangles]
        return carried

    def edges_of(self, pairs: np.ndarray) -> np.ndarray:
        """Find the edges of the uncut surface that (k, 2) edges of the object became, none or several each."""
        count = self.vertex_count
        pairs = pairs if self.own is None else self.own[pairs]
        known, asked = (np.sort(ends, axis=1) for ends in (self.source[self.uncut.edges], pairs))
        return np.flatnonzero(np.isin(known[:, 0] * count + known[:, 1], asked[:, 0] * count + asked[:, 1]))

    def to_object(self, vectors: np.ndarray) -> np.ndarray:
        """Transform (n, 3) vectors of the mesh to unit vectors in object space at the object's vertices."""
        return unstretched(self.at_object(vectors), self.stretch)


def unstretched(vectors: np.ndarray, stretch: np.ndarray) -> np.ndarray:
    """Transform (k, 3) vectors of the measured space to unit vectors in object space; zero stays zero."""
    turned = vectors @ np.linalg.inv(stretch).T
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.divide(turned, lengths, out=np.zeros_like(turned), where=lengths > 0)
