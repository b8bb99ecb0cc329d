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
from ..fields.patterns import KnownPattern
from ..geometry.mesh_input import MeshInput, ObjectMesh
from ..geometry.polygons import Polygons
from ..geometry.triangle_mesh import TriangleMesh
from ..graphs import sum_by
from ..matchings import after_turns
from ..solution import GLANCE
from .surface_source import SurfaceSource

if TYPE_CHECKING:
    from .surfaces import SurfaceRequest

# Vertices from which on meshes have a glimpse; cells in a period; least number of vertices to one of the copy.
FEWEST, CELLS, LEAST = 20_000, 1.2, 3


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
    """The picture, of the triangles of the mesh.

    None for meshes that are not much finer than the pattern, and for requests with guides, constraints, symmetries,
    pins, or directions that are given.
    """
    mesh, source = request.given.mesh, request.source
    is_bound = source.guides or request.rows or request.mirrors or request.pins or source.directions is not None
    if mesh.vertex_count < FEWEST or is_bound or request.start is not None:
        return None
    cluster = _clusters(mesh, float(np.min(request.spacings)) / CELLS)
    count = int(cluster.max()) + 1
    if LEAST * count > mesh.vertex_count:
        return None
    first = np.zeros(count, int)
    first[cluster] = np.arange(mesh.vertex_count)
    try:
        given = _coarse_copy(mesh, cluster, count)
        at = first[given.source]
        spacings, turns = (
            values[at] if isinstance(values, np.ndarray) and values.ndim else values
            for values in (request.spacings, source.turns)
        )
        settings = replace(request.settings, strict=False)
        coarse = SurfaceSource(given, turns=turns)
        result = replace(
            request,
            source=coarse,
            settings=settings,
            spacings=spacings,
            options=replace(request.options, method=GLANCE),
        ).solve()
    except SynchError:
        return None
    assert result.pattern is not None  # only patterns are shown
    places = (mesh.vertices @ np.linalg.inv(request.given.stretch).T)[mesh.triangles].reshape(-1, 3)
    waves = _local_waves(mesh, cluster, given, result.pattern)
    phases = np.zeros((len(places), 2), np.float32)
    phases[:, : waves.shape[1]] = waves
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


def _coarse_copy(mesh: TriangleMesh, cluster: np.ndarray, count: int) -> MeshInput:
    """A surface whose vertices are the means of the clusters; raises MeshError where no triangle is left."""
    places = sum_by(cluster, mesh.vertices, count) / np.bincount(cluster, minlength=count)[:, None]
    triangles = cluster[mesh.triangles]
    triangles = triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]
    keys = np.sort(triangles, axis=1) @ np.array([count**2, count, 1])
    triangles = triangles[np.unique(keys, return_index=True)[1]]
    polygons = Polygons.of_triangles(TriangleMesh(places, triangles))
    return ObjectMesh("the coarse copy", places, polygons, np.eye(3)).surface()


def _local_waves(mesh: TriangleMesh, cluster: np.ndarray, given: MeshInput, pattern: KnownPattern) -> np.ndarray:
    """(3 m, k) phases at the corners of m triangles; inside a triangle they change without jumps of full turns."""
    one_form = pattern.one_form
    x, y = given.mesh.tangent_frames
    angles = one_form.angles[:, None] + np.arange(one_form.phase_count) * one_form.turn
    waves = np.cos(angles)[..., None] * x[:, None] + np.sin(angles)[..., None] * y[:, None]
    waves = given.at_object(one_form.rates[..., None] * waves)[cluster]
    phases = given.at_object(np.angle(pattern.phases).reshape(angles.shape))[cluster]
    phases += np.einsum("nkx,nx->nk", waves, mesh.vertices - given.at_object(given.mesh.vertices)[cluster])
    first, *others = mesh.triangles.T
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
