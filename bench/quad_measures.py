# SPDX-License-Identifier: GPL-3.0-or-later
"""What a quad mesh is worth, whoever made it: the same figures for all."""

import numpy as np

from synch_fields.core.errors import MeshError
from synch_fields.core.extract.quads.measure.loops import quad_loops
from synch_fields.core.extract.quads.measure.quality import corner_angles, quality
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.check import check_mesh
from synch_fields.core.geometry.nearest import NearestTriangles


def quad_mesh_of(vertices, corner_vertices, sizes):
    """The :class:`QuadMesh` of any faces, without loose vertices; nothing is known of the surface below."""
    used, corner_vertices = np.unique(corner_vertices, return_inverse=True)
    return QuadMesh(np.asarray(vertices, float)[used], None, None, corner_vertices, np.asarray(sizes))


def longest_side(mesh):
    """Of the box of a triangle mesh's faces."""
    return float(np.ptp(mesh.vertices[np.unique(mesh.triangles)], axis=0).max())


def figures(quads, given):
    """What a row says of a :class:`QuadMesh` over the given :class:`TriangleMesh`, as plain numbers.

    As :func:`quality`, with the angles inside the faces, up to 360 degrees, and ``reflex_corners``, those over 180;
    ``distance`` is the Hausdorff distance over the longest side, and ``turned_faces`` look against the surface.
    ``irregular_on_rim`` counts vertices on the boundary with another number of faces than of right angles there.
    """
    angles = corner_angles(quads)
    off = np.abs(angles - 90)
    away, turned = distance(quads, given)
    return quality(quads) | {
        "irregular_on_rim": irregular_on_rim(quads, angles),
        "short_loop_share": quad_loops(quads).short_share,
        "angle_deviation": float(off.mean()),
        "worst_angle": float(off.max()),
        "widest_angle": float(angles.max()),
        "reflex_corners": int((angles > 180).sum()),
        "other_faces": int((quads.sizes != 4).sum()),
        "turned_faces": turned,
        "distance": away / longest_side(given),
        "given_characteristic": given.euler_characteristic,
        "given_closed": len(given.boundary_edges) == 0,
        "manifold": manifold(quads),
    }


def irregular_on_rim(quads, angles):
    """Number of boundary vertices with another number of faces than the number of right angles nearest to theirs."""
    at, count = quads.corner_vertices, len(quads.vertices)
    right_angles = np.maximum(np.rint(np.bincount(at, angles, count) / 90), 1)
    return int((quads.on_rim & (np.bincount(at, minlength=count) != right_angles)).sum())


def manifold(quads):
    """ "yes", or what is wrong with the triangles around the middles of the faces."""
    try:
        check_mesh(TriangleMesh(*fans(quads)), quads.corner_faces)
    except MeshError as error:
        return str(error).split(":")[0]
    return "yes"


def fans(quads):
    """Vertices with the middles of the faces after them, and the triangles around these."""
    middles = np.add.reduceat(quads.vertices[quads.corner_vertices], quads.starts) / quads.sizes[:, None]
    triangles = np.column_stack([quads.half_edges, len(quads.vertices) + quads.corner_faces])
    return np.concatenate([quads.vertices, middles]), triangles


def face_vectors(quads):
    """(f, 3) the area of each face times its normal."""
    here = (
        quads.vertices[quads.corner_vertices] - quads.vertices[quads.corner_vertices[quads.starts]][quads.corner_faces]
    )
    return np.add.reduceat(np.cross(here, here[quads.next_corners]), quads.starts) / 2


def distance(quads, given):
    """Hausdorff distance of a quad mesh and the given one, and the number of faces that look against the given one.

    Taken both ways at vertices and the middles of edges and faces; a face is the triangles around its middle. A face
    looks against the surface where its normal points to the back of the triangle nearest to its middle.
    """
    vertices, triangles = fans(quads)
    theirs, ours = NearestTriangles(given.vertices, given.triangles), NearestTriangles(vertices, triangles)
    places = np.concatenate([vertices, vertices[quads.edges[0]].mean(axis=1)])
    there, nearest = theirs.nearest(places)
    parts = [
        given.vertices[np.unique(given.triangles)],
        given.vertices[given.edges].mean(axis=1),
        given.vertices[given.triangles].mean(axis=1),
    ]
    back_places = np.concatenate(parts)
    back = ours.nearest(back_places)[0]
    away = max(_farthest(there, places), _farthest(back, back_places))
    normals = given.face_normals[nearest[len(quads.vertices) : len(vertices)]]
    return away, int((np.einsum("fx,fx->f", face_vectors(quads), normals) < 0).sum())


def _farthest(there, places):
    return float(np.linalg.norm(there - places, axis=1).max())
