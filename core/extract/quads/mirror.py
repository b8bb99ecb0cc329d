# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes that are their own mirror image: one half and its reflection."""

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from ...geometry.barycentric import barycentric
from ...geometry.nearest import NearestTriangles

# A vertex nearer to a mirror plane, as a share of the object's size, lies on it.
ON_PLANE = 1e-5
# How far vertices may be from each other's mirror images, in sides of a quad, to be moved onto them.
PARTNER_REACH = 0.3


def mirror_half(quads, mesh, normal):
    """The half on the positive side of a plane through the origin and its reflection; as it was where they do not fit.

    Faces that the plane passes are joined of what they have on the positive side and its reflection.

    Parameters
    ----------
    quads : QuadMesh
    mesh : TriangleMesh that it was traced on, its own mirror image
    normal : (3,) of the plane, of any length
    """
    unit = normal / np.linalg.norm(normal)
    heights = quads.vertices @ unit
    # What is its own mirror image but for a little, as at a disclination beside the plane, is on it, too.
    apart, nearest = _images(quads, unit)
    on_plane = np.abs(heights) <= ON_PLANE * np.ptp(quads.vertices, axis=0).max()
    on_plane |= (nearest == np.arange(len(nearest))) & (apart <= PARTNER_REACH * _side(quads))
    sides = np.where(on_plane, 0, np.sign(heights)).astype(int)
    count = len(quads.vertices)
    flat = quads.vertices - np.outer(np.where(sides == 0, heights, 0), unit)
    # The image of vertex k is vertex count + k, but for those on the plane.
    image = np.where(sides == 0, 0, count) + np.arange(count)
    faces = []
    for corners in np.split(quads.corner_vertices, quads.starts[1:]):
        there = sides[corners]
        if there.max() <= 0:
            continue
        if there.min() >= 0:
            faces += [corners, image[corners[::-1]]]
            continue
        # The run of corners on the positive side, with those on the plane at its two ends.
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
    _, triangles = NearestTriangles(mesh.vertices, mesh.triangles).nearest(places)
    result = replace(
        quads,
        vertices=places,
        triangles=triangles,
        weights=barycentric(mesh, triangles, places),
        corner_vertices=corner_vertices,
        sizes=np.array([len(face) for face in faces]),
    )
    return result if _fits(result, quads) else quads


def _fits(quads, before):
    """Whether a mesh is as sound as the one before it."""
    return (
        quads.is_simple
        and quads.sizes.min() > 2
        and quads.edges[1].max() <= 2
        and quads.euler_characteristic == before.euler_characteristic
        and (quads.sizes != 4).sum() <= (before.sizes != 4).sum()
    )


def partners(quads, normal):
    """(n,) vertex nearest to the mirror image of each, or None where one has none that is near."""
    apart, partner = _images(quads, normal / np.linalg.norm(normal))
    is_near = apart.max(initial=0) <= PARTNER_REACH * _side(quads)
    return partner if is_near and (partner[partner] == np.arange(len(partner))).all() else None


def _images(quads, unit):
    """(n,) distance of the mirror image of each vertex from the nearest vertex, and (n,) that one."""
    return cKDTree(quads.vertices).query(quads.vertices - 2 * np.outer(quads.vertices @ unit, unit))


def _side(quads):
    edges, _ = quads.edges
    return np.linalg.norm(quads.vertices[edges[:, 1]] - quads.vertices[edges[:, 0]], axis=1).mean()


def average_with_partners(points, partner, normal):
    """Points halfway between where they are and where the images of their partners are."""
    unit = normal / np.linalg.norm(normal)
    image = points[partner] - 2 * np.outer(points[partner] @ unit, unit)
    return (points + image) / 2
