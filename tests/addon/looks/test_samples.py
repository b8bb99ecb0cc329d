# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Add > Mesh > Synch Samples: shapes of the right topology, evenly meshed, where the artist wants them."""

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import groups, meshes
from synch_fields.synch_addon.looks import samples

from ..scenes import attribute, places, snapshot

# Euler characteristic, and open edges or not.
TOPOLOGY = {"SUZANNE": (2, False), "PRETZEL": (-2, False), "VASE": (1, True)}


def added(shape, **settings):
    assert bpy.ops.synch.add_sample(shape=shape, **settings) == {"FINISHED"}
    bpy.context.view_layer.update()
    return bpy.context.active_object


@pytest.mark.parametrize("detail", [1, 3])
@pytest.mark.parametrize("shape", TOPOLOGY)
def test_shape_is_even_and_of_its_topology(shape, detail):
    obj = added(shape, detail=detail)
    mesh = meshes.read_mesh(obj).mesh  # which refuses what is not manifold
    euler, is_open = TOPOLOGY[shape]
    assert mesh.euler_characteristic == euler and mesh.pieces.max() == 0
    assert (len(mesh.boundary_edges) > 0) == is_open
    at, ends = places(obj), np.array([edge.vertices[:] for edge in obj.data.edges])
    lengths = np.linalg.norm(at[ends[:, 0]] - at[ends[:, 1]], axis=1)
    assert np.quantile(lengths, 0.99) < 2 * np.median(lengths)
    assert not obj.modifiers and obj.select_get() and len(bpy.context.selected_objects) == 1


@pytest.mark.parametrize("shape", TOPOLOGY)
def test_size_and_place_are_those_asked_for(shape):
    obj = added(shape, detail=2, size=3.0, location=(1, 2, 3))
    assert max(obj.dimensions) == pytest.approx(3.0, rel=1e-4)
    assert np.allclose(obj.matrix_world.translation, (1, 2, 3))
    bpy.context.scene.cursor.location = (5, 0, 1)
    assert np.allclose(added(shape, detail=1).matrix_world.translation, (5, 0, 1))


@pytest.mark.parametrize("shape", ["PRETZEL", "VASE"])
def test_seams_cut_in_half(shape):
    obj = added(shape, detail=2)
    seams = attribute(obj, "uv_seam")
    ends = np.array([edge.vertices[:] for edge in obj.data.edges])[seams]
    assert len(ends) and np.abs(places(obj)[ends.ravel(), 1]).max() < 1e-5
    # Along closed lines, or such that end at the rim.
    counts = np.bincount(ends.ravel())
    assert set(counts[counts > 0]) == ({2} if shape == "PRETZEL" else {1, 2})


@pytest.mark.parametrize("shape", TOPOLOGY)
def test_group_serves_as_spacing_map(shape):
    obj = added(shape, detail=2)
    weights = groups.read_weights(obj, "Fine")
    assert weights.min() < 0.01 and weights.max() > 0.99
    size = max(obj.dimensions)
    report = api.stripes(obj, spacing=size / 5, spacing_map="Fine", spacing_range=obj.synch.spacing_range)
    assert report["forced_dislocations"] > 1


def test_vase_asks_for_a_stripe_on_its_rim():
    obj = added("VASE", detail=2)
    rim = groups.read_weights(obj, "Rim") > 0
    assert rim.sum() == 32
    assert obj.synch.boundary == "PHASE"
    api.stripes(obj, boundary="phase", vertex_group="Rim")
    assert attribute(obj, "synch_pattern")[rim].min() > 0.99


def test_detail_makes_four_times_as_many_faces_even_where_the_scene_is_simplified():
    bpy.context.scene.render.use_simplify = True
    bpy.context.scene.render.simplify_subdivision = 0
    counts = [len(added("VASE", detail=detail).data.polygons) for detail in (1, 2, 3)]
    assert counts[2] == 4 * counts[1] == 16 * counts[0]
    assert bpy.context.scene.render.use_simplify


def test_undo_and_edit_mode():
    bpy.ops.ed.undo_push(message="before")
    before = snapshot()
    added("VASE", detail=1)
    bpy.ops.ed.undo_push(message="add")
    bpy.ops.ed.undo()
    assert snapshot() == before
    added("VASE", detail=1)
    bpy.ops.object.mode_set(mode="EDIT")
    assert not bpy.ops.synch.add_sample.poll()


def test_every_shape_is_offered():
    from synch_fields.synch_addon.looks.samples import SHAPES

    assert [item[0] for item in SHAPES] == list(samples._MAKERS)
