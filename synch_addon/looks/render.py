# SPDX-License-Identifier: GPL-3.0-or-later
"""A product picture of one object: backdrop, soft light, a camera that fits any shape.

Everything is made in a scene of its own and removed afterwards; the file stays as it was.
"""

import math
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler, Matrix, Vector

from ...core.errors import MeshError, SettingError
from ...core.files.whole import is_whole_image, write_whole
from ..blender.attributes import read_all
from ..blender.defect_empties import KINDS, defect_empties
from ..blender.files import written_by_operator
from ..blender.new_geometry import new_mesh
from ..blender.transaction import only_for_now
from ..nodes.canvas import find_node, surface_material
from ..nodes.stripes import INK_BLUE, WARM_IVORY

# Part of the picture that stays free at each edge.
_MARGIN = 0.07
_LENS, _SENSOR = 70.0, 36.0
_FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".exr": "OPEN_EXR", ".tif": "TIFF", ".webp": "WEBP"}
_WITH_FACES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
# Radius of a marker by the size of its empty: small enough to leave the branching stripes in view.
_MARKER_SIZE = {"disclination": 0.75, "dislocation": 0.45, "vortex": 0.75}
_BACKDROP_COLOR = (0.72, 0.71, 0.695, 1.0)
# Direction from the object (right, up, towards the camera), size and distance in radii of the
# object, watts for a radius of 1, colour.
_LIGHTS = {
    "key": ((-0.8, 1.0, 0.7), 2.2, 4.2, 330.0, (1.0, 0.965, 0.92)),
    "fill": ((1.0, 0.25, 0.55), 3.6, 4.6, 50.0, (0.88, 0.94, 1.0)),
    "rim": ((0.6, 0.8, -0.9), 2.0, 4.4, 200.0, (1.0, 0.98, 0.95)),
}
_WORLD_STRENGTH = 0.22
# Thickness of drawn edges, in mean edges.
_EDGE_THICKNESS = 0.14


def render_picture(
    obj, path, *, resolution=(1200, 900), samples=12, markers=True, edges=False, view=(-25.0, 14.0)
) -> Path:
    """Render `obj`, as its modifiers and materials show it, to the image file `path`.

    `resolution` is in pixels, `samples` per pixel (denoised where Blender can: 12 differ by 44 dB from
    128, 32 by 47 dB in twice the time); `markers` puts a small coloured shape at every defect empty of
    the object, `edges` a rod along every edge. `view` is the direction to look from, in degrees:
    azimuth 0 is Blender's front view and grows to the right, elevation 90 the top view. Returns the
    path. Raises SettingError where the file cannot be written, MeshError for an object without faces.
    """
    path = Path(path).absolute()
    if path.suffix.lower() not in _FORMATS:
        raise SettingError(f"cannot write a picture to {path.name}: use one of {', '.join(_FORMATS)}")
    with only_for_now():
        scene, _ = picture_scene(obj, resolution=resolution, markers=markers, edges=edges, view=view)
        render_scene(scene, path, resolution, samples)
    return path


def picture_scene(obj, *, resolution, markers, edges, view):
    """Make the scene of a picture: backdrop, lights, a camera that fits, and a copy of `obj` that shares its mesh.

    Arguments as of :func:`render_picture`. Returns the scene and the copy. Raises MeshError for an object without
    faces. Called inside :func:`only_for_now`, which removes the scene again.
    """
    scene = bpy.data.scenes.new("Synch Picture")
    scene.frame_set(bpy.context.scene.frame_current)
    shown = stand_in(obj, scene, edges)
    matrix, points = _evaluate(shown, scene)
    extent = _add_markers(defect_empties(obj), shown, matrix, points, scene) if markers else points
    orientation = _orientation(view)
    camera = _add_camera(scene, orientation, extent, resolution)
    stage = _stage(orientation)
    _add_backdrop(scene, stage, points, camera.matrix_world.translation)
    _add_lights(scene, stage, points)
    return scene, shown


def render_scene(scene, path, resolution, samples):
    """Render a picture's scene to an image file; arguments and errors as of :func:`render_picture`."""
    with write_whole(path, is_whole_image) as made:
        _set_up_render(scene, made, resolution, samples)
        with written_by_operator(path):
            bpy.ops.render.render(write_still=True, scene=scene.name)


def stand_in(obj, scene, edges):
    """Link a visible copy of an object into a picture's scene, with a rod along every edge if `edges` asks for it."""
    copy = obj.copy()
    copy.hide_render = copy.hide_viewport = False
    scene.collection.objects.link(copy)
    if edges:
        _draw_edges(copy)
    return copy


def _draw_edges(obj):
    """Rods along the edges of a mesh object that may be changed, smoothly shaded."""
    mesh = obj.data = obj.data.copy()
    mesh.shade_smooth()
    if not any(mesh.materials):
        mesh.materials.clear()
        mesh.materials.append(_matte("Synch Faces", WARM_IVORY))
    rods = obj.modifiers.new("Synch Edges", "WIREFRAME")
    rods.use_replace, rods.use_even_offset, rods.material_offset = False, False, len(mesh.materials)
    for _ in range(rods.material_offset):
        mesh.materials.append(_matte("Synch Edges", INK_BLUE))
    tails, heads = _positions(mesh)[read_all(mesh.edges, "vertices", 2).T]
    rods.thickness = _EDGE_THICKNESS * np.linalg.norm(heads - tails, axis=1).mean()


def _evaluate(obj, scene):
    """Matrix and vertices, in world space, of an object as its modifiers, parents ... make it."""
    with bpy.context.temp_override(scene=scene, view_layer=scene.view_layers[0]):
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh() if obj.type in _WITH_FACES else None
    if mesh is None or not mesh.polygons:
        raise MeshError(f"{obj.name} has no faces to render")
    points = _positions(mesh)
    evaluated.to_mesh_clear()
    matrix = evaluated.matrix_world.copy()
    linear, offset = np.array(matrix)[:3, :3], np.array(matrix)[:3, 3]
    return matrix, points @ linear.T + offset


def _positions(mesh):
    return read_all(mesh.attributes["position"].data, "vector", 3, np.float32)


def _centre_and_radius(points):
    centre = (points.min(axis=0) + points.max(axis=0)) / 2.0
    return centre, max(float(np.linalg.norm(points - centre, axis=1).max()), 1e-6)


def _orientation(view):
    azimuth, elevation = (math.radians(angle) for angle in view)
    return Euler((math.pi / 2.0 - elevation, 0.0, azimuth)).to_matrix()


def _add(scene, name, data, matrix):
    obj = bpy.data.objects.new(name, data)
    obj.matrix_world = matrix
    scene.collection.objects.link(obj)
    return obj


def _add_camera(scene, orientation, points, resolution):
    """The camera of this orientation that is as close as it can be with all points in the picture."""
    data = bpy.data.cameras.new("Synch Camera")
    data.lens, data.sensor_width = _LENS, _SENSOR
    place, nearest, farthest = _fit(points @ np.array(orientation), _half_angles(resolution))
    data.clip_start, data.clip_end = nearest * 0.2, farthest * 20.0
    matrix = Matrix.Translation(orientation @ Vector(place)) @ orientation.to_4x4()
    scene.camera = _add(scene, "Synch Camera", data, matrix)
    return scene.camera


def _half_angles(resolution):
    """Tangents of half the horizontal and vertical angle that the subject may fill."""
    usable = _SENSOR / _LENS / 2.0 * (1.0 - 2.0 * _MARGIN)
    return tuple(usable * size / max(resolution) for size in resolution)


def _fit(points, tangents):
    """Where a camera that looks along -Z must stand; least and greatest depth of the points.

    A point is in the picture when |x - x0| <= t (d - d0) for both axes, d = -z: two bounds on
    x0 - t d0 and x0 + t d0, which are linear, so that the nearest place is found exactly.
    """
    depth = -points[:, 2]
    low = [np.max(points[:, axis] - tangents[axis] * depth) for axis in (0, 1)]
    high = [np.min(points[:, axis] + tangents[axis] * depth) for axis in (0, 1)]
    size = _centre_and_radius(points)[1]
    start = min((high[axis] - low[axis]) / (2.0 * tangents[axis]) for axis in (0, 1))
    start = min(start, depth.min() - 1e-3 * size)
    place = ((low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0, -start)
    return place, float(depth.min() - start), float(depth.max() - start)


def _stage(orientation):
    """Directions of the set as columns: to the right, up, and level towards the camera.

    A look from below gets the set upside down: a floor would hide the object.
    """
    right, vertical = orientation.col[0], Vector((0.0, 0.0, 1.0))
    up = vertical if orientation.col[2].z >= 0.0 else -vertical
    return Matrix((right, up, right.cross(vertical))).transposed()


def _add_backdrop(scene, stage, points, camera_place):
    """A floor under the object that rises in a wide curve behind it, without a visible horizon."""
    centre, radius = _centre_and_radius(points)
    distance = (Vector(centre) - camera_place).length
    width = 3.0 * distance + 20.0 * radius
    profile = _backdrop_profile(radius, distance)
    vertices = [(side * width, height, toward) for toward, height in profile for side in (-1.0, 1.0)]
    faces = [(2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2) for k in range(len(profile) - 1)]
    mesh = new_mesh("Synch Backdrop", vertices, faces, smooth=True)
    mesh.materials.append(_matte("Synch Backdrop", _BACKDROP_COLOR))
    up = np.array(stage.col[1])
    # A floor exactly at the lowest vertices would flicker under a flat object.
    foot = centre + up * ((points @ up).min() - centre @ up - 1e-4 * radius)
    _add(scene, "Synch Backdrop", mesh, Matrix.Translation(foot) @ stage.to_4x4())


def _backdrop_profile(radius, distance):
    """(towards the camera, up): the floor from behind the camera, the curve, the wall."""
    bend, start = 5.0 * radius, 3.0 * radius
    angles = np.linspace(0.0, math.pi / 2.0, 33)
    curve = [(-start - bend * math.sin(angle), bend * (1.0 - math.cos(angle))) for angle in angles]
    return [(3.0 * distance, 0.0), *curve, (-start - bend, bend + 3.0 * distance)]


def _matte(name, color):
    material, surface, _ = surface_material(name)
    surface.inputs["Base Color"].default_value = color
    surface.inputs["Roughness"].default_value = 1.0
    surface.inputs["Specular IOR Level"].default_value = 0.0
    return material


def _add_lights(scene, stage, points):
    centre, radius = _centre_and_radius(points)
    for name, (direction, size, distance, power, color) in _LIGHTS.items():
        light = bpy.data.lights.new(f"Synch {name}", "AREA")
        light.shape, light.size, light.color = "DISK", size * radius, color
        light.energy = power * radius**2
        away = stage @ Vector(direction).normalized()
        place = Matrix.Translation(Vector(centre) + away * distance * radius)
        _add(scene, f"Synch {name}", light, place @ away.to_track_quat("Z", "Y").to_matrix().to_4x4())
    world = bpy.data.worlds.new("Synch World")
    if world.node_tree is None:
        world.use_nodes = True
    background = find_node(world.node_tree, "ShaderNodeBackground")
    background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    background.inputs["Strength"].default_value = _WORLD_STRENGTH
    scene.world = world


def _add_markers(empties, shown, parent_matrix, points, scene):
    """A small shape at the place that each of the empties has on the object that is shown; returns `points` and those
    that the shapes reach to."""
    _, radius = _centre_and_radius(points)
    meshes = {kind: _marker_mesh(kind) for kind in KINDS}
    scale = sum(abs(factor) for factor in parent_matrix.to_scale()) / 3.0
    ends = [points]
    for empty in _follow(empties, shown, scene):
        matrix = empty.matrix_world
        size = _MARKER_SIZE[empty["synch_kind"]] * empty.empty_display_size * scale
        size = min(max(size, 0.01 * radius), 0.024 * radius)
        rotation = matrix.to_quaternion().to_matrix().to_4x4()
        place = Matrix.Translation(matrix.translation) @ rotation @ Matrix.Scale(size, 4)
        marker = _add(scene, empty.name, meshes[empty["synch_kind"]], place)
        marker.color = empty.color
        ends.append(np.array(matrix.translation) + size * np.vstack([np.eye(3), -np.eye(3)]))
    return np.vstack(ends)


def _follow(empties, shown, scene):
    """Copies of empties that follow the copy of their object in a picture's scene."""
    copies = [empty.copy() for empty in empties]
    for copy, empty in zip(copies, empties, strict=True):
        copy.parent, copy.hide_viewport = shown, False
        copy.matrix_parent_inverse = empty.matrix_parent_inverse  # which another parent resets
        scene.collection.objects.link(copy)
    scene.view_layers[0].update()
    return copies


def _marker_mesh(kind):
    """A diamond for a dislocation, otherwise a ball; radius 1, in the object's color."""
    around, along = (4, 2) if kind == "dislocation" else (32, 16)
    polar = np.linspace(0.0, math.pi, along + 1)[:, None]
    azimuth = np.arange(around) * (2.0 * math.pi / around)
    points = np.stack(
        np.broadcast_arrays(np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)), axis=-1
    )
    corner = np.arange(along * around).reshape(along, around)
    after = np.roll(corner, -1, axis=1)
    faces = np.stack([corner, corner + around, after + around, after], axis=-1)
    mesh = new_mesh(f"Synch {kind}", points, faces.reshape(-1, 4), smooth=kind != "dislocation")
    mesh.materials.append(_marker_material())
    return mesh


def _marker_material():
    material, surface, _ = surface_material("Synch Marker")
    info = material.node_tree.nodes.new("ShaderNodeObjectInfo")
    for name in ("Base Color", "Emission Color"):
        material.node_tree.links.new(info.outputs["Color"], surface.inputs[name])
    surface.inputs["Emission Strength"].default_value = 0.15
    surface.inputs["Roughness"].default_value = 0.3
    return material


def _set_up_render(scene, path, resolution, samples):
    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = resolution
    render.resolution_percentage = 100
    render.use_file_extension = render.use_compositing = render.use_sequencer = False
    render.filepath = str(path)
    render.image_settings.file_format = _FORMATS[path.suffix.lower()]
    render.image_settings.color_mode = "RGB"
    scene.view_settings.view_transform = "Khronos PBR Neutral"
    cycles = scene.cycles
    cycles.device, cycles.samples = "CPU", samples
    cycles.use_adaptive_sampling, cycles.adaptive_threshold = True, 0.03
    # The automatic minimum is above the number of samples of most pictures, and nothing would adapt.
    cycles.adaptive_min_samples = 12
    cycles.max_bounces, cycles.caustics_reflective, cycles.caustics_refractive = 6, False, False
    try:
        cycles.denoiser = "OPENIMAGEDENOISE"
        cycles.use_denoising = True
    except TypeError:  # This Blender was built without Open Image Denoise.
        cycles.use_denoising, cycles.samples = False, 4 * samples
