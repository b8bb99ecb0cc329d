# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh of a quad pattern's grid lines as an object: where it is, its shape and its figures."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from synch_fields.core.errors import SettingError
from synch_fields.core.extract.quads.finishing import finish_quads
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import meshes

from ..constrained_sheet import line_upright, sheet
from ..quad_meshes import (
    corner_vertices,
    cube,
    distances,
    ends,
    euler_characteristic,
    half_edges,
    in_world,
    is_closed,
    is_manifold,
    made_from,
    mark_sharp,
    mixed_sphere,
    poked,
    surface,
)
from ..scenes import (
    add_object,
    grid,
    hexagon_sphere,
    make_active,
    mark_edges,
    places,
    quad_sphere,
    snapshot,
    sphere,
    torus,
    tube,
)


def monkey():
    """Blender's Suzanne, whose eyes are pieces of their own."""
    bpy.ops.mesh.primitive_monkey_add()
    return bpy.context.active_object


CLOSED = [sphere, quad_sphere, hexagon_sphere, mixed_sphere, torus]
MESHES = [*CLOSED, grid, tube, monkey]
SMOOTHINGS = [0, 3]


# Where it is


@pytest.mark.parametrize("visible", ["root", "two collections"])
def test_the_new_object_takes_the_place_of_the_given_one(visible):
    obj, other = sphere(), grid()
    obj.name, obj.data.name = "Body", "Skin"
    obj.location, obj.rotation_euler, obj.scale = (1, 2, 3), (0.3, 0.2, 0.1), (1.5, -1, 0.7)
    obj.display_type = "WIRE"
    if visible == "two collections":
        for name in ("One", "Two"):
            collection = bpy.data.collections.new(name)
            bpy.context.scene.collection.children.link(collection)
            collection.objects.link(obj)
        bpy.context.scene.collection.objects.unlink(obj)
    other.select_set(True)
    make_active(obj)
    before = snapshot()
    made, report = made_from(obj, spacing=0.7)
    assert made.name == report["quad_mesh"]["object"] == "Body Quads" and made.data.name == "Skin Quads"
    assert made.data != obj.data and made.data.users == 1
    assert set(made.users_collection) == set(obj.users_collection)
    np.testing.assert_allclose(made.matrix_world, obj.matrix_world, atol=1e-6)
    assert made.display_type == "WIRE" and made.parent is None
    assert obj.hide_get() and obj.hide_render and not obj.select_get()
    assert not made.hide_get() and not made.hide_render and made.select_get()
    assert bpy.context.view_layer.objects.active == made
    # Nothing is written to the given mesh, nor to any other.
    after = snapshot()
    assert {name: after["meshes"][name] for name in before["meshes"]} == before["meshes"]
    assert set(after["objects"]) - set(before["objects"]) == {"Body Quads"}
    assert after["materials"] == before["materials"] and after["node groups"] == before["node groups"]


def test_a_sheared_object_keeps_its_place():
    """A parent that is scaled differently along its axes shears what is turned in it."""
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.scale = (1, 3, 1)
    obj = sphere()
    obj.parent, obj.rotation_euler = parent, (0.3, 0.5, 0.7)
    bpy.context.view_layer.update()
    made, _ = made_from(obj, spacing=1.0)
    tree, _ = surface(add_object(in_world(obj), [p.vertices[:] for p in obj.data.polygons]))
    assert distances(tree, in_world(made)).max() < 1e-5


def test_an_object_whose_collection_is_not_in_view_gets_its_quads_there():
    obj = sphere()
    collection = bpy.data.collections.new("Away")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(obj)
    bpy.context.scene.collection.objects.unlink(obj)
    bpy.context.view_layer.layer_collection.children["Away"].exclude = True
    made, _ = made_from(obj, spacing=0.7)
    assert set(collection.objects) == {obj, made} and obj.hide_render


def test_a_second_run_makes_a_second_object_and_the_same_mesh():
    obj = torus()
    first, _ = made_from(obj, spacing=0.4, seed=3)
    second, report = made_from(obj, spacing=0.4, seed=3)
    assert first != second and first.data != second.data and report["object"] == obj.name
    np.testing.assert_array_equal(places(first), places(second))
    np.testing.assert_array_equal(corner_vertices(first), corner_vertices(second))
    assert not first.hide_get() and not second.hide_get()


# On the surface


@pytest.mark.parametrize("build", MESHES)
def test_the_mesh_is_sound_on_the_surface_and_shaped_like_it(build):
    obj = build()
    obj.scale, obj.rotation_euler, obj.location = (2, -0.6, 1.3), (0.3, 0.5, 0.7), (1, 2, 3)
    made, report = made_from(obj, spacing=0.5, smoothing=3)
    check_on_surface(made, obj)
    assert not made.data.validate(verbose=True), "Blender finds something to mend"
    assert is_manifold(made)
    assert is_closed(made) == is_closed(obj) == (build in CLOSED) == report["quad_mesh"]["closed"]
    assert euler_characteristic(made) == euler_characteristic(obj) == report["quad_mesh"]["euler_characteristic"]
    assert len(np.unique(corner_vertices(made))) == len(made.data.vertices), "no loose vertices"
    areas = np.array([p.area for p in made.data.polygons])
    assert areas.min() > 0


@pytest.mark.parametrize("build", [torus, tube])
def test_vertices_lie_on_the_surface_before_smoothing(build):
    obj = build()
    made, _ = made_from(obj, spacing=0.5, smoothing=0)
    check_on_surface(made, obj)


def check_on_surface(made, obj):
    tree, _ = surface(obj)
    assert len(made.data.vertices) > 20
    assert distances(tree, places(made)).max() < 1e-6 * max(np.ptp(places(obj), axis=0))


@pytest.mark.parametrize(
    ("build", "scale", "smoothing"),
    [(sphere, (1, 1, 1), 0), (torus, (-1, 1, 1), 0), (tube, (1, 1, 1), 3), (mixed_sphere, (-1, 1, 1), 3)],
)
def test_faces_look_the_same_way_as_those_of_the_surface(build, scale, smoothing):
    obj = build()
    obj.scale = scale
    made, _ = made_from(obj, spacing=0.4, smoothing=smoothing)
    tree, normals = surface(obj)
    cosines = []
    for polygon in made.data.polygons:
        _, _, _, distance = tree.find_nearest(polygon.center)
        # Of an n-gon's triangles some are thin, and look anywhere.
        around = [triangle for _, _, triangle, _ in tree.find_nearest_range(polygon.center, distance + 0.1)]
        cosines.append(np.median(normals[around] @ np.array(polygon.normal)))
    assert min(cosines) > 0.5
    assert (np.linalg.det(np.array(made.matrix_world)[:3, :3]) < 0) == (scale[0] < 0)


def test_smoothing_does_not_wear_a_thin_plate_away():
    """Nor turn its rim inside out."""
    obj, _ = cube()
    obj.data.vertices.foreach_set("co", (places(obj) * (1, 1, 0.02)).astype(np.float32).ravel())
    obj.data.update()
    areas = []
    for smoothing in SMOOTHINGS:
        made, _ = made_from(obj, spacing=0.5, smoothing=smoothing)
        areas.append(sum(p.area for p in made.data.polygons))
        upright = [p for p in made.data.polygons if abs(p.normal.z) > 0.9 and abs(p.center.z) > 0.01]
        assert len(upright) > 80 and all(p.normal.z * p.center.z > 0 for p in upright)
    assert areas[1] == pytest.approx(areas[0], rel=0.1)


# What lines are for


@pytest.mark.parametrize(("aspect", "smoothing"), [(1.0, 0), (2.0, 3)])
def test_a_flat_square_with_lines_on_its_sides_becomes_a_regular_lattice(aspect, smoothing):
    obj = grid(16)
    made, report = made_from(obj, spacing=0.5, aspect=aspect, boundary="phase", smoothing=smoothing)
    steps = np.array([0.25, 0.25 * aspect])
    numbers = (places(made)[:, :2] + 1) / steps
    np.testing.assert_allclose(numbers, np.round(numbers), atol=1e-5)
    rows, columns = 1 + 2 / steps
    assert len(made.data.vertices) == len(np.unique(np.round(numbers), axis=0)) == rows * columns
    rims = {tuple(sorted(map(tuple, np.round(numbers[list(p.vertices)]).astype(int)))) for p in made.data.polygons}
    cells = [(i, j) for i in range(int(rows) - 1) for j in range(int(columns) - 1)]
    assert rims == {tuple(sorted([(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)])) for i, j in cells}
    figures = report["quad_mesh"]
    assert (figures["quad_share"], figures["irregular_vertices"]) == (1, 0)
    assert figures["angle_deviation"] < 1e-3 and figures["hausdorff_distance"] < 1e-6
    assert figures["edge_length"] == pytest.approx(0.25 if aspect == 1 else (80 * 0.25 + 76 * 0.5) / 156, rel=0.05)


@pytest.mark.parametrize("place, smoothing", [("seams", 0), ("boundary", 3), ("group", 3), ("curve", 20)])
def test_edges_lie_on_lines_that_are_asked_for(place, smoothing):
    obj = sheet()
    row, at, _ = line_upright(obj, place)
    made, _ = made_from(obj, spacing=0.4, constraints=[row | {"what": "phase"}], smoothing=smoothing)
    on_line = np.abs(places(made)[:, 0] - at) < 1e-5
    chain = on_line[ends(made)].all(axis=1)
    heights = places(made)[ends(made)[chain]][:, :, 1]
    assert np.abs(np.diff(heights, axis=1)).sum() == pytest.approx(1.2, abs=1e-5), "from end to end"


@pytest.mark.parametrize("smoothing", SMOOTHINGS)
def test_vertices_on_the_boundary_stay_there(smoothing):
    obj = tube()
    made, _ = made_from(obj, spacing=0.45, smoothing=smoothing)
    around = half_edges(made)
    rim = {vertex for pair in around if pair[::-1] not in around for vertex in pair}
    heights = places(made)[sorted(rim), 2]
    np.testing.assert_allclose(np.minimum(heights, 2 - heights), 0, atol=1e-6)
    assert (heights < 1).any() and (heights > 1).any()
    inside = np.delete(places(made), sorted(rim), axis=0)[:, 2]
    assert inside.min() > 1e-3 and inside.max() < 2 - 1e-3


@pytest.mark.parametrize("smoothing", SMOOTHINGS)
def test_a_cut_tears_the_mesh_along_its_edges(smoothing):
    obj = tube()
    mark_edges(obj, "seams", np.arange(24 * 9) // 24 == 4)
    rows = [{"where": "seams", "what": "cut"}]
    made, report = made_from(obj, spacing=0.45, smoothing=smoothing, constraints=rows)
    around = half_edges(made)
    rim = np.array([pair for pair in around if pair[::-1] not in around])
    heights = places(made)[rim[:, 0], 2]
    assert {round(z, 4) for z in heights.tolist()} == {0.0, 1.0, 2.0}
    assert is_manifold(made) and euler_characteristic(made) == 0
    assert not (np.array([p.center.z for p in made.data.polygons]) == 1).any()
    sides = np.sign(places(made)[:, 2] - 1)
    sides[np.abs(places(made)[:, 2] - 1) < 1e-5] = 0
    assert not any({-1, 1} <= set(sides[list(p.vertices)]) for p in made.data.polygons)
    pieces = [sum(1 for p in made.data.polygons if (p.center.z > 1) == upper) for upper in (True, False)]
    assert min(pieces) > 50 and report["quad_mesh"]["faces"] == sum(pieces)


def test_a_cube_with_lines_on_its_edges_has_its_corners():
    obj, _ = cube()
    middles = places(obj)[ends(obj)].mean(axis=1)
    mark_sharp(obj, (np.abs(middles) > 1 - 1e-6).sum(axis=1) == 2)
    made, report = made_from(obj, spacing=0.5, constraints=[{"where": "sharp", "what": "phase"}])
    figures = report["quad_mesh"]
    assert (figures["vertices"], figures["faces"], figures["irregular_vertices"]) == (386, 384, 8)
    on_sides = (np.abs(places(made)) > 1 - 1e-5).sum(axis=1)
    valences = np.bincount(ends(made).ravel())
    assert (valences == 3).sum() == 8 and (on_sides == 2).sum() >= 12 * 7
    assert figures["hausdorff_distance"] < 0.15
    corners = places(made)[valences == 3]
    np.testing.assert_allclose(np.abs(corners), 1, atol=0.15)


@pytest.mark.parametrize("axis, smoothing", [(0, 0), (1, 3)])
def test_a_mirror_makes_the_mesh_its_own_mirror_image(axis, smoothing):
    """But around disclinations that lie beside the mirror: their triangles have no partners."""
    obj = poked(torus())
    made, _ = made_from(obj, spacing=0.5, mirror="XY"[axis], smoothing=smoothing)
    here = places(made)
    image = here * np.where(np.arange(3) == axis, -1, 1)
    distances = np.linalg.norm(image[:, None] - here[None], axis=2)
    irregular = np.bincount(ends(made).ravel()) != 4
    alone = here[irregular & (distances.min(axis=1) > 1e-4) & (np.abs(here[:, axis]) < 0.1)]
    away = (np.linalg.norm(here[:, None] - alone[None], axis=2) > 0.5).all(axis=1)
    assert away.mean() > 0.8 and distances[away].min(axis=1).max() < 1e-4


@pytest.mark.any_surface
def test_the_positive_side_is_mirrored_where_triangles_differ():
    """Groups stay on their side: the mesh that is made has those of the object where it is."""
    obj = sphere()
    turn = Matrix.Rotation(0.4, 4, "X") @ Matrix.Rotation(0.7, 4, "Z")
    obj.data.transform(turn)
    right = obj.vertex_groups.new(name="right")
    right.add(np.flatnonzero(places(obj)[:, 0] < -0.1).tolist(), 1.0, "REPLACE")
    before = places(obj)
    made, report = made_from(obj, faces=300, mirror="X")
    assert np.array_equal(places(obj), before) and is_closed(made) and is_manifold(made)
    here = places(made)
    apart = np.linalg.norm(here[:, None] * [-1, 1, 1] - here[None], axis=2).min(axis=1)
    assert apart.max() < 1e-5
    assert any("positive side is mirrored, up to 0.0" in line for line in report["warnings"])
    members = np.array([any(group.weight > 0.5 for group in vertex.groups) for vertex in made.data.vertices])
    assert members[here[:, 0] < -0.3].all() and not members[here[:, 0] > 0.1].any()


# Figures


@pytest.mark.parametrize("build", [torus, tube])
def test_figures_are_those_of_the_object(build):
    obj = build()
    obj.scale = (2, 1, 1)
    made, report = made_from(obj, spacing=0.5)
    figures = report["quad_mesh"]
    x, polygons = in_world(made), [p.vertices[:] for p in made.data.polygons]
    lengths = [math.dist(x[a], x[b]) for a, b in ends(made)]
    angles = []
    for rim in polygons:
        up = sum(np.cross(x[here], x[after]) for here, after in zip(rim, rim[1:] + rim[:1], strict=True))
        for before, here, after in zip(rim[-1:] + rim[:-1], rim, rim[1:] + rim[:1], strict=True):
            a, b = x[before] - x[here], x[after] - x[here]
            angle = math.degrees(math.acos(np.clip(a @ b / np.linalg.norm(a) / np.linalg.norm(b), -1, 1)))
            angles.append(angle if np.cross(b, a) @ up > 0 else 360 - angle)
    around = half_edges(made)
    rim = {vertex for pair in around if pair[::-1] not in around for vertex in pair}
    valences = np.bincount(ends(made).ravel())
    expected = {
        "vertices": len(x),
        "edges": len(lengths),
        "faces": len(polygons),
        "quad_share": sum(len(p) == 4 for p in polygons) / len(polygons),
        "irregular_vertices": sum(v != 4 for k, v in enumerate(valences.tolist()) if k not in rim),
        "angle_deviation": np.mean(np.abs(np.array(angles) - 90)),
        "worst_angle": np.max(np.abs(np.array(angles) - 90)),
        "edge_length": np.mean(lengths),
        "length_spread": np.std(lengths) / np.mean(lengths),
    }
    assert {name: figures[name] for name in expected} == pytest.approx(expected, rel=1e-3, abs=1e-4)


@pytest.mark.parametrize("build", [sphere, tube])
def test_distance_from_the_surface_is_the_largest_both_ways(build):
    obj = build()
    made, report = made_from(obj, spacing=0.6)
    there = distances(surface(obj)[0], [p.center for p in made.data.polygons]).max()
    back = distances(surface(made)[0], places(obj)).max()
    # Faces are not flat, and Blender may halve them another way.
    assert report["quad_mesh"]["hausdorff_distance"] == pytest.approx(max(there, back), rel=0.2)
    assert there > 0.01 and back > 0.01


def test_a_free_boundary_keeps_its_corners():
    obj = grid(24)
    made, report = made_from(obj, spacing=0.55, guidance="axis:X")
    assert report["quad_mesh"]["hausdorff_distance"] < 1e-6
    assert sum(p.area for p in made.data.polygons) == pytest.approx(4, rel=1e-5)


def test_smoothing_makes_angles_right_and_changes_no_face():
    obj = torus()
    rough, plain = made_from(obj, spacing=0.3, smoothing=0)
    smooth, better = made_from(obj, spacing=0.3, smoothing=10)
    np.testing.assert_array_equal(corner_vertices(rough), corner_vertices(smooth))
    assert better["quad_mesh"]["angle_deviation"] < 0.99 * plain["quad_mesh"]["angle_deviation"]


def test_a_spacing_at_which_nothing_crosses_is_refused():
    obj = sphere()
    before = snapshot()
    with pytest.raises(SettingError, match="no grid lines cross on the mesh: reduce the spacing"):
        api.quad_mesh(obj, spacing=3.4)
    assert snapshot() == before and not obj.hide_get() and not obj.hide_render


@pytest.mark.parametrize("spacing", [0.9, 1.5, 2.5])
def test_a_handle_is_never_lost(spacing):
    """Where quads are longer than half the way around, there is no such mesh."""
    obj = torus()
    before = snapshot()
    try:
        made, _ = made_from(obj, spacing=spacing)
    except SettingError as refusal:
        assert "reduce the spacing" in str(refusal) and spacing >= 1.5
        assert snapshot() == before
    else:
        assert is_manifold(made) and is_closed(made) and euler_characteristic(made) == 0


def test_quads_around_a_ball_are_no_mesh_of_a_torus():
    """Those of a cube, which meet nowhere twice, for a sphere and for a torus."""
    corners = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    quads = QuadMesh(np.zeros((8, 3)), np.zeros(8, int), np.full((8, 3), 1 / 3), corners.ravel(), np.full(6, 4))
    assert not quads.is_unsound.any() and quads.euler_characteristic == 2
    for build, refused in ((torus, True), (sphere, False)):
        mesh = meshes.read_mesh(build()).mesh
        if refused:
            with pytest.raises(SettingError, match="a handle of it would be lost: reduce the spacing"):
                finish_quads(quads, mesh, (), 0)
        else:
            assert finish_quads(quads, mesh, (), 0) is quads
