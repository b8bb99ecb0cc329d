# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirror-symmetric quad meshes, made of one half and its reflection."""

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from ...geometry import TriangleMesh
from ...geometry.barycentric import barycentric
from .trace.quad_mesh import QuadMesh

# A vertex nearer to a mirror plane than this share of the object's size lies on it.
ON_PLANE = 1e-5
# Largest distance, in mean edge lengths, of a vertex from the mirror image of its partner, and from its own if it is
# put onto the plane.
PARTNER_REACH, OWN_REACH = 0.3, 0.5
# Vertices that are nearer than this to a mirror image, in mean edge lengths, have one.
_SAME = 0.01


def mirror_half(quads: QuadMesh, mesh: TriangleMesh, normal: np.ndarray) -> QuadMesh:
    """The half on the positive side of a plane through the origin with its reflection; unchanged where they do not fit.

    Faces across the plane become their positive part and its reflection. The surface is symmetric; the plane's normal
    (3,) may have any length.
    """
    unit = normal / np.linalg.norm(normal)
    heights = quads.vertices @ unit
    # A vertex that is nearly its own mirror image, as at a disclination beside the plane, is put onto it.
    apart, nearest = _images(quads, unit)
    on_plane = np.abs(heights) <= ON_PLANE * np.ptp(quads.vertices, axis=0).max()
    on_plane |= (nearest == np.arange(len(nearest))) & (apart <= OWN_REACH * quads.edge_lengths.mean())
    sides = np.where(on_plane, 0, np.sign(heights)).astype(int)
    count = len(quads.vertices)
    flat = quads.vertices - np.outer(np.where(sides == 0, heights, 0), unit)
    # The image of vertex k is vertex count + k; vertices on the plane are their own images.
    image = np.where(sides == 0, 0, count) + np.arange(count)
    faces = []
    for corners in np.split(quads.corner_vertices, quads.starts[1:]):
        there = sides[corners]
        if there.max() <= 0:
            continue
        if there.min() >= 0:
            faces += [corners, image[corners[::-1]]]
            continue
        # The run of corners on the positive side, which begins and ends on the plane.
        first = np.flatnonzero((there >= 0) & (np.roll(there, 1) < 0))
        if len(first) != 1:
            return quads
        run = np.roll(corners, -first[0])
        run = run[np.cumprod(sides[run] >= 0).astype(bool)]
        back = image[run[::-1]]
        faces.append(np.concatenate([run, back[~np.isin(back, run)]]))
    if not faces:
        return quads
    used, corner_vertices = np.unique(np.concatenate(faces), return_inverse=True)
    places = np.concatenate([flat, flat - 2 * np.outer(flat @ unit, unit)])[used]
    _, triangles = mesh.finder.nearest(places)
    result = replace(
        quads,
        vertices=places,
        triangles=triangles,
        weights=barycentric(mesh, triangles, places),
        corner_vertices=corner_vertices,
        sizes=np.array([len(face) for face in faces]),
    )
    return result if _fits(result, quads) else quads


def _fits(quads: QuadMesh, before: QuadMesh) -> bool:
    """Whether a mesh is as regular as the one before it."""
    return (
        quads.is_simple
        and quads.sizes.min() > 2
        and quads.edges[1].max() <= 2
        and quads.euler_characteristic == before.euler_characteristic
        and (quads.sizes != 4).sum() <= (before.sizes != 4).sum()
    )


def partners(quads: QuadMesh, normal: np.ndarray) -> np.ndarray | None:
    """(n,) vertex nearest to the mirror image of each, or None if that is not a pairing of near vertices."""
    apart, partner = _images(quads, normal / np.linalg.norm(normal))
    is_near = apart.max(initial=0) <= PARTNER_REACH * quads.edge_lengths.mean()
    return partner if is_near and (partner[partner] == np.arange(len(partner))).all() else None


def without_image(quads: QuadMesh, normal: np.ndarray) -> int:
    """How many vertices are farther than a hundredth of a mean edge from all mirror images."""
    apart, _ = _images(quads, normal / np.linalg.norm(normal))
    return int(np.count_nonzero(apart > _SAME * quads.edge_lengths.mean()))


def _images(quads: QuadMesh, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,) distance of the mirror image of each vertex from the nearest vertex, and (n,) that vertex."""
    apart, nearest = cKDTree(quads.vertices).query(quads.vertices - 2 * np.outer(quads.vertices @ unit, unit))
    return apart, nearest


def average_with_partners(points: np.ndarray, partner: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Points moved halfway to the mirror images of their partners."""
    unit = normal / np.linalg.norm(normal)
    image = points[partner] - 2 * np.outer(points[partner] @ unit, unit)
    return (points + image) / 2
