# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects for the tests, and what a file holds as plain values that can be compared."""

from itertools import product

import bpy
import numpy as np

# foreach_get's name, type and width of every kind of attribute that Blender's meshes have.
LAYOUTS = {
    "FLOAT": ("value", np.float32, 1),
    "INT": ("value", np.int32, 1),
    "INT8": ("value", np.int32, 1),
    "BOOLEAN": ("value", bool, 1),
    "FLOAT_VECTOR": ("vector", np.float32, 3),
    "FLOAT2": ("vector", np.float32, 2),
    "FLOAT_COLOR": ("color", np.float32, 4),
    "BYTE_COLOR": ("color", np.float32, 4),
    "INT32_2D": ("value", np.int32, 2),
    "INT16_2D": ("value", np.int32, 2),
    "QUATERNION": ("value", np.float32, 4),
    "FLOAT4X4": ("value", np.float32, 16),
    "FLOAT4": ("vector", np.float32, 4),
    "STRING": ("value", bytes, 1),
}


def add_object(vertices, faces, name="Object"):
    """A mesh object, active and alone selected."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(v) for v in vertices], [], [tuple(f) for f in faces])
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    return make_active(obj)


def make_active(obj):
    bpy.context.view_layer.update()
    for other in bpy.context.view_layer.objects:
        other.select_set(other == obj)
    bpy.context.view_layer.objects.active = obj
    return obj


def added(name):
    """The object that an operator has just added, with its English name in every language."""
    obj = bpy.context.active_object
    obj.rename(name, mode="NEVER")  # another object with the name keeps it
    return obj


def sphere(subdivisions=3):
    """A unit sphere of triangles: 162 vertices, about four times as many with each subdivision more."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions, radius=1)
    return added("Icosphere")


def torus():
    """A torus of 24 x 12 quads."""
    bpy.ops.mesh.primitive_torus_add(major_segments=24, minor_segments=12, major_radius=1, minor_radius=0.4)
    return added("Torus")


def ring(radii, segments):
    """A flat ring of quads around the origin, with circles of these radii."""
    turn = np.arange(segments) * 2 * np.pi / segments
    vertices = [(r * np.cos(a), r * np.sin(a), 0) for r in radii for a in turn]
    faces = []
    for k, i in product(range(len(radii) - 1), range(segments)):
        here, there = k * segments + i, k * segments + (i + 1) % segments
        faces.append((here, here + segments, there + segments, there))
    return add_object(vertices, faces, "Ring")


def bent(obj):
    """A flat grid, bent and symmetric in X and Y."""
    for vertex in obj.data.vertices:
        x, y, _ = vertex.co
        vertex.co.z = 0.1 * np.cos(2 * x) * np.cos(3 * y * y)
    return obj


def grid(subdivisions=12, size=2.0):
    """A flat square of quads around the origin."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=subdivisions, y_subdivisions=subdivisions, size=size)
    return added("Grid")


def tube(segments=24, rings=9, height=2.0):
    """A cylinder of unit radius around Z, open at both ends; vertices ring by ring from below."""
    turn = np.arange(segments) * 2 * np.pi / segments
    vertices = [(np.cos(a), np.sin(a), z) for z in np.linspace(0, height, rings) for a in turn]
    faces = []
    for ring, k in product(range(rings - 1), range(segments)):
        here, there = ring * segments + k, ring * segments + (k + 1) % segments
        faces.append((here, there, there + segments, here + segments))
    return add_object(vertices, faces, "Tube")


def quad_sphere(cuts=5):
    """A sphere of quads: a cube, subdivided and blown up."""
    bpy.ops.mesh.primitive_cube_add(size=2)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=cuts)
    bpy.ops.object.mode_set(mode="OBJECT")
    obj = bpy.context.active_object
    places = attribute(obj, "position")
    obj.data.vertices.foreach_set("co", (places / np.linalg.norm(places, axis=1)[:, None]).ravel())
    obj.data.update()
    return obj


def hexagon_sphere(subdivisions=3):
    """A sphere of hexagons and twelve pentagons: each vertex of a triangle sphere becomes a face."""
    source = sphere(subdivisions)
    places = attribute(source, "position").astype(float)
    triangles = np.array([p.vertices[:] for p in source.data.polygons])
    centres = places[triangles].mean(axis=1)
    faces = []
    for vertex, normal in enumerate(places):
        around = np.flatnonzero((triangles == vertex).any(axis=1))
        first = centres[around[0]] - normal
        x = first - normal * (first @ normal)
        y = np.cross(normal, x)
        offsets = centres[around] - normal
        faces.append(around[np.argsort(np.arctan2(offsets @ y, offsets @ x))])
    bpy.data.objects.remove(source)
    return add_object(centres, faces, "Hexagons")


def furnished():
    """An object with much that a run could disturb: materials, groups, UVs, properties, a shared mesh."""
    obj = hexagon_sphere()
    for name in ("Red", "Green"):
        obj.data.materials.append(bpy.data.materials.new(name))
    obj.data.polygons.foreach_set("material_index", np.arange(len(obj.data.polygons)) % 2)
    obj.active_material_index = 1
    obj.data.uv_layers.new(name="Mine")
    add_group(obj, "some", range(10))
    obj["mine"] = 3.0
    twin = bpy.data.objects.new("Twin", obj.data)
    bpy.context.scene.collection.objects.link(twin)
    child = bpy.data.objects.new("Mine too", None)
    child.parent = obj
    bpy.context.scene.collection.objects.link(child)
    return make_active(obj)


def attribute(obj, name):
    """An attribute's values, (n,) or (n, width)."""
    return _values(obj.data.attributes[name])


def _values(found):
    value_name, dtype, width = LAYOUTS[found.data_type]
    if found.data_type == "STRING":  # which Blender gives one by one
        return np.array([element.value for element in found.data])
    values = np.empty(len(found.data) * width, dtype)
    found.data.foreach_get(value_name, values)
    return values.reshape(-1, width) if width > 1 else values


def add_attribute(mesh, name, data_type, domain, seed=0):
    """Add an attribute of any type with random values; whether this Blender has the type."""
    if data_type not in bpy.types.Attribute.bl_rna.properties["data_type"].enum_items:
        return False
    value_name, dtype, width = LAYOUTS[data_type]
    found, random = mesh.attributes.new(name, data_type, domain), np.random.default_rng(seed)
    if data_type == "STRING":
        for element in found.data:
            element.value = f"text {random.integers(100)}".encode()
        return True
    numbers = random.random(len(found.data) * width)
    found.data.foreach_set(value_name, numbers if dtype == np.float32 else np.rint(numbers).astype(dtype))
    return True


def set_vectors(obj, name, vectors, domain="POINT"):
    """Add a vector attribute."""
    found = obj.data.attributes.new(name, "FLOAT_VECTOR", domain)
    found.data.foreach_set("vector", np.float32(vectors).ravel())


def add_group(obj, name, vertices):
    """Add a vertex group of these vertices."""
    obj.vertex_groups.new(name=name).add([int(v) for v in vertices], 1.0, "REPLACE")


def empties(obj, kind=None):
    """The defect empties of an object."""
    children = [child for child in obj.children if "synch_kind" in child]
    return [child for child in children if kind in (None, child["synch_kind"])]


def snapshot():
    """Everything in the file that an operator could touch, as plain values."""
    bpy.context.view_layer.update()  # places of objects count as they will be seen
    return {
        "meshes": {mesh.name: _mesh(mesh) for mesh in bpy.data.meshes},
        "objects": {obj.name: _object(obj) for obj in bpy.data.objects},
        "collections": {c.name: _collection(c) for c in bpy.data.collections},
        "scene": _collection(bpy.context.scene.collection),
        "materials": sorted(m.name for m in bpy.data.materials),
        "node groups": sorted(g.name for g in bpy.data.node_groups),
        "active": getattr(bpy.context.view_layer.objects.active, "name", None),
        "mode": bpy.context.mode,
    }


def datablocks():
    """Kind, name and number of users of all that the file holds."""
    lists = (p.identifier for p in bpy.data.bl_rna.properties if p.type == "COLLECTION")
    return sorted((name, block.name, block.users) for name in lists for block in getattr(bpy.data, name))


def _mesh(mesh):
    attributes = {a.name: (a.domain, a.data_type, _values(a).tobytes()) for a in mesh.attributes}
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    sizes = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_total", sizes)
    materials = [m and m.name for m in mesh.materials]
    return {**attributes, "corners": corners.tobytes(), "sizes": sizes.tobytes(), "materials": materials}


def _object(obj):
    return {
        "matrix": np.array(obj.matrix_world).round(6).tolist(),
        "parent": obj.parent and obj.parent.name,
        "data": obj.data and obj.data.name,
        "mode": obj.mode,
        "selected": obj.select_get(),
        "slots": [(slot.link, slot.material and slot.material.name) for slot in obj.material_slots],
        "active slot": obj.active_material_index,
        "modifiers": [modifier.name for modifier in obj.modifiers],
        "groups": [group.name for group in obj.vertex_groups],
        "properties": {
            key: str(getattr(value, "name", value)) for key, value in obj.items() if not key.startswith("synch")
        },
    }


def _collection(collection):
    return sorted(o.name for o in collection.objects), sorted(c.name for c in collection.children)


def written(obj):
    """Domain and type of every attribute of ours."""
    return {a.name: (a.domain, a.data_type) for a in obj.data.attributes if a.name.startswith("synch_")}


def save_and_reopen(path, name):
    """Write the file, open it again and return the object of this name."""
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return bpy.data.objects[name]


def panel(size, faces, corner=(0.0, 0.0)):
    """A flat rectangle of quads from a corner on, row by row; size and faces in x and y."""
    x, y = (np.linspace(0, length, count + 1) + start for length, count, start in zip(size, faces, corner, strict=True))
    vertices = [(a, b, 0) for b in y for a in x]
    width = faces[0] + 1
    corners = [j * width + i for j in range(faces[1]) for i in range(faces[0])]
    return add_object(vertices, [(k, k + 1, k + 1 + width, k + width) for k in corners], "Panel")


def mark_edges(obj, mark, vertices):
    """Mark edges with both ends in a mask as "seams", "sharp" or "creases"."""
    ends = np.array([edge.vertices[:] for edge in obj.data.edges])
    marked = vertices[ends].all(axis=1)
    name, data_type = {"seams": ("uv_seam", "BOOLEAN"), "sharp": ("sharp_edge", "BOOLEAN")}.get(
        mark, ("crease_edge", "FLOAT")
    )
    found = obj.data.attributes.get(name) or obj.data.attributes.new(name, data_type, "EDGE")
    found.data.foreach_set("value", marked.astype(bool if data_type == "BOOLEAN" else np.float32))


def add_curve(points, name="Curve", cyclic=False):
    """A curve object of straight pieces; the active object stays active."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    spline = data.splines.new("POLY")
    spline.points.add(len(points) - 1)
    spline.points.foreach_set("co", np.column_stack([points, np.ones(len(points))]).astype(np.float32).ravel())
    spline.use_cyclic_u = cyclic
    return _linked(name, data)


def add_drawing(points, name="Drawing"):
    """A Grease Pencil object with one stroke."""
    kinds = bpy.data.grease_pencils if bpy.app.version >= (5, 0) else bpy.data.grease_pencils_v3
    data = kinds.new(name)
    drawing = data.layers.new("Lines").frames.new(1).drawing
    drawing.add_strokes([len(points)])
    for point, place in zip(drawing.strokes[0].points, points, strict=True):
        point.position = place
    return _linked(name, data)


def add_wire(points, name="Wire"):
    """A mesh object of edges alone."""
    data = bpy.data.meshes.new(name)
    data.from_pydata([tuple(p) for p in points], [(k, k + 1) for k in range(len(points) - 1)], [])
    return _linked(name, data)


def _linked(name, data):
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return obj


def set_numbers(obj, name, numbers):
    """Add a float attribute on the vertices."""
    obj.data.attributes.new(name, "FLOAT", "POINT").data.foreach_set("value", np.float32(numbers))


def places(obj):
    return attribute(obj, "position").astype(float)


def directions(obj):
    return attribute(obj, "synch_direction").astype(float)
