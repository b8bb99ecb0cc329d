# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stripes in the world: their spacing in scene units and their direction, whatever the object's transform."""

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.patterns.info import describe

from ..scenes import attribute, grid, set_vectors, sphere

TRANSFORMS = {
    "plain": ((1, 1, 1), (0, 0, 0)),
    "scaled": ((3, 3, 3), (0.3, 0.2, 0.1)),
    "stretched": ((2.5, 0.7, 1.3), (0.9, 0.2, 2.1)),
    "mirrored": ((-1, 1, 1), (0, 0, 0)),
    "mirrored and stretched": ((2, -0.6, -3), (1.1, 0.4, 0.2)),
}


def world_gradients(obj):
    """Per regular triangle: gradient of theta, direction of the stripes and area, all in the world."""
    matrix = np.array(obj.matrix_world.to_3x3())
    obj.data.calc_loop_triangles()
    corners = np.array([t.loops[:] for t in obj.data.loop_triangles])
    faces = np.array([t.polygon_index for t in obj.data.loop_triangles])
    vertices = np.array([loop.vertex_index for loop in obj.data.loops])[corners]
    regular = ~attribute(obj, "synch_barycentric")[corners].any(axis=(1, 2)) & (
        attribute(obj, "synch_singularity")[faces] == 0
    )
    corners, vertices = corners[regular], vertices[regular]
    places = (attribute(obj, "position").astype(float) @ matrix.T)[vertices]
    phases = attribute(obj, "synch_phase").astype(float)[corners]
    sides = np.stack([places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]], axis=1)
    rises = np.column_stack([phases[:, 1] - phases[:, 0], phases[:, 2] - phases[:, 0]])
    normals = np.cross(sides[:, 0], sides[:, 1])
    areas = np.linalg.norm(normals, axis=1)
    system = np.concatenate([sides, (normals / areas[:, None])[:, None]], axis=1)
    gradients = np.linalg.solve(system, np.column_stack([rises, np.zeros(len(rises))])[:, :, None])[:, :, 0]
    directions = attribute(obj, "synch_direction").astype(float)[vertices[:, 0]] @ matrix.T
    return gradients, directions / np.linalg.norm(directions, axis=1)[:, None], areas / 2


@pytest.mark.parametrize(
    ("transform", "symmetry"), tuple(zip(TRANSFORMS, ("VECTOR", "LINE", "VECTOR", "LINE", "VECTOR"), strict=True))
)
def test_flat_stripes_have_exactly_the_spacing_in_scene_units(transform, symmetry):
    obj = grid()
    obj.scale, obj.rotation_euler = TRANSFORMS[transform]
    set_vectors(obj, "wish", np.tile((2.0, 1.0, 0.0), (len(obj.data.vertices), 1)))
    spacing = 0.7
    bpy.ops.synch.stripes(symmetry=symmetry, guidance="attribute:wish", spacing=spacing)
    gradients, directions, _ = world_gradients(obj)
    assert len(gradients) == len(obj.data.loop_triangles)
    np.testing.assert_allclose(np.linalg.norm(gradients, axis=1), 2 * np.pi / spacing, rtol=1e-3)
    # The object's transform carries the wish along, and stripes run along it.
    wish = np.array(obj.matrix_world.to_3x3()) @ (2.0, 1.0, 0.0)
    wish /= np.linalg.norm(wish)
    np.testing.assert_allclose(np.abs(directions @ wish), 1, atol=1e-4)
    assert np.abs(np.einsum("ij,ij->i", gradients, directions)).max() < 1e-3 * 2 * np.pi / spacing


@pytest.mark.parametrize("transform", ["scaled", "mirrored and stretched"])
def test_stripes_on_a_sphere_keep_spacing_and_direction(transform):
    obj = sphere(4)
    obj.scale, obj.rotation_euler = TRANSFORMS[transform]
    spacing = 0.3 * abs(np.prod(TRANSFORMS[transform][0])) ** (1 / 3)
    bpy.ops.synch.stripes(spacing=spacing)
    gradients, directions, areas = world_gradients(obj)
    error = np.abs(np.linalg.norm(gradients, axis=1) * spacing / (2 * np.pi) - 1)
    order = np.argsort(error)
    median = error[order][np.searchsorted(np.cumsum(areas[order]), areas.sum() / 2)]
    assert median < 0.15
    sines = np.abs(np.einsum("ij,ij->i", gradients, directions)) / np.linalg.norm(gradients, axis=1)
    assert np.median(sines) < np.sin(np.radians(10))


def test_parent_scale_counts():
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.scale = (4, 4, 4)
    obj = grid()
    obj.parent = parent
    set_vectors(obj, "wish", np.tile((1.0, 0.0, 0.0), (len(obj.data.vertices), 1)))
    bpy.ops.synch.stripes(guidance="attribute:wish", spacing=2.0)
    gradients, _, _ = world_gradients(obj)
    np.testing.assert_allclose(np.linalg.norm(gradients, axis=1), np.pi, rtol=1e-3)


def test_scale_set_by_a_script_counts_at_once():
    obj = sphere()
    obj.scale = (10, 10, 10)  # no update of the scene in between
    report = api.stripes(obj, spacing=5.0)
    assert report["settings"]["spacing"] == 5.0
    small = sphere()
    np.testing.assert_allclose(api.stripes(small, spacing=0.5)["energy"], report["energy"], rtol=0.02)


def test_automatic_spacing_follows_the_scale():
    obj = sphere()
    plain = api.stripes(obj)["settings"]["spacing"]
    obj.scale = (7, 7, 7)
    assert api.stripes(obj)["settings"]["spacing"] == pytest.approx(7 * plain, rel=1e-5)


def test_automatic_spacing_is_always_accepted():
    """Even on the faces that every new file starts with, which carry no stripes; it is told so."""
    bpy.ops.mesh.primitive_cube_add()
    report = api.stripes(bpy.context.active_object, surface="faces")
    assert any("set the surface to automatic" in line for line in report["warnings"])


def test_spacing_does_not_count_for_directions():
    sphere()
    assert bpy.ops.synch.directions(spacing=1e9) == {"FINISHED"}
    with pytest.raises(RuntimeError, match=r"the spacing is -1\.0: give a positive number"):  # no command allows it
        bpy.ops.synch.directions(spacing=-1)


def test_stripes_finer_than_the_mesh_carries_are_refused_where_strict():
    obj = grid(8)
    assert "finer than the mesh can carry" in api.stripes(obj, spacing=0.2, surface="faces")["warnings"][0]
    with pytest.raises(SettingError, match="finer than the mesh can carry"):
        api.stripes(obj, spacing=0.2, surface="faces", strict=True)


def test_a_mesh_in_edit_mode_is_described_as_it_was_edited():
    expected, _ = describe(sphere())
    obj = sphere(2)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide(smoothness=1)
    facts, _ = describe(obj)
    assert obj.mode == "EDIT" and facts["status"] == "ready"
    assert (facts["vertices"], facts["faces"]) == (expected["vertices"], expected["faces"])
