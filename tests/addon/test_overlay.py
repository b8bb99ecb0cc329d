# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay in the viewport: marks and streamlines against closed forms, what it shows of an object, and when it
is computed again."""

from types import SimpleNamespace

import bpy
import gpu
import numpy as np
import pytest
from mathutils import Matrix
from scipy.spatial import Delaunay, cKDTree

from synch_fields import synch_addon
from synch_fields.core.extract import direction_glyphs, evenly_traced, trace
from synch_fields.core.geometry import TriangleMesh
from synch_fields.synch_addon import overlay, overlay_view, scene_io
from synch_fields.synch_addon.defect_empties import defect_empties

from . import scenes

SYMMETRIES = (1, 2, 4)


def disk(count=2000, seed=0):
    """A unit disk of scattered triangles, whose rim is a polygon."""
    random = np.random.default_rng(seed)
    places = 0.97 * np.sqrt(random.random(count)) * np.exp(2j * np.pi * random.random(count))
    rim = np.exp(2j * np.pi * np.arange(int(2 * np.sqrt(np.pi * count))) / int(2 * np.sqrt(np.pi * count)))
    return flat(np.concatenate([places, rim]))


def flat(places):
    """The Delaunay triangulation of complex numbers, counterclockwise."""
    points = np.column_stack([places.real, places.imag])
    triangles = Delaunay(points).simplices
    a, b, c = (places[triangles[:, k]] for k in range(3))
    turned = np.imag(np.conj(b - a) * (c - a))
    triangles[turned < 0] = triangles[turned < 0][:, ::-1]
    return TriangleMesh(np.column_stack([points, np.zeros(len(points))]), triangles[np.abs(turned) > 1e-12])


def representatives(directions, symmetry, seed=1):
    """(n, 3) vectors of complex directions, each turned by a random multiple of 2 pi / symmetry."""
    turns = np.random.default_rng(seed).integers(0, symmetry, len(directions))
    turned = directions * np.exp(2j * np.pi * turns / symmetry)
    return np.column_stack([turned.real, turned.imag, np.zeros(len(turned))])


def rotational(mesh, symmetry):
    """The field of circles around the origin."""
    places = mesh.vertices[:, 0] + 1j * mesh.vertices[:, 1]
    return representatives(1j * places / np.maximum(np.abs(places), 1e-12), symmetry)


def seeds_at(mesh, points):
    """Triangles that hold points of a flat mesh, and their barycentric coordinates there."""
    corners = mesh.vertices[mesh.triangles]
    triangles, weights = [], []
    for point in points:
        systems = np.concatenate([np.moveaxis(corners[:, :, :2], 1, 2), np.ones((len(corners), 1, 3))], axis=1)
        b = np.linalg.solve(systems, np.tile([*point, 1.0], (len(corners), 1))[:, :, None])[:, :, 0]
        triangles.append(b.min(axis=1).argmax())
        weights.append(b[triangles[-1]])
    return np.array(triangles), np.array(weights)


def line_lengths(mesh, lines):
    ends = lines.segments(mesh)
    return np.bincount(lines.line, np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))


# Streamlines


@pytest.mark.parametrize("symmetry", SYMMETRIES)
def test_constant_field_gives_straight_lines_from_rim_to_rim(symmetry):
    mesh = disk()
    vectors = representatives(np.full(mesh.vertex_count, np.exp(0.3j)), symmetry)
    points = np.array([(0.1, 0.2), (-0.5, 0.3), (0.0, -0.8)])
    lines = trace(mesh, vectors, symmetry, *seeds_at(mesh, points), 10.0)
    ends = lines.segments(mesh)[:, :, :2] @ [1, 1j]
    slopes = set()
    for line in np.unique(lines.line):
        pieces = ends[lines.line == line]
        seed = points[line % 3] @ [1, 1j]
        slope = pieces[-1, 1] - pieces[0, 0]
        slope /= np.abs(slope)
        slopes.add((line % 3, int(np.rint(np.angle(slope * np.exp(-0.3j)) / (np.pi / 2))) % (2 if symmetry > 1 else 4)))
        turned = (pieces - seed) / slope
        np.testing.assert_allclose(turned.imag, 0, atol=1e-9)
        assert (np.diff(turned.real, axis=1) >= 0).all()
        middle, height = (seed * np.conj(slope)).real, (seed * np.conj(slope)).imag
        chord = np.sqrt(1 - height**2)  # of the unit circle, but for the rim's corners
        np.testing.assert_allclose(turned.real[[0, -1], [0, 1]] + middle, [-chord, chord], atol=5e-3)
    assert slopes == {(seed, turn) for seed in range(3) for turn in ((0, 1) if symmetry == 4 else (0,))}


@pytest.mark.parametrize("symmetry", SYMMETRIES)
def test_rotational_field_gives_circles(symmetry):
    """Representatives have random signs and quarter turns, which must not be seen."""
    worst = []
    for count in (1000, 4000):
        mesh = disk(count)
        radii = np.array([0.4, 0.6, 0.8])
        seeds = seeds_at(mesh, [(r, 0.0) for r in radii])
        lines = trace(mesh, rotational(mesh, symmetry), symmetry, *seeds, 2 * np.pi * 0.9)
        # Second lines of crosses are the radii.
        circles = lines[lines.line < 3] if symmetry != 4 else lines[_is_round(mesh, lines)]
        ends = circles.segments(mesh)
        away = np.abs(np.linalg.norm(ends, axis=2) - radii[circles.line % 3][:, None])
        worst.append(away.max())
        if symmetry != 4:
            np.testing.assert_allclose(line_lengths(mesh, lines), 2 * np.pi * 0.9)
    assert worst[0] < 0.02 and worst[1] < 0.006


def _is_round(mesh, lines):
    """Pieces of those lines that begin across the radius."""
    ends = lines.segments(mesh)[lines.step == 0]
    across = np.abs(ends[:, 1, 1] - ends[:, 0, 1]) > np.abs(ends[:, 1, 0] - ends[:, 0, 0])
    return across[lines.line]


def test_pieces_of_a_line_follow_one_another_and_stay_in_their_triangles():
    mesh = disk()
    lines = evenly_traced(mesh, rotational(mesh, 2), 2, 100)
    assert lines.weights.min() >= 0
    np.testing.assert_allclose(lines.weights.sum(axis=2), 1)
    ends = lines.segments(mesh)
    same = np.diff(lines.line) == 0
    assert (np.diff(lines.step)[same] == 1).all()
    np.testing.assert_allclose(ends[1:, 0][same], ends[:-1, 1][same], atol=1e-9)


def test_lines_on_a_coarse_cylinder_follow_its_helices():
    """Directions turn with the surface, from vertex to triangle and across edges: the pitch stays."""
    turns, rings, height = 8, 20, 2.0
    angle, z = np.meshgrid(2 * np.pi * np.arange(turns) / turns, np.linspace(0, height, rings))
    vertices = np.column_stack([np.cos(angle).ravel(), np.sin(angle).ravel(), z.ravel()])
    i, j = (a.ravel() for a in np.meshgrid(np.arange(turns), np.arange(rings - 1)))
    a, b = j * turns + i, j * turns + (i + 1) % turns
    mesh = TriangleMesh(
        vertices, np.concatenate([np.column_stack([a, b, b + turns]), np.column_stack([a, b + turns, a + turns])])
    )
    around = np.column_stack([-vertices[:, 1], vertices[:, 0], 0 * vertices[:, 0]])
    vectors = np.cos(0.5) * around + np.sin(0.5) * np.array([0, 0, 1])
    middle = np.flatnonzero(np.abs(mesh.vertices[mesh.triangles].mean(axis=1)[:, 2] - 1) < 0.05)[:5]
    lines = trace(mesh, vectors, 2, middle, np.full((len(middle), 3), 1 / 3), 100.0)
    assert lines.segments(mesh)[:, :, 2].max() == pytest.approx(height)
    np.testing.assert_allclose(line_lengths(mesh, lines), height / np.sin(0.5), rtol=1e-6)


def test_lines_lie_at_even_distances():
    """No point is far from a line, and no line lies on another."""
    mesh = disk(4000)
    lines = evenly_traced(mesh, representatives(np.ones(mesh.vertex_count, complex), 2), 2, 100)
    ends = lines.segments(mesh)
    apart = np.sqrt(np.pi) / 32
    assert cKDTree(ends.mean(axis=1)).query(mesh.vertices)[0].max() < 3 * apart
    extents = [
        (pieces[0, 0, 1], *np.sort(pieces[:, :, 0].ravel())[[0, -1]])
        for pieces in (ends[lines.line == line] for line in np.unique(lines.line))
    ]
    assert len(extents) > 30
    for k, (height, low, high) in enumerate(extents):
        for other_height, other_low, other_high in extents[:k]:
            overlap = min(high, other_high) - max(low, other_low)
            assert abs(height - other_height) > 0.3 * apart or overlap < 0.5 * apart


def test_line_that_circles_a_corner_ends():
    """A field that points at a vertex from all sides: lines neither run for ever nor leave the mesh."""
    mesh = disk(300)
    places = mesh.vertices[:, 0] + 1j * mesh.vertices[:, 1]
    spiral = places / np.maximum(np.abs(places), 1e-12) * np.exp(0.5j * np.pi * 0.98)
    lines = trace(mesh, representatives(-spiral, 1), 1, *seeds_at(mesh, [(0.3, 0.1), (0.0, 0.02)]), 50.0)
    assert np.linalg.norm(lines.segments(mesh), axis=2).max() < 1 + 1e-9
    assert len(lines.line) < 1e5


# Marks


@pytest.mark.parametrize(("symmetry", "segments"), [(1, 3), (2, 1), (4, 2)])
def test_marks_lie_above_the_surface_and_show_the_symmetry(symmetry, segments):
    mesh = disk(500)
    marks = direction_glyphs(mesh, representatives(np.full(mesh.vertex_count, np.exp(0.7j)), 1), symmetry, 10**6)
    count = len(marks) // segments
    assert len(marks) == segments * count and count > 0.5 * mesh.vertex_count
    assert (marks[:, :, 2] > 0).all()
    shafts = (marks[:, 1] - marks[:, 0])[:count]
    np.testing.assert_allclose(np.angle(shafts[:, 0] + 1j * shafts[:, 1]), 0.7)
    centres = marks[:count].mean(axis=1)
    assert cKDTree(mesh.vertices[:, :2]).query(centres[:, :2])[0].max() < 1e-9
    if symmetry == 4:
        bars = (marks[:, 1] - marks[:, 0])[count:]
        np.testing.assert_allclose(np.einsum("ij,ij->i", shafts, bars), 0, atol=1e-9)
    if symmetry == 1:
        np.testing.assert_allclose(marks[count:, 0], np.tile(marks[:count, 1], (2, 1)))


def test_marks_are_thinned_evenly_on_a_dense_mesh():
    mesh = disk(20000)
    marks = direction_glyphs(mesh, representatives(np.ones(mesh.vertex_count, complex), 2), 2, 300)
    assert 150 < len(marks) <= 300
    distances = cKDTree(marks.mean(axis=1)[:, :2]).query(mesh.vertices[:, :2])[0]
    assert distances.max() < 2.5 * np.sqrt(np.pi / len(marks))


def test_vertices_without_a_direction_have_no_mark():
    mesh = disk(100)
    vectors = representatives(np.ones(mesh.vertex_count, complex), 2)
    vectors[5:] = 0
    assert 1 <= len(direction_glyphs(mesh, vectors, 2, 100)) <= 5
    assert direction_glyphs(mesh, 0 * vectors, 2, 100).shape == (0, 2, 3)


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
    areas = scene_io.read_mesh(obj).mesh.areas
    assert areas.min() == 0
    for compute in (overlay.direction_marks, overlay.direction_lines):
        [(points, _)] = compute(obj)
        assert len(points) > 8 and np.isfinite(points).all()


def test_defects_lie_where_the_empties_do_and_have_their_colours():
    obj = scenes.quad_sphere(9)
    assert bpy.ops.synch.stripes(spacing=0.3) == {"FINISHED"}
    empties = defect_empties(obj)
    layers = overlay.defect_points(obj)
    assert sum(len(places) for places, _ in layers) == len(empties) > 8
    for places, colour in layers:
        alike = [e for e in empties if np.allclose(e.color, colour)]
        assert len(alike) == len(places)
        # A disclination is shown at the middle of its quad, its empty lies in one of its triangles.
        tolerance = 0.1 if alike[0]["synch_kind"] == "disclination" else 1e-5
        assert cKDTree([e.location for e in alike]).query(places)[0].max() < tolerance


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
    for compute in (overlay.direction_marks, overlay.direction_lines, overlay.defect_points, overlay.constraint_lines):
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
    assert shown.parts == ["MARKS", "CONSTRAINTS", "DEFECTS"]
    shown.directions, shown.defects, shown.constraints = "STREAMLINES", False, False
    assert shown.parts == ["STREAMLINES"]
    shown.directions = "NONE"
    assert shown.parts == []


def test_taking_the_extension_out_leaves_no_handler_behind():
    def handlers():
        lists = [getattr(bpy.app.handlers, name) for name in dir(bpy.app.handlers)]
        return [h for handler_list in lists if isinstance(handler_list, list) for h in handler_list]

    before = handlers()
    ours = [h for h in before if h.__module__ == overlay_view.__name__]
    assert len(ours) == 4
    synch_addon.unregister()
    try:
        assert not [h for h in handlers() if h in ours]
        assert not hasattr(bpy.types.Scene, "synch_overlay") and not hasattr(bpy.types, "SYNCH_PT_overlay")
    finally:
        synch_addon.register()
    assert handlers() == before


# Pixels


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
