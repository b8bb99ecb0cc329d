# SPDX-License-Identifier: GPL-3.0-or-later
"""Field files of other programs: directions on the faces of an object, in its own space."""

from functools import partial

import bpy
import numpy as np

from ...core.errors import MeshError, SettingError, name_elements
from ...core.fields.directions import DirectionField, given_directions
from ...core.files.directions import FaceField, from_vertices, read_field, to_vertices, write_field
from ...core.geometry import mesh_input
from ...core.settings.surface import SYMMETRY_ORDERS
from ...core.validation import check_path
from . import attributes, meshes
from .pattern_surface import source_faces, surface_of
from .schema import DIRECTION


def check_triangles(polygons):
    """Refuse a mesh with other faces than triangles: a field file has directions for triangles only."""
    larger = np.flatnonzero(polygons.sizes > 3)
    if len(larger):
        raise MeshError(
            f"{name_elements('face', larger)} has more than three corners and a field file has directions for "
            "triangles only: triangulate the mesh with Face > Triangulate Faces"
        )


def read_guide(given, path):
    """Read a field file for the triangles of a :class:`MeshInput`: its symmetry, and a function that makes the Guide on
    the vertices.

    Raises MeshError or SettingError for faces other than triangles, and files that cannot be read.
    """
    check_triangles(given.polygons)
    field = read_field(bpy.path.abspath(check_path(path)))
    vectors, polygons = field.vectors, given.polygons
    if len(vectors) == len(polygons.starts):
        vectors = vectors[polygons.triangle_faces]
    measured = FaceField(field.symmetry, vectors @ given.stretch.T)
    return field.symmetry, partial(to_vertices, given.mesh, measured)


def import_directions(obj, path) -> str:
    """Write the directions of a field file to the object's ``synch_direction``; returns the symmetry's name.

    Vertices whose faces have no direction get a zero vector.
    """
    given = meshes.read_mesh(obj)
    symmetry, compute = read_guide(given, path)
    names = {number: name for name, number in SYMMETRY_ORDERS.items()}
    if symmetry not in names:
        raise SettingError(f"{path} has {symmetry} directions a face: import fields of 1, 2 or 4")
    guide = compute()
    vectors = given.to_object(DirectionField(given.mesh, symmetry, guide.angles).vectors)
    vectors[given.at_object(guide.weights) == 0] = 0
    attributes.write(obj, DIRECTION, vectors)
    meshes.update(obj)
    return names[symmetry]


def export_directions(obj, path, symmetry):
    """Write the object's ``synch_direction`` as a .rawfield or .rosy file; the symmetry says what they are: "vector",
    "line" or "cross".

    Raises MeshError or SettingError for faces other than triangles, an object without directions, and files that
    cannot be written.
    """
    path, number = bpy.path.abspath(check_path(path)), SYMMETRY_ORDERS[symmetry]
    check_triangles(meshes.read_polygons(obj))
    surface = surface_of(obj)
    local = _face_directions(surface, number)
    if surface != obj:
        local = local[_middle_faces(obj, surface)]
    write_field(path, FaceField(number, local))


def _face_directions(obj, number):
    """(m, number, 3) directions on an object's faces, in its own space."""
    given = meshes.read_mesh(obj)
    angles = given_directions(given.mesh, number, attributes.read_vectors(obj, DIRECTION.name, given)).angles
    found = from_vertices(given.mesh, number, angles).vectors
    vectors = np.zeros((len(given.polygons.starts), *found.shape[1:]))
    vectors[given.polygons.triangle_faces] = found
    vectors = given.polygons.at_faces(vectors)
    return mesh_input.unstretched(vectors.reshape(-1, 3), given.stretch).reshape(vectors.shape)


def _middle_faces(obj, surface):
    """(m,) the face of a pattern's own surface that is nearest to the middle of each face of the object."""
    source = source_faces(obj)
    middles, parts = (attributes.read_all(mesh.data.polygons, "center", 3, np.float32) for mesh in (obj, surface))
    order = np.lexsort((((parts - middles[source]) ** 2).sum(axis=1), source))
    faces, first = np.unique(source[order], return_index=True)
    nearest = np.zeros(len(middles), int)
    nearest[faces] = order[first]
    return nearest
