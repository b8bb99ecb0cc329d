# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes made from scenes, and what can be measured on them without the extension."""

import importlib
from collections import Counter
from contextlib import contextmanager
from itertools import pairwise, product

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree

from synch_fields.synch_addon import api

from .scenes import add_object, places, quad_sphere

bmesh = importlib.import_module("bmesh")  # on the path once bpy is loaded, as isort cannot know


@contextmanager
def edited(obj):
    """The object's mesh as a bmesh, written back in the end."""
    mesh = bmesh.new()
    mesh.from_mesh(obj.data)
    yield mesh
    mesh.to_mesh(obj.data)
    mesh.free()


def made_from(obj, **settings):
    """The new object and the report."""
    report = api.quad_mesh(obj, **settings)
    return bpy.data.objects[report["quad_mesh"]["object"]], report


def mixed_sphere(cuts=7):
    """A sphere with triangles above, quads around and hexagons among them below."""
    obj = quad_sphere(cuts)
    with edited(obj) as mesh:
        bmesh.ops.triangulate(mesh, faces=[face for face in mesh.faces if face.calc_center_median().z > 0.4])
        taken, chosen = set(), []
        for edge in mesh.edges:
            around = {vertex for face in edge.link_faces for vertex in face.verts}
            if edge.verts[0].co.z < -0.4 and not taken & around:
                taken |= around
                chosen.append(edge)
        bmesh.ops.dissolve_edges(mesh, edges=chosen, use_verts=False)
    return obj


def poked(obj):
    """The object with a vertex in the middle of each face: its triangles are as symmetric as its faces."""
    with edited(obj) as mesh:
        bmesh.ops.poke(mesh, faces=mesh.faces)
    return obj


def part(obj, chosen):
    """A copy of the object with these faces alone, given as a mask."""
    copy = obj.copy()
    copy.data = obj.data.copy()
    with edited(copy) as mesh:
        others = [face for face, keep in zip(mesh.faces, chosen, strict=True) if not keep]
        bmesh.ops.delete(mesh, geom=others, context="FACES")
    return copy


def cube(cuts=15):
    """A cube from -1 to 1 of quads, and (n,) on how many of its sides each vertex lies."""
    numbers, vertices, faces = {}, [], []

    def number(place):
        if place not in numbers:
            numbers[place] = len(vertices)
            vertices.append(place)
        return numbers[place]

    steps = list(pairwise(np.linspace(-1, 1, cuts + 2)))
    for axis, side, (a0, a1), (b0, b1) in product(range(3), (-1.0, 1.0), steps, steps):
        corners = [(a0, b0), (a1, b0), (a1, b1), (a0, b1)][:: int(side)]
        faces.append([number(tuple(np.roll((side, a, b), axis).tolist())) for a, b in corners])
    obj = add_object(vertices, faces, "Cube")
    return obj, (np.abs(places(obj)) > 1 - 1e-6).sum(axis=1)


def mark_sharp(obj, chosen):
    """Mark edges as sharp, and no others."""
    obj.data.attributes.new("sharp_edge", "BOOLEAN", "EDGE").data.foreach_set("value", chosen)


def ends(obj):
    """(e, 2) vertices of the edges."""
    return np.array([edge.vertices[:] for edge in obj.data.edges])


def corner_vertices(obj):
    """(c,) vertex of each corner."""
    found = np.empty(len(obj.data.loops), np.int32)
    obj.data.loops.foreach_get("vertex_index", found)
    return found


def in_world(obj):
    """(n, 3) places of the vertices in the world."""
    bpy.context.view_layer.update()
    matrix = np.array(obj.matrix_world)
    return places(obj) @ matrix[:3, :3].T + matrix[:3, 3]


def surface(obj):
    """A tree of the object's triangles in its own space, and the triangles' normals."""
    obj.data.calc_loop_triangles()
    triangles = np.array([t.vertices[:] for t in obj.data.loop_triangles])
    corners = places(obj)[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    tree = BVHTree.FromPolygons(places(obj).tolist(), triangles.tolist())
    return tree, normals / np.linalg.norm(normals, axis=1)[:, None]


def distances(tree, points):
    """(k,) distances of points from a surface."""
    return np.array([tree.find_nearest(point)[3] for point in np.asarray(points).tolist()])


def half_edges(obj):
    """How often each pair of vertices follows another on a face's rim."""
    found = Counter()
    for polygon in obj.data.polygons:
        rim = polygon.vertices[:]
        found.update(zip(rim, (*rim[1:], rim[0]), strict=True))
    return found


def is_manifold(obj):
    """Whether every edge has one face, or two in opposite directions, and every vertex one fan of faces."""
    with edited(obj) as mesh:
        one_fan = all(vertex.is_manifold for vertex in mesh.verts)
    return set(half_edges(obj).values()) == {1} and one_fan


def euler_characteristic(obj):
    """Of the vertices that have a face."""
    return len(np.unique(corner_vertices(obj))) - len(obj.data.edges) + len(obj.data.polygons)


def is_closed(obj):
    around = half_edges(obj)
    return all((b, a) in around for a, b in around)
