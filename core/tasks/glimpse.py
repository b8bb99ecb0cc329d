# SPDX-License-Identifier: GPL-3.0-or-later
"""A first picture of a pattern on a fine mesh, long before its first field: a pattern on a coarse copy of the mesh.

Vertices in the same cell of a cubic grid that face the same way are one vertex of the copy. Each of these has a plane
wave around it, which the picture shows on the fine mesh.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..defects import wrap
from ..errors import SynchError
from ..fields import Guide, Row
from ..fields.constraints.lines import Line
from ..fields.patterns import KnownPattern
from ..geometry.mesh_input import MeshInput, ObjectMesh
from ..geometry.polygons import Polygons
from ..geometry.triangle_mesh import TriangleMesh
from ..graphs import sum_by
from ..matchings import after_turns
from ..solution import GLANCE
from .surface_source import PendingGuide, SurfaceSource

if TYPE_CHECKING:
    from .surfaces import SurfaceRequest

# Vertices from which on meshes have a glimpse of stripes and quads, and of quad meshes, whose drafts take longer; cells
# in a period, and in two quads; least number of vertices to one of the copy.
FEWEST, FEWEST_OF_MESHES = 20_000, 6_000
CELLS, CELLS_OF_MESHES, LEAST = 1.2, 1.8, 3


@dataclass(frozen=True)
class Picture:
    """Triangles to draw.

    Attributes
    ----------
    places : (3 t, 3) float32 corners of the triangles, in the object's space
    phases : (3 t, 2) float32 radians there; the second is 0 for stripes
    of_quads : whether there are two phases
    is_result : False for a glimpse, whose pattern is not one of the mesh and cannot be the result of a solve
    """

    places: np.ndarray
    phases: np.ndarray
    of_quads: bool
    is_result: bool = True


def glimpse(request: "SurfaceRequest") -> Picture | None:
    """The picture, of the triangles of the mesh; of a quad mesh, the quads of a pattern with sides as long as its.

    None for meshes that are not much finer than the pattern, one-sided ones, requests with pins or directions that are
    given, and where constraints contradict one another on the coarse copy. With mirrors it is the picture of the
    positive side and its images.
    """
    mesh, source, spacings = request.given.mesh, request.source, request.spacings
    is_bound = request.given.seam is not None or request.pins or source.directions is not None
    fewest, cells = FEWEST, CELLS
    if request.command == "quad_mesh":
        fewest, cells = FEWEST_OF_MESHES, CELLS_OF_MESHES
        spacings = spacings * (2 * request.side / float(np.mean(spacings)))
    if mesh.vertex_count < fewest or is_bound or request.start is not None:
        return None
    cluster = _clusters(mesh, float(np.min(spacings)) / cells)
    count = int(cluster.max()) + 1
    if LEAST * count > mesh.vertex_count:
        return None
    planes = request.mirror_planes
    triangles = mesh.triangles[(mesh.vertices[mesh.triangles].sum(axis=1) @ planes.T >= 0).all(axis=1)]
    try:
        copy = _CoarseCopy.of(mesh, triangles, cluster, count)
        guides = tuple(copy.guide(*guide.weighted(request.side)) for guide in source.guides)
        coarse = SurfaceSource(copy.given, guides=guides, turns=copy.values(source.turns))
        result = replace(
            request,
            command="stripes" if request.command == "stripes" else "quads",
            source=coarse,
            settings=replace(request.settings, strict=False),
            spacings=copy.values(spacings),
            rows=tuple(copy.row(row) for row in request.rows),
            mirrors=(),
            options=replace(request.options, method=GLANCE),
        ).solve()
    except SynchError:
        return None
    assert result.pattern is not None  # only patterns are shown
    places = mesh.vertices[triangles].reshape(-1, 3)
    waves = _local_waves(mesh, triangles, cluster, copy.given, result.pattern)
    phases = np.zeros((len(places), 2), np.float32)
    phases[:, : waves.shape[1]] = waves
    for unit in planes:
        places = np.concatenate([places, places - 2 * np.outer(places @ unit, unit)])
        phases = np.concatenate([phases, phases])
    places = places @ np.linalg.inv(request.given.stretch).T
    return Picture(places.astype(np.float32), phases, request.command != "stripes", is_result=False)


def _clusters(mesh: TriangleMesh, size: float) -> np.ndarray:
    """(n,) numbers, without gaps, of vertices in the same cell of a size whose normals have the same main axis."""
    normals, cells = mesh.vertex_normals, np.floor(mesh.vertices / size).astype(np.int64)
    axis = np.abs(normals).argmax(axis=1)
    side = 2 * axis + (normals[np.arange(len(axis)), axis] > 0)
    cells -= cells.min(axis=0)
    spans = cells.max(axis=0) + 1
    keys = ((cells[:, 0] * spans[1] + cells[:, 1]) * spans[2] + cells[:, 2]) * 6 + side
    return np.unique(keys, return_inverse=True)[1].reshape(-1)


@dataclass(frozen=True)
class _CoarseCopy:
    """The coarse copy of a mesh.

    Attributes
    ----------
    given : a surface whose vertices are the means of clusters
    nearest : (n,) vertex of the copy of each vertex of the mesh
    first : (k,) one vertex of the mesh of each vertex of the copy
    """

    mesh: TriangleMesh
    given: MeshInput
    nearest: np.ndarray
    first: np.ndarray

    @classmethod
    def of(cls, mesh: TriangleMesh, triangles: np.ndarray, cluster: np.ndarray, count: int) -> "_CoarseCopy":
        """The copy of (t, 3) triangles with (n,) clusters; raises MeshError where no triangle is left."""
        places = sum_by(cluster, mesh.vertices, count) / np.bincount(cluster, minlength=count)[:, None]
        triangles = cluster[triangles]
        triangles = triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]
        keys = np.sort(triangles, axis=1) @ np.array([count**2, count, 1])
        triangles = triangles[np.unique(keys, return_index=True)[1]]
        polygons = Polygons.of_triangles(TriangleMesh(places, triangles))
        given = ObjectMesh("the coarse copy", places, polygons, np.eye(3)).surface()
        first = np.zeros(count, int)
        first[cluster] = np.arange(mesh.vertex_count)
        return cls(mesh, given, given.at_object(np.arange(given.mesh.vertex_count))[cluster], first[given.source])

    def values(self, values: float | np.ndarray) -> float | np.ndarray:
        """One value, or those at the vertices of the copy of (n, ...) at the mesh's."""
        return values[self.first] if isinstance(values, np.ndarray) and values.ndim else values

    def guide(self, guide: Guide, share: float) -> PendingGuide:
        """A guide and its share on the copy, where each vertex has the weights of all that it stands for."""
        nodes = np.arange(len(self.first))
        angles = self._angles(guide.angles[self.first], self.first, nodes)
        weights = np.bincount(self.nearest, guide.weights, len(nodes))
        return PendingGuide("guide", lambda: Guide(angles, weights), share)

    def row(self, row: Row) -> Row:
        """A constraint along the same line, whose distance from the copy's vertices is another one."""
        line, mesh, copy = row.line, self.mesh, self.given.mesh
        at, nodes = line.vertices, self.nearest[line.vertices]
        x, y = mesh.tangent_frames
        left = np.cos(line.angles)[:, None] * y[at] - np.sin(line.angles)[:, None] * x[at]
        moved = np.einsum("sx,sx->s", left, copy.vertices[nodes] - mesh.vertices[at])
        links = self.nearest[line.links]
        links = np.unique(np.sort(links[links[:, 0] != links[:, 1]], axis=1), axis=0)
        angles, offsets = self._angles(line.angles, at, nodes), line.offsets + np.nan_to_num(moved)
        kept = np.unique(self.nearest[line.nodes], return_index=True)[1]
        value = row.value[kept] if isinstance(row.value, np.ndarray) and row.value.ndim else row.value
        return replace(row, line=Line(nodes, angles, offsets, line.lengths, links), value=value)

    def _angles(self, angles: np.ndarray, at: np.ndarray, nodes: np.ndarray) -> np.ndarray:
        """(s,) angles at vertices of the copy of directions at vertices of the mesh."""
        (x, y), (over, up) = self.mesh.tangent_frames, self.given.mesh.tangent_frames
        vectors = np.cos(angles)[:, None] * x[at] + np.sin(angles)[:, None] * y[at]
        return np.arctan2(np.einsum("sx,sx->s", vectors, up[nodes]), np.einsum("sx,sx->s", vectors, over[nodes]))


def _local_waves(
    mesh: TriangleMesh, triangles: np.ndarray, cluster: np.ndarray, given: MeshInput, pattern: KnownPattern
) -> np.ndarray:
    """(3 t, k) phases at the corners of (t, 3) triangles; inside a triangle they change without jumps of full turns."""
    one_form = pattern.one_form
    x, y = given.mesh.tangent_frames
    angles = one_form.angles[:, None] + np.arange(one_form.phase_count) * one_form.turn
    waves = np.cos(angles)[..., None] * x[:, None] + np.sin(angles)[..., None] * y[:, None]
    waves = given.at_object(one_form.rates[..., None] * waves)[cluster]
    phases = given.at_object(np.angle(pattern.phases).reshape(angles.shape))[cluster]
    phases += np.einsum("nkx,nx->nk", waves, mesh.vertices - given.at_object(given.mesh.vertices)[cluster])
    first, *others = triangles.T
    corners = [phases[first]]
    for other in others:
        ahead, values = waves[other], phases[other]
        if not one_form.has_signs:
            turns = _nearest_turns(waves[first], ahead)
            values = after_turns(values, turns)
            ahead = np.stack([after_turns(axis, turns) for axis in np.moveaxis(ahead, 2, 0)], axis=2)
        way = mesh.vertices[other] - mesh.vertices[first]
        asked = corners[0] + np.einsum("tkx,tx->tk", waves[first] + ahead, way) / 2
        corners.append(asked + wrap(values - asked))
    return np.stack(corners, axis=1).reshape(-1, one_form.phase_count)


def _nearest_turns(waves: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(t,) turns after which the second of (t, k, 3) waves agree best with the first."""
    fits = [np.einsum("tkx,tkx->t", waves, others)]
    if waves.shape[1] == 2:
        crossed = [np.einsum("tx,tx->t", waves[:, k], others[:, 1 - k]) for k in range(2)]
        fits.append(crossed[0] - crossed[1])
    return np.stack([*fits, *(-fit for fit in fits)], axis=1).argmax(axis=1)
