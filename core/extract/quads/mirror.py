# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirror-symmetric quad meshes: traced and finished on one side of the mirror planes, and reflected.

The planes lead along edges of the surface, which become the boundary of that side, with vertices of the quad mesh on
it. So the halves fit.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ...fields.constraints.rows import Row
from ...geometry import TriangleMesh
from ...geometry.barycentric import barycentric
from ...geometry.mirror import are_divided_by_edges, sides_of_planes
from ...graphs import components
from ...interpolate import EdgePhases
from .finishing import check_quads, finish_quads, smooth_faces
from .measure.quality import worst_deviations
from .repair.all_quads import with_vertices
from .repair.bad_corners import BAD
from .repair.reconnections import join_around
from .smooth.worst_corners import BAD as MOVING
from .trace.quad_mesh import QuadMesh, quad_mesh

# Vertices that are nearer than this to a mirror image, in mean edge lengths, have one.
_SAME = 0.01
# A vertex of the quad mesh with a barycentric coordinate below this lies on the edge; one at the rim of the quads that
# is nearer than this to a plane, in mean edge lengths, is put onto it.
_ON_EDGE, _BESIDE = 1e-3, 0.3
# Other vertices stay at least this far from a plane, in mean edge lengths, and so from their mirror images.
_APART = 0.05


@dataclass(frozen=True)
class MirrorSide:
    """The part of a surface on the positive sides of mirror planes through the origin.

    Attributes
    ----------
    whole : the surface, its own mirror image
    units : (k, 3) unit normals of the planes
    mesh : the part
    vertices, triangles : (n,) and (m,) indices, ascending, of the part's vertices and triangles in the whole surface
    """

    whole: TriangleMesh
    units: np.ndarray
    mesh: TriangleMesh
    vertices: np.ndarray
    triangles: np.ndarray

    @classmethod
    def of(cls, mesh: TriangleMesh, units: np.ndarray) -> "MirrorSide | None":
        """The part of a symmetric mesh for (k, 3) unit normals; None without planes, or where one crosses triangles."""
        if len(units) == 0 or not are_divided_by_edges(mesh, units):
            return None
        sides = sides_of_planes(mesh, units)
        triangles = np.flatnonzero((sides[mesh.triangles] >= 0).all(axis=(1, 2)))
        vertices, corners = np.unique(mesh.triangles[triangles], return_inverse=True)
        # Vertices on a plane are put exactly onto it.
        places = mesh.vertices[vertices]
        places = places - np.where(sides[vertices] == 0, places @ units.T, 0) @ units
        return cls(mesh, units, TriangleMesh(places, corners.reshape(-1, 3)), vertices, triangles)

    @cached_property
    def _on_planes(self) -> np.ndarray:
        """(n, k) bool: vertices of the part on each plane."""
        return sides_of_planes(self.whole, self.units)[self.vertices] == 0

    def _phases(self, edge_phases: EdgePhases) -> EdgePhases:
        """The phases of the whole surface on the part."""
        edges = self.whole.edges_between(*self.vertices[self.mesh.edges].T)
        arguments, changes = edge_phases.arguments[self.vertices], edge_phases.changes[edges]
        return EdgePhases(self.mesh, arguments, changes, edge_phases.matchings[edges])

    def _row(self, row: Row) -> Row:
        """What a row of the whole surface holds of the part."""
        numbers = np.full(self.whole.vertex_count, -1)
        numbers[self.vertices] = np.arange(len(self.vertices))
        line = row.line
        here = numbers[line.vertices] >= 0
        links = numbers[line.links]
        stations = {name: getattr(line, name)[here] for name in ("angles", "offsets", "lengths")}
        own = replace(line, vertices=numbers[line.vertices[here]], links=links[(links >= 0).all(axis=1)], **stations)
        value = row.value if np.ndim(row.value) == 0 else np.asarray(row.value)[numbers[line.nodes] >= 0]
        return replace(row, line=own, value=value)

    def trace(self, edge_phases: EdgePhases) -> QuadMesh:
        """The quad mesh of a pattern on the part.

        An edge between two vertices on a plane would coincide with its reflection: it gets a vertex in its middle, on
        the surface beside the plane.
        """
        quads = quad_mesh(self._phases(edge_phases))
        edges, counts = quads.edges
        on_planes = self._vertices_on_planes(quads)[edges].all(axis=1)
        crosses = (counts == 2) & on_planes.any(axis=1)
        chords, new = edges[crosses], len(quads.vertices) + np.arange(np.count_nonzero(crosses))
        away = on_planes[crosses] @ self.units * quads.edge_lengths[crosses, None] / 2
        normals, ends = self.mesh.face_normals[quads.triangles[chords]].sum(axis=1), quads.vertices[chords]
        quads = with_vertices(quads, self.mesh, ends.mean(axis=1) + away, normals, ends)
        halves = np.sort(quads.half_edges, axis=1) @ [len(quads.vertices), 1]
        names = chords @ [len(quads.vertices), 1]  # ascending, as edges are
        at = np.flatnonzero(np.isin(halves, names))
        added = new[np.searchsorted(names, halves[at])]
        sizes = quads.sizes + np.bincount(quads.corner_faces[at], minlength=len(quads.sizes))
        return replace(quads, corner_vertices=np.insert(quads.corner_vertices, at + 1, added), sizes=sizes)

    def finish(
        self,
        quads: QuadMesh,
        rows: Sequence[Row],
        rounds: int,
        only_quads: bool,
        closes_tunnels: bool = False,
        wanted: float = 0,
    ) -> QuadMesh:
        """The quad mesh of the whole surface, of a traced one of the part; see :func:`finish_quads`."""
        own = [self._row(row) for row in rows]

        def on_a_plane(quads: QuadMesh) -> np.ndarray:
            return self._vertices_on_planes(quads).any(axis=1)

        wanted /= 2 ** len(self.units)
        quads = finish_quads(quads, self.mesh, own, rounds, only_quads, closes_tunnels, on_a_plane, wanted)
        quads = _without_tips(quads, self._vertices_on_planes(quads))
        has_tips = (quads.sizes == 3).any()
        on_planes = self._vertices_on_planes(quads)
        for k, unit in enumerate(self.units):
            quads, source = _add_reflection(quads, unit, on_planes[:, k])
            on_planes = on_planes[source]
        quads = self._put_on_surface(quads)
        if has_tips and (quads.sizes == 4).all():
            quads = _without_doublets(quads)
            quads = self._smooth_bad(quads, rows, rounds) if rounds else quads
        check_quads(quads, self.whole, closes_tunnels)
        return quads

    def _put_on_surface(self, quads: QuadMesh) -> QuadMesh:
        """The quad mesh with the triangles nearest to its vertices."""
        _, triangles = self.whole.finder.nearest(quads.vertices)
        return replace(quads, triangles=triangles, weights=barycentric(self.whole, triangles, quads.vertices))

    def _smooth_bad(self, quads: QuadMesh, rows: Sequence[Row], rounds: int) -> QuadMesh:
        """The whole quad mesh with vertices moved where corners are bad, since faces were joined with reflections.

        Faces of which only a half was seen before may be folded: these are also fitted anew.
        """
        planes = plane_edges(self.whole, self.units)
        for steps, limit in ((0, MOVING), (rounds, BAD), (0, MOVING)):
            offs = worst_deviations(quads)
            moved, near = smooth_faces(quads, self.whole, rows, steps, offs > limit, planes)
            places = moved.vertices
            images = [cKDTree(quads.vertices).query(_reflect(quads.vertices, unit))[1] for unit in self.units]
            for unit, image in zip(self.units, images, strict=True):
                places = (places + _reflect(places[image], unit)) / 2
            # On the surface again, where one side decides for both.
            sides, places = places @ self.units.T, self.whole.finder.nearest(places)[0]
            for unit, image, side in zip(self.units, images, sides.T, strict=True):
                mirrored = _reflect(places[image], unit)
                places = np.where((side < 0)[:, None], mirrored, places)
                places = np.where((image == np.arange(len(image)))[:, None], (places + mirrored) / 2, places)
            tried = replace(quads, vertices=np.where(near[:, None], places, quads.vertices))
            # Of each connected part, the better places count.
            gains, ends, corners = offs**2 - worst_deviations(tried) ** 2, quads.half_edges, quads.corner_vertices
            labels = components(len(near), ends[near[ends].all(axis=1)])
            goes = near & (np.bincount(labels[corners], gains[quads.corner_faces] * near[corners]) > 0)[labels]
            for image in images:
                goes &= goes[image]
            quads = self._put_on_surface(replace(quads, vertices=np.where(goes[:, None], places, quads.vertices)))
        return quads

    def _vertices_on_planes(self, quads: QuadMesh) -> np.ndarray:
        """(n, k) bool: vertices of a quad mesh of the part that become vertices on each plane.

        They are on edges in the plane, or were added at the boundary of the quads beside it.
        """
        used = quads.weights > _ON_EDGE
        corners = self.mesh.triangles[quads.triangles]
        on_planes = (self._on_planes[corners] | ~used[:, :, None]).all(axis=1)
        on_boundary = (self.whole.boundary_vertices[self.vertices][corners] | ~used).all(axis=1)
        beside = np.abs(quads.vertices @ self.units.T) < _BESIDE * quads.edge_lengths.mean()
        return quads.on_rim[:, None] & (on_planes | (beside & ~on_boundary[:, None]))


def _without_tips(quads: QuadMesh, on_planes: np.ndarray) -> QuadMesh:
    """The quad mesh without vertices on a plane that a quad has alone, between two others on the plane.

    The triangle that is left becomes a quad with its reflection.
    """
    corners, after, before = quads.corner_vertices, quads.next_corners, quads.previous_corners
    inside = on_planes[corners] & on_planes[corners[before]] & on_planes[corners[after]]
    tips = (inside & ~on_planes[corners[after[after]]]).any(axis=1)
    tips &= (np.bincount(corners)[corners] == 1) & (quads.sizes == 4)[quads.corner_faces]
    return quads.with_faces(corners[~tips], quads.sizes - np.bincount(quads.corner_faces, tips).astype(int))


def _add_reflection(quads: QuadMesh, unit: np.ndarray, on_plane: np.ndarray) -> tuple[QuadMesh, np.ndarray]:
    """Join the quad mesh to its reflection at the vertices of (n,) bool; returns also the vertex that each came from.

    A triangle with a side on the plane becomes a quad with its reflection.
    """
    source = np.append(np.arange(len(on_plane)), np.flatnonzero(~on_plane))
    image = np.arange(len(on_plane))
    image[~on_plane] = len(on_plane) + np.arange(np.count_nonzero(~on_plane))
    heights = quads.vertices @ unit
    lifts = np.where(on_plane, -heights, np.maximum(_APART * quads.edge_lengths.mean() - heights, 0))
    places = quads.vertices + np.outer(lifts, unit)
    moved = places[~on_plane]
    corners, after, faces = quads.corner_vertices, quads.next_corners, quads.corner_faces
    sides = (quads.sizes == 3)[faces] & on_plane[corners] & on_plane[corners[after]] & ~on_plane[corners[after[after]]]
    joined = np.zeros(len(quads.sizes), bool)
    joined[faces[sides]] = True
    backwards = np.lexsort((-np.arange(len(corners)), faces))
    backwards = backwards[~joined[faces[backwards]]]
    here = np.insert(corners, np.flatnonzero(sides) + 1, image[corners[after[after[sides]]]])
    result = replace(
        quads,
        vertices=np.concatenate([places, _reflect(moved, unit)]),
        corner_vertices=np.concatenate([here, image[corners[backwards]]]),
        sizes=np.concatenate([quads.sizes + joined, quads.sizes[~joined]]),
    )
    return result, source


def _reflect(places: np.ndarray, unit: np.ndarray) -> np.ndarray:
    """(n, 3) mirror images of places in the plane with a unit normal."""
    return places - 2 * np.outer(places @ unit, unit)


def _without_doublets(quads: QuadMesh) -> QuadMesh:
    """The quad mesh with each two quads joined that are the only ones at a vertex inside."""
    faces, inside = quads.corner_vertices.reshape(-1, 4), ~quads.on_rim
    while True:
        alone = inside & (np.bincount(faces.ravel(), minlength=len(inside)) == 2)
        found = filter(None, (join_around(faces, vertex) for vertex in np.flatnonzero(alone).tolist()))
        if (joined := next(found, None)) is None:
            return quads.with_faces(faces.ravel(), np.full(len(faces), 4))
        faces = joined[0]


def plane_edges(mesh: TriangleMesh, units: np.ndarray) -> np.ndarray:
    """Indices of the edges in planes of :class:`MirrorSide`, with faces on both sides."""
    on_planes = sides_of_planes(mesh, units) == 0
    return np.flatnonzero(on_planes[mesh.edges].all(axis=1).any(axis=1) & (mesh.edge_face_counts == 2))


def without_image(quads: QuadMesh, unit: np.ndarray) -> int:
    """How many vertices are farther than a hundredth of a mean edge from all mirror images."""
    apart, _ = cKDTree(quads.vertices).query(_reflect(quads.vertices, unit))
    return int(np.count_nonzero(apart > _SAME * quads.edge_lengths.mean()))
