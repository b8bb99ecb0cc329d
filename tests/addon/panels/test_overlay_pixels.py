# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay as it is drawn: colours of pixels."""

import bpy
import gpu
import numpy as np
import pytest
from mathutils import Matrix, Vector

from synch_fields.synch_addon.panels import overlay, overlay_view

from .. import scenes
from .test_overlay import set_errors, with_directions


@pytest.fixture
def canvas():
    """A square of 64 pixels with a depth buffer, which looks down on the square of side 2 around the origin."""
    if not hasattr(gpu, "init"):
        pytest.skip("this Blender cannot draw without a window")
    gpu.init()
    offscreen = gpu.types.GPUOffScreen(64, 64)
    yield offscreen
    offscreen.free()


def drawn(canvas, obj, parts, depth=1.0):
    """(64, 64, 3) colours after drawing over a background whose surface lies at a depth."""
    view = Matrix.Translation((0, 0, -5))
    with canvas.bind():
        framebuffer = gpu.state.active_framebuffer_get()
        framebuffer.clear(color=(0, 0, 0, 1), depth=depth)
        with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
            gpu.matrix.load_projection_matrix(Matrix.Diagonal((1, 1, -0.1, 1)))
            overlay_view.draw_object(obj, parts, view)
        pixels = framebuffer.read_color(0, 0, 64, 64, 3, 0, "FLOAT")
        pixels.dimensions = 64 * 64 * 3
    return np.array(pixels).reshape(64, 64, 3)


def test_seam_is_drawn_at_its_place_and_hidden_by_what_is_nearer(canvas):
    obj = scenes.add_object([(-1, 0, 0), (1, 0, 0), (0, -1, 0)], [(0, 2, 1)])
    for edge in obj.data.edges:
        edge.use_seam = set(edge.vertices) == {0, 1}
    row = obj.synch.constraints.add()
    row.where, row.what = "SEAMS", "CUT"
    rows = np.flatnonzero(drawn(canvas, obj, ["CONSTRAINTS"])[:, 20, 0] > 0.3)
    assert len(rows) and np.abs(rows - 31.5).max() < 3
    assert not drawn(canvas, obj, ["CONSTRAINTS"], depth=0.6).any(), "something nearer hides it"
    assert not drawn(canvas, obj, ["DEFECTS", "MARKS", "STREAMLINES"]).any()
    obj.location.y = 0.5
    bpy.context.view_layer.update()
    rows = np.flatnonzero(drawn(canvas, obj, ["CONSTRAINTS"])[:, 20, 0] > 0.3)
    assert len(rows) and np.abs(rows - 47.5).max() < 3


def test_faces_are_painted_and_lines_are_seen_over_them(canvas):
    obj = scenes.add_object([(-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0)], [(0, 2, 1), (0, 1, 3)])
    set_errors(obj, [1, -0.6])
    for edge in obj.data.edges:
        edge.use_seam = set(edge.vertices) == {0, 1}
    row = obj.synch.constraints.add()
    row.where, row.what = "SEAMS", "PHASE"
    painted = drawn(canvas, obj, ["SPACING"])
    red, blue = painted[20, 32], painted[44, 32]
    assert red[0] > 0.4 > 0.3 > red[2] and blue[2] > 0.4 > 0.3 > blue[0]
    assert not drawn(canvas, obj, ["SPACING"], depth=0.6).any(), "something nearer hides it"
    seam = drawn(canvas, obj, ["SPACING", "CONSTRAINTS"])[31:33, 24:40]
    assert (seam[..., 0] > 0.5).any(axis=0).all() and (seam[..., 2] > 0.3).any(axis=0).all()


def test_tubes_have_the_colours_of_their_points(canvas):
    obj = scenes.add_object([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)])
    assert overlay.sphere_faces(obj) == []
    colors = np.float32([(1, 0, 0, 1), (1, 0, 0, 1), (0, 0, 1, 1), (0, 0, 1, 1)])
    obj.data.attributes.new("synch_color", "FLOAT_COLOR", "POINT").data.foreach_set("color", colors.ravel())
    picture = drawn(canvas, obj, ["SPHERE"])
    assert picture[4, 32, 0] > 2 * picture[4, 32, 2] and picture[60, 32, 2] > 2 * picture[60, 32, 0]


def test_picture_follows_a_change_of_the_attribute(canvas):
    obj = scenes.grid(1)
    with_directions(obj, np.tile([1.0, 0.0, 0.0], (4, 1)))
    bpy.context.view_layer.update()
    before = drawn(canvas, obj, ["MARKS"])
    assert before.any()
    obj.data.attributes["synch_direction"].data.foreach_set("vector", np.float32(np.tile([0, 1, 0], 4)))
    obj.data.update()
    bpy.context.view_layer.update()
    after = drawn(canvas, obj, ["MARKS"])
    np.testing.assert_allclose(after, before.transpose(1, 0, 2)[::1], atol=0.35)
    assert not np.allclose(after, before)


def test_dots_of_defects_are_smaller_where_lines_are_near_to_one_another(canvas):
    obj = scenes.grid(2)
    obj.location = -0.5 * Vector((1, 1, 0))
    bpy.context.view_layer.update()
    obj.data.attributes.new("synch_singularity", "FLOAT", "FACE").data[0].value = 0.5

    def dot():
        return int((drawn(canvas, obj, ["DEFECTS"]).sum(axis=2) > 0.3).sum())

    large = dot()
    obj.synch.result = '{"command": "stripes", "settings": {"spacing": 1.0}}'  # 32 pixels
    assert dot() == large > 8
    obj.synch.result = '{"command": "stripes", "settings": {"spacing": 0.25}}'  # 8 pixels
    assert dot() < 0.5 * large
