# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What directions follow when asked: curvature, an attribute, an angle, the boundary or a part of it."""

import bpy
import numpy as np
import pytest

from ..scenes import add_group, attribute, directions, grid, set_vectors, sphere, tube

UP = np.array([0.0, 0.0, 1.0])
LOWER, UPPER = np.arange(24), np.arange(24) + 8 * 24  # the rims of the tube


def angles_to_axis(obj):
    """Angle in degrees, 0..90, of each direction to the tube's axis."""
    return np.degrees(np.arccos(np.clip(np.abs(directions(obj) @ UP), 0, 1)))


@pytest.mark.parametrize(
    "guidance, angle, expected",
    [("curvature-max", 0, 90), ("curvature-min", 0, 0), ("curvature-min", 30, 30), ("curvature-max", -20, 70)],
)
@pytest.mark.parametrize("operator", ["directions", "stripes"])
def test_directions_on_a_tube_follow_its_curvature(guidance, angle, expected, operator):
    obj = tube()
    getattr(bpy.ops.synch, operator)(guidance=guidance, angle=np.radians(angle))
    np.testing.assert_allclose(angles_to_axis(obj), expected, atol=2.0)


@pytest.mark.parametrize("degrees", [0, 30, 90, -45])
def test_attribute_is_followed_and_turned_counterclockwise(degrees):
    obj = grid()
    set_vectors(obj, "combed", np.tile((1.0, 0.0, 5.0), (len(obj.data.vertices), 1)))  # not tangential
    bpy.ops.synch.directions(guidance="attribute:combed", symmetry="VECTOR", angle=np.radians(degrees))
    turned = np.radians(degrees)
    np.testing.assert_allclose(
        directions(obj), np.tile((np.cos(turned), np.sin(turned), 0), (len(obj.data.vertices), 1)), atol=1e-5
    )


def test_result_of_directions_can_guide_stripes():
    obj = sphere()
    bpy.ops.synch.directions(symmetry="LINE", seed=3)
    before = directions(obj)
    bpy.ops.synch.stripes(guidance="attribute:synch_direction", spacing=0.5)
    np.testing.assert_allclose(np.abs(np.einsum("ij,ij->i", directions(obj), before)), 1, atol=1e-4)


def test_vertex_group_restricts_the_boundary():
    obj = tube()
    add_group(obj, "lower", LOWER)
    bpy.ops.synch.directions(boundary="ACROSS", vertex_group="lower", angle=np.radians(40))
    np.testing.assert_allclose(angles_to_axis(obj)[LOWER], 40, atol=1.0)
    bpy.ops.synch.directions(boundary="ALONG", vertex_group="lower", guidance="curvature-min")
    angles = angles_to_axis(obj)
    np.testing.assert_allclose(angles[LOWER], 90, atol=1.0)
    assert (angles[UPPER] < 45).all()


def test_stripe_lies_on_the_named_part_of_the_boundary_only():
    obj = tube()
    add_group(obj, "lower", LOWER)
    bpy.ops.synch.stripes(boundary="PHASE", vertex_group="lower", spacing=0.45)
    pattern = attribute(obj, "synch_pattern")
    np.testing.assert_allclose(pattern[LOWER], 1, atol=1e-6)
    assert (np.abs(pattern[UPPER] - np.cos(2 * np.pi * 2.0 / 0.45)) < 0.05).all()  # undisturbed by the upper rim


def test_phase_on_a_boundary_holds_at_the_corners_of_its_faces():
    obj = tube()
    bpy.ops.synch.stripes(boundary="PHASE", spacing=0.5)
    corner_vertices = np.array([loop.vertex_index for loop in obj.data.loops])
    on_rim = np.isin(corner_vertices, np.concatenate([LOWER, UPPER]))
    regular = ~attribute(obj, "synch_barycentric").any(axis=1)
    cosines = np.cos(attribute(obj, "synch_phase").astype(float))
    np.testing.assert_allclose(cosines[on_rim & regular], 1, atol=1e-6)
