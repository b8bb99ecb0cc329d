# SPDX-License-Identifier: GPL-3.0-or-later
"""Find which vertices mirror which, on a surface that is symmetric about coordinate planes through the origin."""

import numpy as np
from scipy.spatial import cKDTree

from ..errors import AsymmetryError

# How far from its mirror image a vertex may lie, in edge lengths.
TOLERANCE = 1e-3


def mirrored_vertices(mesh, polygons, axis):
    """(n,) the vertex that mirrors each one: coordinate ``axis`` (0, 1, 2) changes its sign.

    Loose vertices mirror themselves.

    Parameters
    ----------
    mesh : TriangleMesh
    polygons : Polygons over its vertices
    axis : 0, 1 or 2

    Raises
    ------
    AsymmetryError
        with the vertices that have no counterpart, or whose faces have none
    """
    sign = np.ones(3)
    sign[axis] = -1
    used = np.unique(mesh.triangles)
    distances, place = cKDTree(mesh.vertices[used]).query(mesh.vertices[used] * sign)
    partner = np.arange(mesh.vertex_count)
    partner[used] = used[place]
    near = TOLERANCE * np.median(mesh.edge_lengths)
    lonely = used[(distances > near) | (partner[partner[used]] != used)]
    if len(lonely) == 0:
        lonely = polygons.corner_vertices[_mirrored_faces(polygons, partner)[polygons.corner_faces] < 0]
    if len(lonely):
        raise AsymmetryError("XYZ"[axis], lonely)
    return partner


def carried_to_cut(partner, polygons, cut_polygons, axis):
    """The mirrored vertices of a mesh that was cut open, from those of the whole one.

    Parameters
    ----------
    partner : from :func:`mirrored_vertices`
    polygons, cut_polygons : Polygons before and after the cut
    axis : for messages

    Raises
    ------
    AsymmetryError
        when the cut is not symmetric
    """
    faces = _mirrored_faces(polygons, partner)[polygons.corner_faces]
    before, after = polygons.corner_vertices, cut_polygons.corner_vertices
    # The corner of the mirrored face at the mirrored vertex.
    key = polygons.corner_faces * (before.max() + 1) + before
    order = np.argsort(key)
    image = order[np.searchsorted(key[order], faces * (before.max() + 1) + partner[before])]
    carried = np.arange(max(len(partner), after.max() + 1))
    carried[after] = after[image]
    apart = (carried[after] != after[image]) | (carried[carried[after]] != after)
    if apart.any():
        raise AsymmetryError("XYZ"[axis], before[apart])
    return carried


def _mirrored_faces(polygons, partner):
    """(p,) the face whose vertices mirror those of each one, -1 where there is none."""
    found = np.full(len(polygons.starts), -1)
    for size in np.unique(polygons.sizes):
        faces = np.flatnonzero(polygons.sizes == size)
        vertices = polygons.corner_vertices[polygons.starts[faces, None] + np.arange(size)]
        both = np.sort(np.concatenate([vertices, partner[vertices]]), axis=1)
        labels = np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)
        face_of = np.full(labels.max() + 1, -1)
        face_of[labels[: len(faces)]] = faces
        found[faces] = face_of[labels[len(faces) :]]
    return found
