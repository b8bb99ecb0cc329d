# SPDX-License-Identifier: GPL-3.0-or-later
"""The closed surface of a mesh object, parts of it, and a solid that is given for it."""

import numpy as np

from ...core.errors import MeshError, SettingError, name_elements, quote_value
from ...core.geometry.check import refuse_far_vertices
from ...core.geometry.filling.closed_surface import Area, ClosedSurface
from ...core.geometry.filling.surface_distance import SurfaceDistance, check_closed
from ...core.geometry.tet_mesh import TetMesh
from ...core.settings.guidance import BOUNDARY
from ..blender import groups, meshes
from ..blender.bvh import surface_tree

# Parts that need no vertex group, and the cosine up to which a face looks down or up: 30 degrees off level.
LOOKS, LEVEL = ("bottom", "top", "side"), 0.866
# How far the boundary of a given solid may be from the object's surface, as a share of its size.
_FITTING = 1e-3
# Faces may reach so far through others, as a share of the size: too little for a solid to show.
_SHALLOW = 1e-4


def read_surface(obj, strict=False):
    """The :class:`ClosedSurface` of a mesh object in object mode; where ``strict``, a mesh that is not manifold is
    refused instead of repaired in a copy.

    Raises MeshError naming the first element that is in the way, and carrying vertices where the surface is open or
    meets itself.
    """
    given = meshes.read_mesh(obj, strict=strict, weld=not strict)
    refuse_far_vertices(given.mesh)
    if len(given.across):
        vertices = np.unique(given.source[given.seam])
        raise MeshError(f"{obj.name} is one-sided and encloses nothing: fill a closed surface with two sides", vertices)
    if given.findings and len(given.mesh.boundary_edges):
        meshes.read_mesh(obj, strict=True)  # its error says why the surface is not closed
    check_closed(given.mesh, given.source)
    distance = SurfaceDistance(given.mesh)
    _refuse_crossings(given, _SHALLOW * float(np.linalg.norm(np.ptp(distance.bounds, axis=0))))
    if distance.volume <= 1e-9 * float(np.ptp(distance.bounds, axis=0).max()) ** 3:
        raise MeshError(f"{obj.name} encloses no volume: give it thickness, with Solidify for instance")
    return ClosedSurface(given, distance)


def _refuse_crossings(given, shallow):
    """Refuse faces that meet those of another piece, or reach through their own piece by more than a length."""
    triangles = given.source[given.mesh.triangles]
    tree = surface_tree(given.mesh.vertices, given.mesh.triangles)
    pairs = np.array(tree.overlap(tree), int).reshape(-1, 2)
    apart = (triangles[pairs[:, 0], :, None] != triangles[pairs[:, 1], None, :]).all(axis=(1, 2))
    pairs = pairs[apart]
    deep = np.minimum(_dips(given.mesh, *pairs.T), _dips(given.mesh, *pairs[:, ::-1].T)) > shallow
    piece = given.mesh.pieces[given.mesh.triangles[pairs, 0]]
    met = np.unique(pairs[deep | (piece[:, 0] != piece[:, 1])])
    if len(met):
        faces = np.unique(given.polygons.triangle_faces[met])
        verb = "meets" if len(faces) == 1 else "meet"
        raise MeshError(
            f"{name_elements('face', faces)} {verb} other faces of the mesh, where inside and outside are not defined: "
            "join the parts with a Boolean union or a Remesh modifier, and apply it",
            triangles[met],
        )


def _dips(mesh, one, other):
    """(k,) how far triangles reach through the planes of others, on the side where they reach less far."""
    away = mesh.vertices[mesh.triangles[one]] - mesh.vertices[mesh.triangles[other, :1]]
    heights = np.einsum("kcx,kx->kc", away, mesh.face_normals[other])
    return np.minimum(heights.max(axis=1), -heights.min(axis=1))


def read_area(obj, given, name):
    """The :class:`Area` of a vertex group, of the whole surface by the name "boundary", or of the faces that look down,
    up, or neither, by the names "bottom", "top" and "side"."""
    if name == BOUNDARY and name not in obj.vertex_groups:
        return Area("the boundary", np.arange(given.mesh.triangle_count))
    if name in LOOKS and name not in obj.vertex_groups:
        # The measured space has the object's scale, but neither its turn nor its mirroring.
        to_world = np.array(obj.matrix_world.to_3x3()) @ np.linalg.inv(given.stretch)
        down = to_world.T @ (0.0, 0.0, -1.0)
        corners = given.mesh.vertices[given.mesh.triangles]
        outward = 1 if np.linalg.det(corners - corners.mean(axis=(0, 1))).sum() > 0 else -1
        cosines = outward * given.mesh.face_normals @ down
        looks = {"bottom": cosines > LEVEL, "top": cosines < -LEVEL, "side": np.abs(cosines) <= LEVEL}[name]
        if not looks.any():
            raise SettingError(f"no face of {obj.name} is its {name}: assign a vertex group of that name")
        return Area(f"the {name}", np.flatnonzero(looks))
    return Area.of_members(given, groups.read_group(obj, name)[given.source], f"the vertex group {name!r}")


def fit_solid(obj, surface, solid):
    """A given solid in the measured space; refuses one that is not the object's."""
    if not isinstance(solid, TetMesh):
        raise SettingError(f"the solid is {quote_value(solid)}: give a TetMesh, or None to fill the surface")
    solid = TetMesh(solid.vertices @ surface.given.stretch.T, solid.tets)
    apart = np.abs(surface.distance(solid.vertices[solid.boundary_vertices])).max()
    if apart > _FITTING * surface.reach:
        raise SettingError(
            f"the solid's boundary is up to {apart:.3g} from the surface of {obj.name}: give the solid of this object"
        )
    return solid
