# SPDX-License-Identifier: GPL-3.0-or-later
"""Three shapes to try: Suzanne, a pretzel with two holes, and a bent vase, evenly meshed and ready for constraints.

Pretzel and vase are coarse cages of quads that Catmull-Clark subdivision rounds. All have a vertex group "Fine", whose
weight rises along the longest side, for a spacing map; the two cages have seams where they are cut in half, and the
vase a group "Rim" at its open edge.
"""

import math

import bpy
import numpy as np
from mathutils import Matrix

from ..blender import attributes, groups, meshes
from ..blender.new_geometry import new_mesh
from .demo import add_demo_object, apply_modifiers

# What there is: identifier, name, description, icon and number.
SHAPES = (
    ("SUZANNE", "Suzanne", "Blender's monkey as one smooth surface of even triangles", "MESH_MONKEY", 0),
    ("PRETZEL", "Pretzel", "A closed surface of quads with two holes, and seams that cut it in half", "MESH_TORUS", 1),
    (
        "VASE",
        "Vase",
        "A bent vase of quads, open at its rim, with a constraint that puts a stripe there",
        "MESH_CYLINDER",
        2,
    ),
)
# Subdivisions of the cages by default; Suzanne's faces are as many times more or fewer.
DETAIL = 4
# Factors on the edges of the demo's Suzanne, by detail, at which she is in one piece.
_COARSENESS = (8.0, 4.0, 1.9, 1.0, 0.5, 0.25)
# Where the planes of the pretzel's cage lie, and its cells that are left out, of five by three.
_PLANES = (np.array([-3.3, -2.3, -0.5, 0.5, 2.3, 3.3]), np.array([-1.9, -0.9, 0.9, 1.9]), np.array([-0.6, 0.6]))
_HOLES = {(1, 1), (3, 1)}
_ROUNDING = 0.84
# Radii and heights of the vase's rings, their segments, and by how many radians it bends over its height.
_PROFILE = ((0.62, 0.0), (0.98, 0.55), (1.08, 1.15), (0.78, 1.75), (0.46, 2.3), (0.5, 2.8), (0.82, 3.15))
_SEGMENTS = 8
_BEND = 0.7


def add_sample(shape, detail=DETAIL, size=2.0):
    """Add a shape of :data:`SHAPES` at the origin, active and alone selected.

    Parameters
    ----------
    detail : from 1 to 6, how often a cage is subdivided; each more makes four times as many faces
    size : its longest side, in scene units
    """
    bpy.ops.object.select_all(action="DESELECT")
    obj = _MAKERS[shape](detail)
    places = attributes.read_values(obj, "position", "POINT").astype(float)
    lower, sides = places.min(axis=0), np.ptp(places, axis=0)
    obj.data.transform(Matrix.Scale(size / sides.max(), 4) @ Matrix.Translation(-(lower + sides / 2)))
    along = ((places - lower) / sides.max())[:, sides.argmax()]
    groups.write_weights(obj, "Fine", along**2 * (3 - 2 * along))
    obj.synch.spacing_range = 0.5  # what the group does as a spacing map
    meshes.update(obj)
    return obj


def suzanne(detail):
    """The demo's Suzanne."""
    return add_demo_object(_COARSENESS[detail - 1])


def pretzel(detail):
    """A closed surface with two holes, of quads."""
    cells = [(x, y) for x in range(5) for y in range(3) if (x, y) not in _HOLES]
    faces = []
    for x, y in cells:
        corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
        faces += [[(*corner, 1) for corner in corners], [(*corner, 0) for corner in reversed(corners)]]
        for k, beside in enumerate([(x, y - 1), (x + 1, y), (x, y + 1), (x - 1, y)]):
            a, b = corners[k], corners[(k + 1) % 4]
            if beside not in cells:
                faces.append([(*a, 0), (*b, 0), (*b, 1), (*a, 1)])
    places = sorted({place for face in faces for place in face})
    numbered = [[places.index(place) for place in face] for face in faces]
    points = np.column_stack([plane[k] for plane, k in zip(_PLANES, np.transpose(places), strict=True)])
    rim = np.abs(points[:, 1]) == _PLANES[1][-1]
    points[rim & (np.abs(points[:, 0]) != 2.3), :2] *= _ROUNDING  # the outer corners, and the waist
    return _subdivide_cage("Pretzel", points, numbered, detail)


def vase(detail):
    """A bent vase, open at its rim, of quads."""
    turn = (np.arange(_SEGMENTS)) * 2 * math.pi / _SEGMENTS
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    points = [(*radius * place, height) for radius, height in _PROFILE for place in ring]
    faces = []
    for first in range(0, (len(_PROFILE) - 1) * _SEGMENTS, _SEGMENTS):
        for k in range(_SEGMENTS):
            a, b = first + k, first + (k + 1) % _SEGMENTS
            faces.append((a, b, b + _SEGMENTS, a + _SEGMENTS))
    # The floor: four quads around its middle.
    faces += [(len(points), (k + 2) % _SEGMENTS, k + 1, k) for k in range(0, _SEGMENTS, 2)]
    obj = _subdivide_cage("Vase", _bent(np.array([*points, (0.0, 0.0, 0.0)])), faces, detail)
    ends = attributes.read_all(obj.data.edges, "vertices", 2)
    rim = np.zeros(len(obj.data.vertices))
    rim[ends[_face_counts(obj) == 1]] = 1
    groups.write_weights(obj, "Rim", rim)
    obj.synch.boundary = "PHASE"  # a stripe on the rim
    return obj


_MAKERS = {"SUZANNE": suzanne, "PRETZEL": pretzel, "VASE": vase}


def _bent(points):
    """Points whose heights follow an arc in the plane of X and Z."""
    height = points[:, 2].max()
    radius, angle = height / _BEND, points[:, 2] / height * _BEND
    arm = radius - points[:, 0]
    return np.column_stack([radius - arm * np.cos(angle), points[:, 1], arm * np.sin(angle)])


def _subdivide_cage(name, points, faces, detail):
    """An object of a cage after Catmull-Clark subdivision, with seams in the plane of X and Z."""
    obj = bpy.data.objects.new(name, new_mesh(name, points, faces))
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    obj.modifiers.new("Subdivision", "SUBSURF").levels = detail
    apply_modifiers(obj)
    obj.data.shade_smooth()
    in_plane = np.abs(attributes.read_values(obj, "position", "POINT")[:, 1]) < 1e-5
    ends = attributes.read_all(obj.data.edges, "vertices", 2)
    attributes.write_attribute(obj, attributes.MARKS["seams"], "EDGE", "BOOLEAN", in_plane[ends].all(axis=1))
    return obj


def _face_counts(obj):
    """(e,) faces at each edge."""
    return np.bincount(attributes.read_all(obj.data.loops, "edge_index"), minlength=len(obj.data.edges))
