# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of solids with a wedge cut off: the guiding function, or layers and their dislocation curves."""

import bpy
import numpy as np

from synch_fields.core.extract.layers.defect_curves import defect_curves
from synch_fields.docs.make.sheets import beside as side_by_side
from synch_fields.docs.make.solid_cuts import boundary, cut_away, lowest
from synch_fields.synch_addon.blender.new_geometry import add_spline
from synch_fields.synch_addon.looks.render import render_picture
from synch_fields.synch_addon.nodes.canvas import surface_material
from synch_fields.synch_addon.nodes.stripes import WARM_IVORY

# For each shape: azimuths of the two planes' normals between which a wedge is cut off (None: it stays whole), where
# their common line is (as shares of the box, seen from above), where the solid is looked at from, and the power of the
# function that is shown: between surfaces of different size it is near 0 nearly all over.
VIEWS = {
    "ring": ((-62, 28), (0.5, 0.5), (-32, 33), 1),
    "bunny": ((-60, 30), (0.52, 0.5), (-24, 12), 1 / 3),
    "wedge": ((0, 90), (0.45, 0.45), (25, 24), 1),
    "tetrahedron": (None, None, (-22, 16), 1),
}
RESOLUTION, SAMPLES = (560, 464), 16
BLUE, ROSE = (0.035, 0.16, 0.52, 1), (0.62, 0.06, 0.17, 1)
DARK = (0.012, 0.014, 0.02, 1)
GRADIENT = [(0.0, (0.012, 0.045, 0.16, 1)), (0.45, (0.03, 0.27, 0.32, 1)), (1.0, (0.88, 0.66, 0.3, 1))]
# Radius of the tubes around curves, in diagonals of the box.
TUBE = 0.004
# How deep the joints between printed layers look, over the distance between two.
BEAD = 0.12


def picture_of_layers(name, pattern, is_sdp, path, curves=True, resolution=RESOLUTION):
    """Layers, dark where the phase is near a multiple of 2 pi, and dislocation curves, also where the wedge was."""
    _start()
    mesh = pattern.mesh
    surface = (cut_away(mesh, _wedge(name, mesh)) if VIEWS[name][0] else boundary(mesh)).refined(pattern.tet_phases)
    obj = _add_surface(surface, surface.values(pattern.tet_phases), _stripes(ROSE if is_sdp else BLUE))
    if curves:
        _add_tubes(obj, defect_curves(mesh, pattern.face_numbers), TUBE * np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    return _render(name, obj, path, resolution)


def picture_of_print(name, pattern, share, path):
    """The solid up to a share of its height along the growth: layers by turns light and coloured, rounded as beads."""
    _start()
    surface = lowest(pattern.mesh, pattern.heights, share) if share < 1 else boundary(pattern.mesh)
    surface = surface.refined(pattern.tet_phases)
    obj = _add_surface(surface, surface.values(pattern.tet_phases), _stripes(ROSE, BEAD * pattern.spacings.mean))
    # Points alone are not seen, but the picture leaves room for them: those of all shares are of one scale.
    count = len(obj.data.vertices)
    obj.data.vertices.add(pattern.mesh.vertex_count)
    for place, vertex in enumerate(pattern.mesh.vertices, start=count):
        obj.data.vertices[place].co = vertex
    return _render(name, obj, path)


def picture_of_function(name, mesh, function, path):
    """A function from 0 to 1 on the solid, from dark to light."""
    _start()
    surface = cut_away(mesh, _wedge(name, mesh))
    values = np.einsum("kci,ki->kc", surface.weights, function[mesh.tets[surface.tets]] ** VIEWS[name][3])
    return _render(name, _add_surface(surface, values, material_of_values("Function", GRADIENT, (0, 1))), path)


def beside(rows, path):
    """One picture of rows of pictures."""
    lines = []
    for k, pictures in enumerate(rows):
        lines.append(pictures[0].with_name(f"row {k}.png"))
        side_by_side(pictures, lines[-1])
    side_by_side(lines, path, vertical=True)


def _start():
    bpy.ops.wm.read_homefile(use_empty=True)


def _render(name, obj, path, resolution=RESOLUTION):
    return render_picture(obj, path, resolution=resolution, samples=SAMPLES, markers=False, view=VIEWS[name][2])


def _wedge(name, mesh):
    azimuths, place = VIEWS[name][:2]
    low, size = mesh.vertices.min(axis=0), np.ptp(mesh.vertices, axis=0)
    middle = low + size * [*place, 0]
    # Azimuth 0 looks from the front, along +y: outwards is -y.
    turns = np.radians(azimuths)
    normals = np.column_stack([np.sin(turns), -np.cos(turns), 0 * turns])
    return [(normal, normal @ middle) for normal in normals]


def _add_surface(surface, values, material):
    """A mesh object with the values as corner attribute, smooth but for edges."""
    points = surface.points.reshape(-1, 3)
    scale = np.ptp(points, axis=0).max()
    _, first, corners = np.unique(np.rint(points / scale * 1e6), axis=0, return_index=True, return_inverse=True)
    corners = corners.reshape(-1, 3)
    whole = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    mesh = bpy.data.meshes.new("Solid")
    mesh.from_pydata(points[first].tolist(), [], corners[whole].tolist())
    mesh.attributes.new("value", "FLOAT", "CORNER").data.foreach_set("value", values[whole].astype(np.float32).ravel())
    mesh.shade_smooth()
    mesh.set_sharp_from_angle(angle=np.radians(40))
    mesh.materials.append(material)
    obj = bpy.data.objects.new("Solid", mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def _add_tubes(obj, curves, radius):
    """Join tubes around the curves to the object."""
    data = bpy.data.curves.new("Dislocations", "CURVE")
    data.dimensions, data.bevel_depth, data.bevel_resolution, data.use_fill_caps = "3D", radius, 4, True
    for curve in curves:
        add_spline(data, curve.smooth_points, is_closed=curve.is_closed)
    data.materials.append(plain_material("Dislocations", DARK)[0])
    tubes = bpy.data.objects.new("Dislocations", data)
    bpy.context.scene.collection.objects.link(tubes)
    mesh = bpy.data.meshes.new_from_object(tubes.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    mesh.shade_smooth()
    joined = bpy.data.objects.new("Tubes", mesh)
    bpy.context.scene.collection.objects.link(joined)
    bpy.data.objects.remove(tubes)
    if len(mesh.polygons):
        with bpy.context.temp_override(active_object=obj, selected_editable_objects=[obj, joined]):
            bpy.ops.object.join()


def plain_material(name, color=WARM_IVORY):
    """A smooth material of a colour, its node tree and its surface."""
    material, surface, _ = surface_material(name)
    surface.inputs["Base Color"].default_value = color
    surface.inputs["Roughness"].default_value = 0.45
    return material, material.node_tree, surface


def _stripes(color, bead=0):
    """Stripes of the attribute "value", twice in a turn rounded as beads of some height."""
    material, tree, surface = plain_material("Layers")
    value = tree.nodes.new("ShaderNodeAttribute")
    value.attribute_name = "value"
    wave = tree.nodes.new("ShaderNodeMath")
    wave.operation = "COSINE"
    tree.links.new(value.outputs["Fac"], wave.inputs[0])
    if bead:
        bump = tree.nodes.new("ShaderNodeBump")
        bump.inputs["Distance"].default_value = bead
        depth = tree.nodes.new("ShaderNodeMath")
        depth.operation = "ABSOLUTE"
        tree.links.new(wave.outputs[0], depth.inputs[0])
        tree.links.new(depth.outputs[0], bump.inputs["Height"])
        tree.links.new(bump.outputs["Normal"], surface.inputs["Normal"])
    _ramp(tree, wave.outputs[0], surface, [(0.0, WARM_IVORY), (0.49, WARM_IVORY), (0.53, color), (1.0, color)], (-1, 1))
    return material


def material_of_values(name, stops, bounds):
    """A material in colours between stops of the attribute "value", which lies within bounds."""
    material, tree, surface = plain_material(name)
    value = tree.nodes.new("ShaderNodeAttribute")
    value.attribute_name = "value"
    _ramp(tree, value.outputs["Fac"], surface, stops, bounds)
    return material


def _ramp(tree, socket, surface, stops, bounds):
    """Colours between stops of a value that lies within bounds."""
    share = tree.nodes.new("ShaderNodeMapRange")
    share.inputs["From Min"].default_value, share.inputs["From Max"].default_value = bounds
    tree.links.new(socket, share.inputs["Value"])
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    elements = ramp.color_ramp.elements
    while len(elements) < len(stops):
        elements.new(0.5)
    for element, (place, color) in zip(elements, stops, strict=True):
        element.position, element.color = place, color
    tree.links.new(share.outputs["Result"], ramp.inputs["Fac"])
    tree.links.new(ramp.outputs["Color"], surface.inputs["Base Color"])
