# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads in shaders: the two phases, the profiles that do not tell one from the other, and the material."""

import bpy
import numpy as np
import pytest

from synch_fields.core.fields import direction_field
from synch_fields.core.fields.growth import Growth
from synch_fields.core.interpolate import evaluate, face_phases
from synch_fields.synch_addon import quad_profiles, scene_io

from .scenes import quad_sphere, sphere

PIXELS = 512
# Raises every value above zero, where a picture is not clamped.
OFFSET = 64.0


def write_phases(obj, phases, polygons):
    """The attributes of two phases that the shader reads."""
    for axis, phase in zip("xy", phases, strict=True):
        scene_io.write_attribute(obj, f"synch_phase_{axis}", "CORNER", "FLOAT", phase.corner_phase)
        scene_io.write_attribute(obj, f"synch_index_{axis}", "FACE", "INT", phase.index)
        if phase.index_2.any():
            scene_io.write_attribute(obj, f"synch_index_{axis}_2", "FACE", "INT", phase.index_2)
        scene_io.write_attribute(obj, f"synch_disclination_{axis}", "FACE", "FLOAT_COLOR", phase.disclination)
    scene_io.write_attribute(obj, "synch_barycentric", "CORNER", "FLOAT_VECTOR", phases[0].corner_place)
    closings = np.column_stack([phase.closing for phase in phases])
    scene_io.write_attribute(obj, "synch_closing", "FACE", "FLOAT2", closings)


def unfold(obj, polygons):
    """Give each face a square of the picture; returns (c, 2) corners in pixels."""
    rows = int(np.ceil(np.sqrt(len(polygons.starts))))
    size = PIXELS / rows
    faces = np.repeat(np.arange(len(polygons.starts)), polygons.sizes)
    corners = np.array([(0.05, 0.05), (0.95, 0.05), (0.95, 0.95), (0.05, 0.95)])
    places = corners[np.arange(len(faces)) - polygons.starts[faces]]
    uv = (np.column_stack([faces % rows, faces // rows]) + places) * size
    layer = obj.data.uv_layers.new(name="unfolded")
    layer.uv.foreach_set("vector", np.float32(uv / PIXELS).ravel())
    layer.active = True
    return uv


def points_of(polygons, uv):
    """Pixels, the triangles that they are in and their weights there, away from all edges."""
    pixels, triangles, weights = [], [], []
    for triangle, corners in enumerate(polygons.triangle_corners):
        low, high = np.floor(uv[corners].min(axis=0)), np.ceil(uv[corners].max(axis=0))
        grid = np.stack(np.meshgrid(*(np.arange(a, b) for a, b in zip(low, high, strict=True))), axis=-1).reshape(-1, 2)
        matrix = np.vstack([uv[corners].T, np.ones(3)])
        inside = np.linalg.solve(matrix, np.vstack([grid.T + 0.5, np.ones(len(grid))])).T
        kept = (inside.min(axis=1) > 0.01) & (inside.min(axis=1) < 0.32)
        pixels.append(grid[kept].astype(int))
        triangles.append(np.full(kept.sum(), triangle))
        weights.append(inside[kept])
    return np.concatenate(pixels), np.concatenate(triangles), np.concatenate(weights)


def baked(obj, outputs, **inputs):
    """(PIXELS, PIXELS, 3) values of up to three outputs of the group over the unfolded faces."""
    material = bpy.data.materials.new("probe")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = quad_profiles.quads_group()
    for name, value in inputs.items():
        group.inputs[name].default_value = value
    joined = tree.nodes.new("ShaderNodeCombineXYZ")
    for output, socket in zip(outputs, joined.inputs, strict=False):
        tree.links.new(group.outputs[output], socket)
    raised = tree.nodes.new("ShaderNodeVectorMath")
    raised.inputs[1].default_value = (OFFSET,) * 3
    tree.links.new(joined.outputs[0], raised.inputs[0])
    glow, surface = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(raised.outputs[0], glow.inputs["Color"])
    tree.links.new(glow.outputs[0], surface.inputs["Surface"])
    picture = tree.nodes.new("ShaderNodeTexImage")
    picture.image = bpy.data.images.new("baked", PIXELS, PIXELS, float_buffer=True)
    tree.nodes.active = picture
    obj.data.materials.clear()
    obj.data.materials.append(material)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples = "CYCLES", 1
    bpy.ops.object.bake(type="EMIT", margin=0)
    values = np.empty(PIXELS * PIXELS * 4, np.float32)
    picture.image.pixels.foreach_get(values)
    return values.reshape(PIXELS, PIXELS, 4)[:, :, :3] - OFFSET


def random_phases(obj):
    """The object's faces with random phases along the smoothest crosses: full of defects of both kinds."""
    given = scene_io.read_mesh(obj)
    growth = Growth.of(given.mesh, direction_field(given.mesh, 4), 0.5)
    random = np.random.default_rng(2)
    phases = np.exp(1j * random.uniform(-np.pi, np.pi, len(growth.masses)))
    return given.polygons, face_phases(growth.edge_phases(phases), given.polygons)


@pytest.mark.parametrize("build", [lambda: sphere(3), quad_sphere], ids=["triangles", "quads"])
def test_shader_and_core_agree_on_both_phases_everywhere(build):
    obj = build()
    polygons, phases = random_phases(obj)
    write_phases(obj, phases, polygons)
    uv = unfold(obj, polygons)
    pixels, triangles, weights = points_of(polygons, uv)
    picture = baked(obj, ("Phase X", "Phase Y"))
    for axis, phase in enumerate(phases):
        theta = evaluate(phase, polygons, triangles, weights)
        off = picture[pixels[:, 1], pixels[:, 0], axis] - theta
        off = np.abs(off - 2 * np.pi * np.rint(off / (2 * np.pi)))
        fit = ~np.isin(polygons.triangle_faces[triangles], phase.unfit)
        print(axis, off[fit].max(), (off[fit] > 1e-3).sum(), fit.sum())
        assert off[fit].max() < 1e-3
