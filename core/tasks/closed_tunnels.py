# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes of surfaces with tunnels that are narrower than the quads: they are solved without these."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..geometry.barycentric import barycentric
from ..geometry.mesh_input import MeshInput
from ..geometry.polygons import Polygons
from ..geometry.tunnels import FilledMesh, without_narrow_tunnels
from ..graphs import find, pair_keys
from .surface_result import SurfaceResult

if TYPE_CHECKING:
    from .surfaces import SurfaceRequest

# Diameters of tunnels, in sides of a quad. Around smaller ones than the first there is no room for two sides, and
# around smaller ones than the second none for four; these are closed where corners are far from right angles.
NARROWEST, WIDEST = 0.6, 1.0


def without_tunnels(
    request: "SurfaceRequest", width: float, keeps_marks: bool = True
) -> tuple["SurfaceRequest", FilledMesh] | None:
    """The request on a surface without tunnels narrower than a width, in sides of a quad, and this surface.

    Edges that are only marked sharp stay so if ``keeps_marks``. None without such tunnels, or where something else
    than sharp edges and curvature guides the quads: strokes, maps, constraints, mirrors, pins or cuts.
    """
    source, given = request.source, request.given
    mesh = given.mesh
    if (
        not request.has_only_quads
        or request.settings.features == 0
        or mesh is not given.uncut
        or source.directions is not None
        or request.start is not None
        or any((source.rows, request.mirrors, request.settings.mirror, request.pins))
        or not all(guide.has_detail for guide in source.guides)
    ):
        return None
    bends = np.abs(mesh.dihedral_angles) > request.settings.features
    edges = np.union1d(np.flatnonzero(bends | (mesh.edge_face_counts == 1)), np.asarray(source.sharp, int))
    filled = without_narrow_tunnels(mesh, edges, width * request.side)
    if filled is None:
        return None
    numbers = np.append(np.arange(mesh.vertex_count), filled.sources)

    def carried(values: float | np.ndarray) -> float | np.ndarray:
        return values if np.ndim(values) == 0 else np.asarray(values)[numbers]

    count = filled.mesh.vertex_count
    marked = find(pair_keys(filled.mesh.edges, count), pair_keys(mesh.edges[np.asarray(source.sharp, int)], count))
    source = replace(
        source,
        given=_given(given, filled),
        guides=tuple(guide.on(filled.mesh) for guide in source.guides),
        turns=carried(source.turns),
        factors=carried(source.factors),
        sharp=marked[marked >= 0] if keeps_marks else (),
    )
    return request.on_source(source, carried(request.spacings)), filled


def _given(given: MeshInput, filled: FilledMesh) -> MeshInput:
    """The mesh with disks, each triangle of which is a further face."""
    mesh, polygons = filled.mesh, given.polygons
    kept = mesh.triangles.max(axis=1) < given.mesh.vertex_count
    disks, corners, faces = mesh.triangles[~kept], len(polygons.corner_vertices), len(polygons.starts)
    added = np.arange(disks.size).reshape(-1, 3) + corners
    numbers = filled.triangles[kept]
    whole = Polygons(
        np.concatenate([polygons.corner_vertices, disks.ravel()]),
        np.concatenate([polygons.starts, added[:, 0]]),
        np.concatenate([polygons.sizes, np.full(len(disks), 3)]),
        np.concatenate([polygons.triangle_corners[numbers], added]),
        np.concatenate([polygons.triangle_faces[numbers], np.arange(faces, faces + len(disks))]),
    )
    source = np.append(given.source, given.source[filled.sources])
    return replace(given, mesh=mesh, uncut=mesh, polygons=whole, source=source)


def on_surface(result: SurfaceResult, request: "SurfaceRequest", filled: FilledMesh) -> SurfaceResult:
    """The result on a surface without tunnels with its quad mesh on the request's surface.

    Triangles of disks, which are in no face of that, count to a face beside them: defects are reported by faces.
    """
    quads, mesh = result.quads, request.given.mesh
    assert quads is not None
    triangles = filled.triangles[quads.triangles]
    weights = np.maximum(barycentric(mesh, triangles, quads.vertices), 0)
    quads = replace(quads, triangles=triangles, weights=weights / weights.sum(axis=1, keepdims=True))
    given = _given(request.given, filled)
    polygons = replace(given.polygons, triangle_faces=request.given.polygons.triangle_faces[filled.triangles])
    return replace(result, quads=quads, given=replace(given, polygons=polygons))
