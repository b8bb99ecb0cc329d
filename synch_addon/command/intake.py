# SPDX-License-Identifier: GPL-3.0-or-later
"""Repairs meshes of solids that come from files: overlapping bodies, corners that do not quite meet, missing triangles.

Also turns their upward axis. Objects of a scene are not repaired. What was done is returned as lines for the user.
"""

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree

from ...core.geometry.check import FLAT_FACE
from ..blender.new_geometry import fill_mesh, new_mesh
from ..blender.transaction import only_for_now

# Corners on rims that are nearer to each other than this share of the diagonal are one; holes are closed whose rim is
# shorter than this share of it, or has so few edges. Edges shorter than _FLAT of it make triangles without area.
_CRACK, _HOLE, _EDGES, _FLAT = 1e-4, 0.1, 4, 1e-7
UPS = ("X", "Y", "Z", "-X", "-Y", "-Z")


def turn_up(obj, axis, is_turned=False):
    """Turn the mesh of an object so that an axis of its file, such as "-Y", points up, along the object's Z.

    ``is_turned``: whether the importer has brought the file's Y to Z in the mesh, as Blender's does for .glb.
    """
    way = Vector([float(letter == axis[-1]) for letter in "XYZ"]) * (-1 if axis[0] == "-" else 1)
    if is_turned:
        way = Vector((way.x, -way.z, way.y))
        obj.data.transform(obj.matrix_world)
        if obj.matrix_world.is_negative:
            obj.data.flip_normals()
    obj.matrix_world = Matrix()
    obj.data.transform(way.rotation_difference(Vector((0, 0, 1))).to_matrix().to_4x4())
    obj.data.update()


def mend(obj):
    """Close the mesh of an object where little is missing; returns lines that say what was done."""
    made = bmesh.new()
    made.from_mesh(obj.data)
    lines = [*_dissolve_flat(made), *_close_rims(made)]
    parts = _bodies(made) if made.faces else []
    if lines:
        made.to_mesh(obj.data)
        obj.data.update()
    meeting = _meeting_bodies(made, parts)
    if len(meeting):
        faces = _unite(obj, parts, meeting)
        lines.append(f"{len(meeting)} bodies that touch or overlap are one: {faces} triangles")
    made.free()
    return lines


def _dissolve_flat(made):
    """Take out triangles without area."""
    flat = sum(face.calc_area() <= FLAT_FACE * max(e.calc_length() for e in face.edges) ** 2 for face in made.faces)
    if not flat:
        return []
    diagonal = float(np.linalg.norm(np.ptp([vertex.co for vertex in made.verts], axis=0)))
    bmesh.ops.dissolve_degenerate(made, dist=_FLAT * diagonal, edges=made.edges[:])
    bmesh.ops.triangulate(made, faces=made.faces[:])
    return [f"{flat} triangles without area are taken out"]


def _rims(made):
    return [edge for edge in made.edges if edge.is_boundary]


def _close_rims(made):
    """Join corners on rims and close small holes."""
    lines, rims = [], _rims(made)
    if not rims:
        return lines
    places = np.array([vertex.co for vertex in made.verts])
    diagonal = float(np.linalg.norm(np.ptp(places, axis=0)))
    before = len(made.verts)
    corners = list(dict.fromkeys(vertex for edge in rims for vertex in edge.verts))
    bmesh.ops.remove_doubles(made, verts=corners, dist=_CRACK * diagonal)
    if len(made.verts) < before:
        lines.append(f"{before - len(made.verts)} corners that did not quite meet are joined")
    rims = _rims(made)
    small = [edge for loop in _loops(rims) for edge in loop
             if len(loop) <= _EDGES or sum(one.calc_length() for one in loop) < _HOLE * diagonal]  # fmt: skip
    if small:
        faces = bmesh.ops.holes_fill(made, edges=small, sides=0)["faces"]
        bmesh.ops.recalc_face_normals(made, faces=made.faces[:])
        lines.append(f"{len(faces)} small holes are closed")
    return lines


def _loops(edges):
    """Connected edges, in lists."""
    return _connected(edges, lambda edge: (one for vertex in edge.verts for one in vertex.link_edges))


def _bodies(made):
    """Faces of each body, in lists."""
    return _connected(made.faces, lambda face: (one for edge in face.edges for one in edge.link_faces))


def _connected(items, neighbours):
    """Connected components of items, in lists, whose order depends on that of the items alone.

    ``neighbours`` gives the items beside one.
    """
    left, components = set(items), []
    for first in items:
        if first not in left:
            continue
        left.remove(first)
        component, waiting = [], [first]
        while waiting:
            item = waiting.pop()
            component.append(item)
            for beside in neighbours(item):
                if beside in left:
                    left.remove(beside)
                    waiting.append(beside)
        components.append(component)
    return components


def _meeting_bodies(made, bodies):
    """Indices of the bodies whose faces touch or cut those of another body."""
    if len(bodies) < 2:
        return np.empty(0, int)
    made.faces.ensure_lookup_table()
    made.faces.index_update()
    owner = np.empty(len(made.faces), int)
    for number, body in enumerate(bodies):
        owner[[face.index for face in body]] = number
    tree = BVHTree.FromBMesh(made, epsilon=1e-6)
    owners = owner[np.array(tree.overlap(tree), int).reshape(-1, 2)]
    return np.unique(owners[owners[:, 0] != owners[:, 1]])


def _unite(obj, bodies, meeting):
    """Replace the bodies with the indices ``meeting`` by their union; returns the object's number of triangles then.

    ``bodies`` are lists of BMesh faces.
    """
    with only_for_now():
        parts = []
        for body in bodies:
            copy = bmesh.new()
            copies = {vertex: copy.verts.new(vertex.co) for face in body for vertex in face.verts}
            for face in body:
                copy.faces.new([copies[vertex] for vertex in face.verts])
            data = new_mesh("Body")
            copy.to_mesh(data)
            copy.free()
            part = bpy.data.objects.new("Body", data)
            bpy.context.scene.collection.objects.link(part)
            parts.append(part)
        first, *others = [parts[number] for number in meeting]
        for other in others:
            modifier = first.modifiers.new("Union", "BOOLEAN")
            modifier.operation, modifier.solver, modifier.object = "UNION", "EXACT", other
        graph = bpy.context.evaluated_depsgraph_get()
        united = bmesh.new()
        united.from_mesh(first.evaluated_get(graph).data)
        for number in np.setdiff1d(np.arange(len(parts)), meeting):
            united.from_mesh(parts[number].data)
        fill_mesh(obj.data, *_in_order(united))
        united.clear()
        united.from_mesh(obj.data)
        bmesh.ops.triangulate(united, faces=united.faces[:])
        united.to_mesh(obj.data)
        faces = len(united.faces)
        united.free()
    obj.data.update()
    return faces


def _in_order(made):
    """Places, corners and sizes of the faces of a BMesh in an order that follows from the places alone: Blender's union
    has another one each time."""
    numbers = {vertex: number for number, vertex in enumerate(sorted(made.verts, key=lambda vertex: vertex.co[:]))}
    faces = [[numbers[vertex] for vertex in face.verts] for face in made.faces]
    starts = [face.index(min(face)) for face in faces]
    faces = sorted(face[start:] + face[:start] for face, start in zip(faces, starts, strict=True))
    return np.array([vertex.co for vertex in numbers]), np.concatenate(faces), list(map(len, faces))
