# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay in the viewport: marks and streamlines against closed forms, what it shows of an object, and when it
is computed again."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields import synch_addon
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import changes, meshes
from synch_fields.synch_addon.blender.defect_empties import defect_empties
from synch_fields.synch_addon.blender.pattern_surface import surface_of
from synch_fields.synch_addon.panels import overlay, overlay_view

from .. import scenes

# What is shown of an object


def with_directions(obj, vectors):
    scenes.set_vectors(obj, "synch_direction", vectors)
    return obj


def test_marks_of_a_stretched_object_are_crosses_in_the_world():
    obj = scenes.grid()
    with_directions(obj, np.tile([1.0, 1.0, 0.0], (len(obj.data.vertices), 1)))
    obj.scale, obj.synch.symmetry = (1, 3, 1), "CROSS"
    bpy.context.view_layer.update()
    [(points, colour)] = overlay.direction_marks(obj)
    vectors = (points[:, 1] - points[:, 0]) @ np.diag([1.0, 3.0, 1.0])
    first, second = np.split(vectors, 2)
    np.testing.assert_allclose(np.einsum("ij,ij->i", first, second), 0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(first, axis=1), np.linalg.norm(second, axis=1))
    assert len(colour) == 4


def test_no_directions_without_an_attribute_or_on_a_mesh_that_cannot_carry_them():
    obj = scenes.grid()
    assert overlay.direction_marks(obj) == [] and overlay.direction_lines(obj) == []
    for count in (0, 2):
        loose = scenes.add_object(np.zeros((count, 3)), [])
        loose.synch.boundary = "ALONG"
        assert overlay.direction_lines(with_directions(loose, np.ones((count, 3)))) == []
        assert overlay.defect_points(loose) == [] and overlay.constraint_lines(loose) == []


def test_lines_and_marks_are_finite_on_quads_with_an_empty_triangle_and_directions_that_are_not():
    places = [(x, y, 0) for y in range(3) for x in (0, 1, 2, 3)]
    places[5] = (1, 0, 0)  # the corners 0, 1, 5 of the first quad are 0, 1, 1 now
    obj = scenes.add_object(places, [(a, a + 1, a + 5, a + 4) for a in (0, 1, 2, 4, 5, 6)])
    vectors = np.tile([1.0, 0.5, 0.0], (12, 1))
    vectors[7], vectors[10] = np.nan, 0
    with_directions(obj, vectors)
    areas = meshes.read_mesh(obj).mesh.areas
    assert areas.min() == 0
    for compute in (overlay.direction_marks, overlay.direction_lines):
        [(points, _)] = compute(obj)
        assert len(points) > 8 and np.isfinite(points).all()


def test_defects_lie_where_the_empties_do_and_have_their_colours():
    obj = scenes.quad_sphere(9)
    assert bpy.ops.synch.stripes(spacing=0.3) == {"FINISHED"}
    empties = defect_empties(obj)
    torn = {e["synch_face"] for e in empties if e["synch_kind"] == "disclination"}
    # A dislocation of the other triangle of a quad is one with the disclination there.
    empties = [e for e in empties if e["synch_kind"] == "disclination" or e["synch_face"] not in torn]
    layers = overlay.defect_points(obj)
    assert sum(len(places) for places, _ in layers) == len(empties) > 8
    for places, colour in layers:
        alike = [e for e in empties if np.allclose(e.color, colour)]
        assert len(alike) == len(places)
        # A disclination is shown at the middle of its quad, its empty lies in one of its triangles.
        tolerance = 0.1 if alike[0]["synch_kind"] == "disclination" else 1e-5
        assert cKDTree([e.location for e in alike]).query(places)[0].max() < tolerance


def test_line_ends_of_quads_are_dots_too():
    obj = scenes.quad_sphere(9)
    api.quads(obj, spacing=0.4)
    report = api.place_defects(obj, [20])
    dots = overlay.defect_dots(obj)
    found = set(dots.faces[dots.kinds == "dislocation"].tolist())
    torn = set(dots.faces[dots.kinds == "disclination"].tolist())
    assert found == {defect["face"] for defect in report["dislocations"]} - torn and found


def test_constrained_edges_have_the_colour_of_what_they_ask_for():
    obj = scenes.grid(4)
    obj.data.edges[0].use_seam = True
    obj.data.edges[3].use_edge_sharp = True
    assert overlay.constraint_lines(obj) == []
    for where, what in (("SEAMS", "CUT"), ("SHARP", "CONSTANT"), ("CREASES", "ALONG")):
        row = obj.synch.constraints.add()
        row.where, row.what = where, what
    obj.synch.boundary = "ALONG"
    lines = {colour: points for points, colour in overlay.constraint_lines(obj)}
    for index, what in ((0, "CUT"), (3, "CONSTANT")):
        ends = [obj.data.vertices[v].co for v in obj.data.edges[index].vertices]
        np.testing.assert_allclose(lines[overlay.WISH_COLORS[what]], [ends])
    rim = lines[overlay.WISH_COLORS["ALONG"]]
    assert len(rim) == 16 and (np.abs(rim).max(axis=2) == 1).all()
    obj.synch.constraints[0].enabled = False
    assert len(overlay.constraint_lines(obj)) == 2


def test_boundary_is_restricted_to_the_vertex_group():
    obj = scenes.grid(4)
    obj.synch.boundary, obj.synch.vertex_group = "ACROSS", "left"
    assert overlay.constraint_lines(obj) == []
    scenes.add_group(obj, "left", [v.index for v in obj.data.vertices if v.co.x < -0.9])
    [(points, _)] = overlay.constraint_lines(obj)
    assert len(points) == 4 and (points[:, :, 0] == -1).all()


def set_errors(obj, errors):
    obj.data.attributes.new("synch_spacing_error", "FLOAT", "FACE").data.foreach_set("value", np.float32(errors))


def test_faces_are_red_where_lines_are_too_far_apart_and_blue_where_too_near():
    obj = scenes.grid(3)
    assert overlay.spacing_errors(obj) == []
    set_errors(obj, [0, 0.25, 0.5, 2, -0.2, -1 / 3, -0.9, 0, 0])
    [(corners, colours)] = overlay.spacing_errors(obj)
    assert corners.shape == (18, 3, 3) and colours.shape == (18, 4)
    places = scenes.places(obj)
    for face, own in enumerate(np.split(corners, 9)):
        expected = {tuple(p) for p in places[list(obj.data.polygons[face].vertices)]}
        assert {tuple(p) for p in own.reshape(-1, 3)} == expected
    even, wide, wider, widest, narrow, narrower, narrowest, *_ = colours[::2, :3]
    np.testing.assert_array_equal(even, [1, 1, 1])
    assert wide[0] > wide[2] and narrow[2] > narrow[0]
    # A quarter wider and a fifth nearer are as far off: as much white is left.
    assert wide[2] > wider[2] and np.abs(wide[[1, 2]].mean() - narrow[[0, 1]].mean()) < 0.06
    np.testing.assert_allclose([wider, widest], [overlay.WIDE_COLOR[:3]] * 2, rtol=1e-6)
    np.testing.assert_allclose([narrower, narrowest], [overlay.NARROW_COLOR[:3]] * 2, rtol=1e-6)


def test_errors_that_are_shown_are_those_of_the_pattern():
    obj = scenes.quad_sphere(9)
    bpy.ops.synch.stripes(spacing=0.3, branching=0)
    [(_, colours)] = overlay.spacing_errors(obj)
    errors = scenes.attribute(obj, "synch_spacing_error")
    assert errors.max() > 0.1 and errors.min() < -0.1
    expected = np.repeat(overlay.error_colors(errors), 2, axis=0)
    np.testing.assert_allclose(colours, expected)


def set_loop(obj, *vertices):
    obj.synch_loop.edge = next(e.index for e in obj.data.edges if set(e.vertices) == set(vertices))


def test_a_loop_is_the_row_of_quads_across_an_edge():
    obj = scenes.grid(5)
    assert overlay.loop_faces(obj) == []
    # The edge between the vertices 2 and 3 of the rim; the row through it leads to the rim across.
    set_loop(obj, 2, 3)
    [(corners, colours)] = overlay.loop_faces(obj)
    assert corners.shape == (10, 3, 3) and (colours == overlay.LOOP_COLOR).all()
    ends = scenes.places(obj)[[2, 3]]
    axis = np.ptp(ends, axis=0).argmax()
    own, across = corners[..., axis], corners[..., 1 - axis]
    assert own.min() == ends[:, axis].min() and own.max() == ends[:, axis].max()
    assert (across.min(), across.max()) == (-1, 1)
    obj.synch_loop.edge = len(obj.data.edges)
    assert overlay.loop_faces(obj) == []


def test_a_loop_ends_at_a_triangle_and_none_passes_between_two():
    places = [(x, y, 0) for y in (0, 1) for x in range(4)] + [(4, 0.5, 0), (5, 1, 0)]
    faces = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 8, 7), (8, 9, 7)]
    obj = scenes.add_object(places, faces)
    set_loop(obj, 3, 7)
    [(corners, _)] = overlay.loop_faces(obj)
    assert len(corners) == 6 and corners[..., 0].max() == 3
    set_loop(obj, 7, 8)
    assert overlay.loop_faces(obj) == []


def spiral():
    """A band of 120 quads that is wound three times around, each turn beside the last one."""
    rings, count = 4, 40
    steps = np.arange(rings * count + 1)
    angles, radii = steps * 2 * np.pi / count, 1 + 0.1 * steps / count
    places = np.column_stack([radii * np.cos(angles), radii * np.sin(angles), 0 * radii])
    # Vertex k + count is the one above k, a turn later.
    first = steps[: (rings - 1) * count]
    faces = np.column_stack([first, first + count, first + count + 1, first + 1])
    return scenes.add_object(places.tolist(), faces.tolist())


def test_a_spiral_has_a_colour_of_its_own():
    obj = spiral()
    # It crosses each of the short rows from ring to ring three times; those are no spirals.
    set_loop(obj, 0, 40)
    [(corners, colours)] = overlay.loop_faces(obj)
    assert len(corners) == 240 and (colours == overlay.SPIRAL_COLOR).all()
    set_loop(obj, 0, 1)
    [(corners, colours)] = overlay.loop_faces(obj)
    assert len(corners) == 6 and (colours == overlay.LOOP_COLOR).all()


# When it is computed again, and when it is drawn


def test_key_changes_with_the_attribute_the_mesh_and_the_settings_only():
    obj = with_directions(scenes.grid(), np.tile([1.0, 0.0, 0.0], (169, 1)))
    bpy.context.view_layer.update()
    before = overlay_view.key(obj)

    def changed(change):
        nonlocal before
        change()
        bpy.context.view_layer.update()
        after = overlay_view.key(obj)
        result, before = before != after, after
        return result

    def turn_directions():
        obj.data.attributes["synch_direction"].data.foreach_set("vector", np.float32(np.tile([0, 1, 0], 169)))

    def set_(owner, name, value):
        return lambda: setattr(owner, name, value)

    assert changed(turn_directions)
    assert changed(set_(obj.data.vertices[0], "co", (0, 0, 1)))
    assert changed(set_(obj.synch, "symmetry", "CROSS"))
    assert changed(set_(obj.synch, "boundary", "ALONG"))
    assert changed(set_(obj.synch_loop, "edge", 4))
    assert changed(set_(obj, "scale", (1, 2, 1)))
    for name, value in (("location", (1, 2, 3)), ("rotation_euler", (0.1, 0.5, 2.0)), ("scale", (3, 6, 3))):
        assert not changed(set_(obj, name, value)), name
    assert not changed(lambda: None)


@pytest.mark.parametrize("change", ["solve", "edit mode"])
def test_key_changes_with_what_an_artist_does(change):
    obj = scenes.sphere()
    bpy.context.view_layer.update()
    before = overlay_view.key(obj)
    if change == "solve":
        bpy.ops.synch.directions()
    else:
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.mark_seam()
        bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert overlay_view.key(obj) != before


def test_drawing_changes_nothing_in_the_file():
    obj = scenes.sphere()
    bpy.ops.synch.stripes()
    before = scenes.snapshot()
    for compute in overlay_view._PARTS.values():
        compute(obj)
    assert scenes.snapshot() == before


def test_only_a_visible_mesh_is_shown_and_only_where_the_switch_is_on():
    obj = scenes.grid()
    scene = bpy.context.scene
    view = next(a.spaces.active for screen in bpy.data.screens for a in screen.areas if a.type == "VIEW_3D")

    def shown():
        view_layer = bpy.context.view_layer
        return overlay_view.shown_object(
            SimpleNamespace(
                active_object=view_layer.objects.active, space_data=view, scene=scene, view_layer=view_layer
            )
        )

    view.overlay.show_overlays = True
    assert shown() == obj  # its dots
    scene.synch_overlay.defects = False
    assert shown() is None
    scene.synch_overlay.show = True
    assert shown() == obj
    view.overlay.show_overlays = False
    assert shown() is None
    view.overlay.show_overlays = True
    obj.hide_set(True)
    assert shown() is None
    obj.hide_set(False)
    bpy.ops.object.mode_set(mode="EDIT")
    assert shown() is None


def test_parts_follow_the_switches():
    shown = bpy.context.scene.synch_overlay
    assert shown.parts == ["DEFECTS"]
    shown.show = True
    assert shown.parts == ["MARKS", "CONSTRAINTS", "PINS", "DEFECTS"]
    shown.directions, shown.defects, shown.constraints = "STREAMLINES", False, False
    assert shown.parts == ["STREAMLINES"]
    shown.directions = "NONE"
    assert shown.parts == []
    shown.spacing = shown.defects = True
    shown.loop = True
    assert shown.parts == ["SPACING", "LOOP", "DEFECTS"]


def test_taking_the_extension_out_leaves_no_handler_behind():
    def handlers():
        lists = [getattr(bpy.app.handlers, name) for name in dir(bpy.app.handlers)]
        return [h for handler_list in lists if isinstance(handler_list, list) for h in handler_list]

    before = handlers()
    ours = [h for h in before if h.__module__ == changes.__name__]
    assert len(ours) == 5
    synch_addon.unregister()
    try:
        assert not [h for h in handlers() if h in ours]
        assert not hasattr(bpy.types.Scene, "synch_overlay") and not hasattr(bpy.types, "SYNCH_PT_overlay")
    finally:
        synch_addon.register()
    assert handlers() == before


@pytest.mark.any_surface
def test_a_map_is_seen_while_it_is_painted_where_the_pattern_has_a_surface_of_its_own():
    """Blender draws weights on what modifiers leave, and that surface has none."""
    bpy.ops.mesh.primitive_cube_add(size=2)
    obj = bpy.context.active_object
    obj.vertex_groups.new(name="Map").add([0], 1.0, "REPLACE")
    bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
    assert overlay.painted_weights(obj) == []  # Blender shows it
    bpy.ops.object.mode_set(mode="OBJECT")
    api.stripes(obj, spacing=0.4)
    assert surface_of(obj) != obj and overlay.painted_weights(obj) == []
    bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
    ((corners, colours),) = overlay.painted_weights(obj)
    assert corners.shape == (12, 3, 3) and colours.shape == (12, 3, 4)
    is_painted = (corners == obj.data.vertices[0].co).all(axis=2)
    np.testing.assert_allclose(colours[is_painted], np.tile((1, 0, 0, 1), (is_painted.sum(), 1)))
    np.testing.assert_allclose(colours[~is_painted], np.tile((0, 0, 0.5, 1), ((~is_painted).sum(), 1)))
