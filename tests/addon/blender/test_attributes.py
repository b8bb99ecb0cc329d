# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the operators write: attributes, directions and defect empties, on closed and bounded meshes."""

from fractions import Fraction

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon.blender.attributes import read_values
from synch_fields.synch_addon.blender.modifiers import changing_modifiers

from ..scenes import (
    LAYOUTS,
    add_attribute,
    attribute,
    empties,
    grid,
    hexagon_sphere,
    quad_sphere,
    sphere,
    torus,
    tube,
    written,
)

STRIPE_ATTRIBUTES = {
    "synch_direction": ("POINT", "FLOAT_VECTOR"),
    "synch_phase": ("CORNER", "FLOAT"),
    "synch_index": ("FACE", "INT"),
    "synch_barycentric": ("CORNER", "FLOAT_VECTOR"),
    "synch_vertex_phase": ("POINT", "FLOAT"),
    "synch_pattern": ("POINT", "FLOAT"),
    "synch_spacing_error": ("FACE", "FLOAT"),
    "synch_singularity": ("FACE", "FLOAT"),
}
# Written only where a face needs them: an absent attribute is zero to a shader.
OPTIONAL = {"synch_index_2": ("FACE", "INT"), "synch_disclination": ("FACE", "FLOAT_COLOR")}
EULER = {sphere: 2, quad_sphere: 2, hexagon_sphere: 2, torus: 0}
MESHES = [*EULER, grid, tube]


def starts(obj):
    """First corner of each face."""
    return np.array([p.loop_start for p in obj.data.polygons])


@pytest.mark.parametrize("build", [quad_sphere, hexagon_sphere, tube])
def test_stripes_write_phases_that_start_within_a_turn_and_vertices_carry_the_pattern(build):
    obj = build()
    assert bpy.ops.synch.stripes(spacing=0.4) == {"FINISHED"}
    found = written(obj)
    assert STRIPE_ATTRIBUTES.items() <= found.items() <= (STRIPE_ATTRIBUTES | OPTIONAL).items()
    for name in found:
        assert np.isfinite(attribute(obj, name)).all(), name
    (slot,) = obj.material_slots
    groups = [n.node_tree.name for n in slot.material.node_tree.nodes if n.bl_idname == "ShaderNodeGroup"]
    assert groups == ["Synch Stripes"]
    phase, pattern = attribute(obj, "synch_phase"), attribute(obj, "synch_pattern")
    singular = attribute(obj, "synch_index") != 0
    for name in {"synch_index_2", "synch_disclination"} & set(written(obj)):
        values = attribute(obj, name)
        singular |= (values != 0).reshape(len(values), -1).any(axis=1)
    assert not singular.all()
    first = phase[starts(obj)][~singular]
    # float32 rounds pi itself up
    assert (first >= -np.float32(np.pi)).all() and (first <= np.float32(np.pi)).all()
    corner_vertices = np.array([loop.vertex_index for loop in obj.data.loops])
    face_of_corner = np.repeat(np.arange(len(singular)), [p.loop_total for p in obj.data.polygons])
    regular = ~singular[face_of_corner]
    np.testing.assert_allclose(np.cos(phase[regular]), pattern[corner_vertices[regular]], atol=2e-5)
    places = attribute(obj, "synch_barycentric")
    assert not places[regular].any()
    assert places[~regular].any() == singular.any()


@pytest.mark.parametrize("build", MESHES)
def test_directions_alone_are_written_and_are_unit_and_tangential(build):
    obj = build()
    obj.scale = (2, 0.6, -1)
    obj.rotation_euler = (0.3, 0.5, 0.7)
    assert bpy.ops.synch.directions() == {"FINISHED"}
    assert set(written(obj)) == {"synch_direction", "synch_singularity"} and not obj.data.materials
    directions = attribute(obj, "synch_direction").astype(float)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1, atol=1e-5)
    # In the world, where the surface is what the user sees.
    matrix = np.array(obj.matrix_world.to_3x3())
    directions = directions @ matrix.T
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    triangles, normals = _triangles(obj), np.zeros((len(directions), 3))
    corners = (attribute(obj, "position").astype(float) @ matrix.T)[triangles]
    for k in range(3):
        ahead, behind = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        cross = np.cross(ahead, behind)
        sine = np.linalg.norm(cross, axis=1)
        angle = np.arctan2(sine, np.einsum("ij,ij->i", ahead, behind))
        np.add.at(normals, triangles[:, k], cross / sine[:, None] * angle[:, None])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    assert np.abs(np.einsum("ij,ij->i", directions, normals)).max() < 1e-4


def _triangles(obj):
    obj.data.calc_loop_triangles()
    return np.array([t.vertices[:] for t in obj.data.loop_triangles])


@pytest.mark.parametrize("symmetry, part", [("VECTOR", 1), ("LINE", 2), ("CROSS", 4)])
@pytest.mark.parametrize("build", EULER)
def test_sum_of_disclination_indices_is_the_euler_characteristic(build, symmetry, part):
    obj = build()
    bpy.ops.synch.directions(symmetry=symmetry)
    indices = [Fraction(e["synch_index"]) for e in empties(obj)]
    assert sum(indices) == EULER[build]
    assert all((index * part).denominator == 1 and index != 0 for index in indices)
    assert sum(map(Fraction, attribute(obj, "synch_singularity").tolist())) == EULER[build]
    assert {e["synch_kind"] for e in empties(obj)} <= {"disclination"}


@pytest.mark.parametrize("symmetry", ["VECTOR", "LINE"])
def test_empties_mark_the_defects_of_their_faces(symmetry):
    obj = sphere()
    obj.location, obj.scale = (3, 2, 1), (1, 2, 1)
    bpy.ops.synch.stripes(symmetry=symmetry, spacing=0.5)
    index, singularity = attribute(obj, "synch_index"), attribute(obj, "synch_singularity")
    marks = {kind: empties(obj, kind) for kind in ("disclination", "dislocation")}
    assert len(marks["disclination"]) == np.count_nonzero(singularity)
    assert len(marks["dislocation"]) == np.count_nonzero(index)
    assert marks["disclination"] and marks["dislocation"]
    for kind, values in (("disclination", singularity), ("dislocation", index)):
        for empty in marks[kind]:
            face = obj.data.polygons[empty["synch_face"]]
            assert values[face.index] == empty["synch_index"]
            assert (obj.matrix_world @ face.center - empty.matrix_world.translation).length < 1e-5
            (collection,) = empty.users_collection
            assert collection.name.startswith("Defects") and obj.name in collection.name


def test_running_again_replaces_everything():
    obj = sphere()
    bpy.ops.synch.stripes(spacing=0.3)
    names = {e.name for e in empties(obj)}
    data = (len(bpy.data.objects), len(bpy.data.collections), len(bpy.data.materials), len(bpy.data.node_groups))
    first = attribute(obj, "synch_phase")
    bpy.ops.synch.stripes(spacing=0.3)
    np.testing.assert_array_equal(attribute(obj, "synch_phase"), first)  # the same seed, the same result
    assert {e.name for e in empties(obj)} == names
    assert data == (
        len(bpy.data.objects), len(bpy.data.collections), len(bpy.data.materials), len(bpy.data.node_groups)
    )  # fmt: skip
    assert [slot.material.name for slot in obj.material_slots] == ["Synch Stripes"]


def test_another_spacing_leaves_no_trace_of_the_first():
    obj = quad_sphere()
    bpy.ops.synch.stripes(spacing=0.4)
    many = len(empties(obj, "dislocation"))
    bpy.ops.synch.stripes(spacing=1.5)
    assert len(empties(obj, "dislocation")) < many
    index = attribute(obj, "synch_index") != 0
    if "synch_index_2" in written(obj):
        index |= attribute(obj, "synch_index_2") != 0
    assert index.sum() <= len(empties(obj, "dislocation"))


def test_spacing_property_tells_the_automatic_choice():
    obj = sphere()
    bpy.ops.synch.stripes()
    phases = attribute(obj, "synch_phase").copy()
    bpy.ops.synch.stripes(spacing=obj["synch_spacing"])
    np.testing.assert_allclose(np.cos(attribute(obj, "synch_phase")), np.cos(phases), atol=1e-3)


@pytest.mark.parametrize("data_type", sorted(LAYOUTS.keys() - {"STRING"}))
def test_every_type_of_attribute_of_this_blender_is_read(data_type):
    """What is not read would not go over to a finer surface."""
    obj = grid(3)
    if not add_attribute(obj.data, "own", data_type, "POINT"):
        pytest.skip("not in this Blender")
    name, dtype, width = LAYOUTS[data_type]
    expected = np.empty(width * len(obj.data.vertices), dtype)
    obj.data.attributes["own"].data.foreach_get(name, expected)
    np.testing.assert_array_equal(read_values(obj, "own", "POINT").ravel(), expected)


def test_what_replaces_the_faces_of_a_mesh_counts_as_changing_them():
    emitter, obj = grid(2), sphere(2)
    emitter.modifiers.new("hair", "PARTICLE_SYSTEM")
    emitter.particle_systems[0].settings.type, emitter.particle_systems[0].settings.count = "HAIR", 5
    for kind in ("PARTICLE_INSTANCE", "VOLUME_TO_MESH"):
        modifier = obj.modifiers.new(kind, kind)
        modifier.object = emitter if kind == "PARTICLE_INSTANCE" else None
        seen = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        assert len(seen.polygons) != len(obj.data.polygons) and changing_modifiers(obj) == [modifier]
        obj.modifiers.remove(modifier)
