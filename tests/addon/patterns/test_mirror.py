# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirror symmetry on Blender's meshes: exact patterns, cuts, and what is refused."""

import re

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from scipy.spatial import cKDTree

from synch_fields.core.errors import AsymmetryError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.pattern_surface import surface_of

from ..scenes import attribute, bent, grid, snapshot, torus


def mirrored(obj, axis):
    """(n,) the vertex at the mirror image of each one's place."""
    places = attribute(obj, "position").astype(float)
    image = places * np.where(np.arange(3) == axis, -1, 1)
    distances = np.linalg.norm(image[:, None] - places[None], axis=2)
    assert distances.min(axis=1).max() < 1e-5
    return distances.argmin(axis=1)


@pytest.mark.parametrize(
    ("make", "symmetry", "axes"),
    [(lambda: bent(grid(16)), "line", "XY"), (lambda: bent(grid(16)), "vector", "Y"), (torus, "line", "X")],
)
def test_patterns_are_their_own_mirror_image(make, symmetry, axes):
    obj = make()
    report = api.stripes(obj, symmetry=symmetry, mirror=axes, spacing=0.25)
    pattern = attribute(obj, "synch_pattern")
    directions = attribute(obj, "synch_direction").astype(float)
    for axis in ("XYZ".index(a) for a in axes):
        partner = mirrored(obj, axis)
        np.testing.assert_allclose(pattern[partner], pattern, atol=1e-6)
        image = directions[partner] * np.where(np.arange(3) == axis, -1, 1)
        cosines = np.einsum("ij,ij->i", image, directions)
        # Blender's triangles are not mirrored where quads are bent, and with them the tangent planes.
        assert (np.abs(cosines) if symmetry == "line" else cosines).min() > 0.998
    assert report["settings"]["mirror"] == axes
    assert report["lower_bound"] <= report["energy"]


def test_the_operator_mirrors():
    obj = bent(grid(12))
    assert bpy.ops.synch.stripes(mirror=(True, False, False)) == {"FINISHED"}
    pattern = attribute(obj, "synch_pattern")
    np.testing.assert_allclose(pattern[mirrored(obj, 0)], pattern, atol=1e-6)


def test_an_angle_beside_a_mirror_is_warned_of():
    report = api.stripes(grid(), mirror="X", angle=0.3, spacing=0.5)
    assert any("both sides of the mirror" in line for line in report["warnings"])


def test_a_symmetric_cut_is_mirrored():
    obj = bent(grid(12))
    for edge in obj.data.edges:
        ends = [obj.data.vertices[v].co for v in edge.vertices]
        edge.use_seam = all(abs(co.x) < 1e-6 for co in ends) or all(abs(abs(co.x) - 0.5) < 0.01 for co in ends)
    assert any(edge.use_seam for edge in obj.data.edges)
    api.stripes(obj, mirror="X", spacing=0.25, constraints=[{"where": "seams", "what": "cut"}])
    pattern = attribute(obj, "synch_pattern")
    partner = mirrored(obj, 0)
    off_seams = np.ones(len(pattern), bool)
    for edge in obj.data.edges:
        if edge.use_seam:
            off_seams[list(edge.vertices)] = False
    np.testing.assert_allclose(pattern[partner][off_seams], pattern[off_seams], atol=1e-6)


def test_a_cut_on_one_side_is_refused():
    obj = bent(grid(12))
    for edge in obj.data.edges:
        edge.use_seam = all(obj.data.vertices[v].co.x > 0.4 for v in edge.vertices)
    before = snapshot()
    with pytest.raises(AsymmetryError, match="not symmetric in X"):
        api.stripes(obj, mirror="X", spacing=0.25, constraints=[{"where": "seams", "what": "cut"}])
    assert snapshot() == before


def test_asymmetric_vertices_are_selected_and_nothing_is_written():
    obj = bent(grid(12))
    obj.data.vertices[5].co.z += 0.2
    with pytest.raises(RuntimeError, match="not symmetric in X: vertices"):
        bpy.ops.synch.stripes(mirror=(True, False, False))
    selected = {v.index for v in obj.data.vertices if v.select}
    assert 5 in selected and len(selected) == 2
    assert "synch_phase" not in obj.data.attributes


def test_triangles_with_other_diagonals_are_joined_as_the_message_says():
    obj = bent(grid(12))
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.quads_convert_to_tris(quad_method="FIXED")
    with pytest.raises(RuntimeError, match=r"Face > Tris to Quads"):
        bpy.ops.synch.stripes(mirror=(True, False, False), spacing=0.25)
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.tris_convert_to_quads()
    assert bpy.ops.synch.stripes(mirror=(True, False, False), spacing=0.25) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert "synch_phase" in obj.data.attributes


@pytest.mark.parametrize("axes", ["W", "xq", None])
def test_unknown_axes_are_refused(axes):
    with pytest.raises(Exception, match=r"use axes of X, Y and Z|give a text"):
        api.stripes(grid(), mirror=axes)


@pytest.mark.any_surface
def test_coarse_meshes_are_mirrored_on_a_surface_of_their_own():
    """Suzanne, whose faces are too coarse and whose triangles are not mirrored everywhere."""
    bpy.ops.mesh.primitive_monkey_add()
    obj = bpy.context.active_object
    report = api.stripes(obj, mirror="X", surface="automatic", spacing=0.4)
    assert report["surface"]["vertices"] > len(obj.data.vertices)
    surface = surface_of(obj)
    pattern, places = attribute(surface, "synch_pattern"), attribute(surface, "position").astype(float)
    distances, near = cKDTree(places).query(places * [-1, 1, 1], 2)
    assert distances[:, 0].max() < 1e-5
    alone = distances[:, 1] > 1e-5  # two of Suzanne's vertices share a place
    np.testing.assert_allclose(pattern[near[alone, 0]], pattern[alone], atol=1e-5)
    report = api.quad_mesh(obj, mirror="X", surface="automatic", faces=200)
    made_at = attribute(bpy.data.objects[report["quad_mesh"]["object"]], "position")
    assert cKDTree(made_at).query(made_at * [-1, 1, 1])[0].max() < 1e-5
    assert not any("no mirror image" in line for line in report["warnings"])
    assert report["quad_mesh"]["quad_share"] == 1


@pytest.mark.any_surface
@pytest.mark.parametrize("make", [api.stripes, api.quads])
def test_patterns_are_mirrored_where_triangles_are_not(make):
    """A fine ball whose vertices have no mirror images, with a bulge on the side that is mirrored."""
    asked = {"mirror": "X", "surface": "automatic", "spacing": 0.4, "guidance": "axis:Z=10"}
    obj = ball_with_bulge(is_one_sided=True)
    report = make(obj, **asked)
    (away,) = re.findall("not symmetric in X: its positive side is mirrored, up to ([0-9.]+)", str(report["warnings"]))
    assert float(away) == pytest.approx(0.05, rel=0.1)
    surface = surface_of(obj)
    places, directions = (attribute(surface, name).astype(float) for name in ("position", "synch_direction"))
    distances, images = cKDTree(places).query(places * [-1, 1, 1])
    assert distances.max() < 1e-6 and len(np.unique(images)) == len(places)
    pattern = attribute(surface, "synch_pattern")
    np.testing.assert_allclose(pattern[images], pattern, atol=1e-6)
    if make is api.stripes:  # crosses may be turned
        assert np.abs(np.einsum("nx,nx->n", directions[images] * [-1, 1, 1], directions)).min() > 0.999
    # About the same surface, with triangles that are mirrored already.
    whole = make(ball_with_bulge(is_one_sided=False), **asked)
    assert "surface" not in whole and report["energy"] == pytest.approx(whole["energy"], rel=0.2)
    assert report["lower_bound"] <= report["energy"]


def ball_with_bulge(is_one_sided):
    """A ball with a bulge at positive X, turned before that, or one with bulges and triangles alike on both sides."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32)
    obj = bpy.context.active_object
    if is_one_sided:
        obj.data.transform(Matrix.Rotation(0.3, 4, (1, 2, 3)))
    for vertex in obj.data.vertices:
        vertex.co.y *= 1 + 0.2 * (max(vertex.co.x, 0) if is_one_sided else vertex.co.x) ** 2
    obj.data.update()
    return obj
