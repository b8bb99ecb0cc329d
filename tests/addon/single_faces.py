# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Single faces with the attributes of a phase: their formulas, and what a shader shows of them.

The formulas are evaluated point by point, which shares nothing with the node groups.
"""

import bpy
import numpy as np

from synch_fields.synch_addon.blender.defect_empties import DefectEmpty
from synch_fields.synch_addon.nodes import stripes
from synch_fields.synch_addon.nodes.canvas import surface_material

PIXELS = 96
VIEW_WIDTH = 2.0
THIRD = np.pi / 3.0
TRIANGLE = [(-0.85, -0.7), (0.9, -0.5), (-0.1, 0.8)]
CONVEX_QUAD = [(-0.8, -0.75), (0.9, -0.5), (0.6, 0.85), (-0.7, 0.4)]
DART = [(-0.85, -0.85), (0.05, -0.3), (0.85, -0.8), (0.1, 0.9)]


def ell(b_p, b_q, b_r):
    """lArg of Knöppel et al. 2015."""
    if b_r <= min(b_p, b_q):
        return THIRD * (1 + (b_q - b_p) / (1 - 3 * b_r))
    if b_p <= min(b_q, b_r):
        return THIRD * (3 + (b_r - b_q) / (1 - 3 * b_p))
    return THIRD * (5 + (b_p - b_r) / (1 - 3 * b_q))


def triangle_disclination(b, x):
    if b[2] <= min(b[0], b[1]):
        return (b[0] - b[2]) * x[0] + (b[1] - b[2]) * x[1]
    if b[0] <= min(b[1], b[2]):
        return (b[1] - b[0]) * x[1] + (b[2] - b[0]) * x[2]
    return (b[2] - b[1]) * x[2] - (b[0] - b[1]) * x[0]


def quad_disclination(b_a, b_b, b_c, b_d, first, x):
    u = b_a - b_c
    turn = (x[0] * u if first else -x[0] * u) if u > 0 else -x[2] * u
    return turn + x[1] * b_b + x[3] * b_d


def barycentric(point, corners):
    matrix = np.vstack([np.array(corners).T, np.ones(3)])
    return np.linalg.solve(matrix, [*point, 1.0])


class Face:
    """One planar face with the attributes of a phase, and its theta at a point."""

    def __init__(self, corners, phases, numbers=(0, 0), disclination=(0, 0, 0, 0), start=0):
        self.corners, self.phases = corners, np.asarray(phases, float)
        self.numbers, self.disclination, self.start = numbers, disclination, start

    def theta(self, point):
        """(theta, least weight, 1 - 3 * least weight) at a point; None outside the face."""
        if len(self.corners) == 3:
            triangles = [(0, 1, 2)]
        else:
            a, b, c, d = ((self.start + k) % 4 for k in range(4))
            triangles = [(a, b, c), (c, d, a)]
        for which, triangle in enumerate(triangles):
            b = barycentric(point, [self.corners[k] for k in triangle])
            if b.min() < 0:
                continue
            theta = b @ self.phases[list(triangle)]
            turn = ell(*b)
            if len(self.corners) == 4:
                turn += THIRD * b[1] + 2 * THIRD * b[2]
            theta += self.numbers[which] * turn + self._disclination(b, which)
            return theta, b.min(), 1 - 3 * b.min()
        return None

    def _disclination(self, b, which):
        if len(self.corners) == 3:
            return triangle_disclination(b, self.disclination)
        if which == 0:
            return quad_disclination(b[0], b[1], b[2], 0.0, True, self.disclination)
        return quad_disclination(b[2], 0.0, b[0], b[1], False, self.disclination)

    def build(self):
        """The object in Blender, with the attributes that the shader reads."""
        mesh = bpy.data.meshes.new("face")
        mesh.from_pydata([(x, y, 0) for x, y in self.corners], [], [range(len(self.corners))])
        corner = mesh.attributes.new("synch_phase", "FLOAT", "CORNER")
        corner.data.foreach_set("value", np.float32(self.phases))
        place = mesh.attributes.new("synch_barycentric", "FLOAT_VECTOR", "CORNER")
        place.data.foreach_set("vector", np.float32(self._places()).ravel())
        mesh.attributes.new("synch_index", "INT", "FACE").data[0].value = self.numbers[0]
        if self.numbers[1]:
            mesh.attributes.new("synch_index_2", "INT", "FACE").data[0].value = self.numbers[1]
        if any(self.disclination):
            values = mesh.attributes.new("synch_disclination", "FLOAT_COLOR", "FACE")
            # Setting one item would clamp negative values to zero.
            values.data.foreach_set("color", np.float32(self.disclination))
        obj = bpy.data.objects.new("face", mesh)
        bpy.context.scene.collection.objects.link(obj)
        return obj

    def _places(self):
        if not any(self.numbers) and not any(self.disclination):
            return np.zeros((len(self.corners), 3))
        if len(self.corners) == 3:
            return np.eye(3)
        places = np.array([(0, 0, -1), (1, 0, -1), (0, 1, -1), (-1, 0, -1)])
        return np.roll(places, self.start, axis=0)


FACES = {
    "regular triangle": Face(TRIANGLE, (0.4, 7.0, -3.0)),
    "regular quad": Face(CONVEX_QUAD, (0.4, 7.0, -3.0, 1.0)),
    "triangle, N = 1": Face(TRIANGLE, (0.4, 2.0, -1.5), (1, 0)),
    "triangle, N = -1": Face(TRIANGLE, (-2.4, 1.0, 0.3), (-1, 0)),
    "triangle, disclination": Face(TRIANGLE, (np.pi,) * 3, disclination=(2.2, -3.1, 1.4, 0.0)),
    "triangle, disclination on a stripe": Face(TRIANGLE, (0.0,) * 3, disclination=(-6.2, 3.1, 4.4, 0.0)),
    "quad, first triangle": Face(CONVEX_QUAD, (0.4, 2.0, -1.5, 0.7), (1, 0)),
    "quad, second triangle": Face(CONVEX_QUAD, (0.4, 2.0, -1.5, 0.7), (0, -1)),
    "quad, both triangles": Face(CONVEX_QUAD, (-2.0, 2.0, 0.5, 0.7), (-1, 1)),
    "quad, disclination": Face(CONVEX_QUAD, (np.pi,) * 4, disclination=(2.2, -3.1, 1.4, 5.0)),
    "dart, both triangles": Face(DART, (1.0, -0.4, 2.0, 3.0), (1, 2), start=1),
    "dart, second triangle": Face(DART, (1.0, -0.4, 2.0, 3.0), (0, 1), start=3),
    "dart, disclination": Face(DART, (0.0,) * 4, disclination=(-2.2, 3.1, 4.0, 0.9), start=1),
}


def show_socket(obj, socket_name):
    """Make the object glow with (1 + value) / 2 of one output of the stripes group."""
    material, *_ = surface_material("probe")
    tree = material.node_tree
    tree.nodes.clear()
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = stripes.stripes_group()
    scaled = tree.nodes.new("ShaderNodeMath")
    scaled.operation = "MULTIPLY_ADD"
    scaled.inputs[1].default_value = scaled.inputs[2].default_value = 0.5
    glow = tree.nodes.new("ShaderNodeEmission")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(group.outputs[socket_name], scaled.inputs[0])
    tree.links.new(scaled.outputs[0], glow.inputs["Color"])
    tree.links.new(glow.outputs[0], output.inputs["Surface"])
    obj.data.materials.append(material)
    return group


def rendered(tmp_path, engine="CYCLES", pixels=PIXELS):
    """(pixels, pixels) red of the scene from above, one sample in the middle of each pixel, row 0 at the bottom."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", VIEW_WIDTH
    camera.location.z = 5.0
    scene.collection.objects.link(camera)
    scene.camera = camera
    render = scene.render
    render.engine = engine
    render.resolution_x = render.resolution_y = pixels
    render.filter_size = 0.01
    scene.cycles.samples, scene.cycles.filter_width = 1, 0.01
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.filepath = str(tmp_path / "samples.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(render.filepath)
    values = np.empty(pixels * pixels * 4, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(pixels, pixels, 4)[:, :, 0]


def point_samples(tmp_path, engine="CYCLES"):
    """The values that :func:`show_socket` shows."""
    return rendered(tmp_path, engine) * 2 - 1


def pixel_centres():
    line = ((np.arange(PIXELS) + 0.5) / PIXELS - 0.5) * VIEW_WIDTH
    return np.stack(np.meshgrid(line, line), axis=-1)


def differences(face, picture):
    """|shader - formula| of cos(theta), away from edges and singular points."""
    found = []
    for point, value in zip(pixel_centres().reshape(-1, 2), picture.ravel(), strict=True):
        here = face.theta(point)
        if here and here[1] > 0.01 and here[2] > 0.03:
            found.append(abs(value - np.cos(here[0])))
    assert len(found) > 2000
    return np.array(found)


def some_defects():
    """Defects of both kinds and signs for a face."""
    return [
        DefectEmpty("disclination", 0, 0.5, (0.1, 0.2, 0.0), (0, 0, 1)),
        DefectEmpty("disclination", 1, -0.5, (0.3, 0.2, 0.0), (0, 0, 1)),
        DefectEmpty("dislocation", 2, 1.0, (0.1, 0.4, 0.0), (1, 0, 0)),
    ]
