# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh as it was read from an object, on which fields are solved."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..errors import MeshError
from ..graphs import pair_keys
from ..unit_vectors import unit_vectors
from . import TriangleMesh
from .check import check_mesh, coarse_places
from .manifold_repair import Finding, find_seam_ends, finite_places, repair_mesh
from .polygons import Polygons
from .welding import welded_vertices


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
    linked : those of ``across`` that are not cut, (l, 2)
    """

    mesh: TriangleMesh
    polygons: Polygons
    stretch: np.ndarray
    uncut: TriangleMesh
    source: np.ndarray
    findings: tuple[Finding, ...] = ()
    own: np.ndarray | None = None
    across: np.ndarray = field(default_factory=lambda: np.empty((0, 2), int))
    linked: np.ndarray = field(default_factory=lambda: np.empty((0, 2), int))

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
        return find_seam_ends(self.mesh, self.linked) if len(self.linked) else None

    @property
    def euler_characteristic(self) -> int:
        """Euler characteristic of the surface with the two sides of a seam joined."""
        seam = self.seam
        return self.mesh.euler_characteristic + (0 if seam is None else len(self.linked) - len(seam))

    @property
    def is_closed(self) -> bool:
        """Whether the surface has no boundary except the two sides of a seam."""
        return len(self.mesh.boundary_edges) == self.linked.size

    @property
    def boundary_edges(self) -> np.ndarray:
        """Indices of the boundary edges of the uncut surface, without the two sides of a seam."""
        return np.setdiff1d(self.uncut.boundary_edges, self.uncut.triangle_edges.ravel()[self.across])

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
        return np.flatnonzero(np.isin(pair_keys(self.source[self.uncut.edges], count), pair_keys(pairs, count)))

    def to_object(self, vectors: np.ndarray) -> np.ndarray:
        """Transform (n, 3) vectors of the mesh to unit vectors in object space at the object's vertices."""
        return unstretched(self.at_object(vectors), self.stretch)


@dataclass(frozen=True)
class ObjectMesh:
    """The faces of an object as they were read.

    Attributes
    ----------
    name : of the object, for messages
    vertices : (n, 3) in the object's space
    polygons : all faces
    stretch : (3, 3) scale of the measured space
    """

    name: str
    vertices: np.ndarray
    polygons: Polygons
    stretch: np.ndarray

    @cached_property
    def places(self) -> np.ndarray:
        """(n, 3) vertices in the measured space; those that are not finite stay so."""
        with np.errstate(invalid="ignore"):
            return self.vertices @ self.stretch.T

    def surface(self, strict: bool = False, weld: bool = False) -> MeshInput:
        """The surface, repaired where it has to be unless ``strict``, with boundary vertices at the same place joined
        if asked.

        Raises MeshError naming the first element that cannot carry a field.
        """
        count = len(self.places)
        joined = welded_vertices(self.places, self.polygons.triangles) if weld else np.arange(count)
        moved = np.flatnonzero(joined != np.arange(count))
        welds = (Finding("joined_vertices", moved),) if len(moved) else ()
        polygons = replace(self.polygons, corner_vertices=joined[self.polygons.corner_vertices])
        mesh = TriangleMesh(self.places, polygons.triangles)
        try:
            check_mesh(mesh, polygons.triangle_faces)
        except MeshError:
            if strict or mesh.triangle_count == 0:
                raise
            found = repair_mesh(mesh, polygons)
            coarse = coarse_places(mesh.vertices, mesh.edges)
            if coarse and "flat_faces" in {finding.name for finding in found.findings}:
                raise MeshError(f"{self.name} has lost its shape: {coarse}") from None
            places = found.mesh, found.polygons, self.stretch, found.mesh, found.source
            return MeshInput(*places, welds + found.findings, found.own[joined], found.across, found.across)
        own = joined if len(moved) else None
        return MeshInput(mesh, polygons, self.stretch, mesh, np.arange(mesh.vertex_count), welds, own)

    def moved(self, base: MeshInput) -> MeshInput:
        """The surface of the same faces as a base whose vertices were at other places; errors as :meth:`surface`."""
        left_out = np.bincount(base.uncut.triangles.ravel(), minlength=len(base.source)) == 0
        places = np.where(left_out[:, None], finite_places(self.places)[base.source], self.places[base.source])
        mesh = TriangleMesh(places, base.uncut.triangles)
        check_mesh(mesh, base.polygons.triangle_faces)
        return replace(base, mesh=mesh, uncut=mesh, stretch=self.stretch)


def unstretched(vectors: np.ndarray, stretch: np.ndarray) -> np.ndarray:
    """Transform (k, 3) vectors of the measured space to unit vectors in object space; zero stays zero."""
    return unit_vectors(vectors @ np.linalg.inv(stretch).T)
