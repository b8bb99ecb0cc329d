# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh too coarse for its spacing: the panel says so, and subdivides it with all that is on it."""

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.core.refinement.spacing import automatic_spacing, carried_spacing, lines_in_period
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import groups, meshes
from synch_fields.synch_addon.blender.translations import translate
from synch_fields.synch_addon.patterns import refine

from ..run_commands import undo_and_redo
from ..scenes import (
    add_group,
    add_object,
    attribute,
    grid,
    mark_edges,
    places,
    quad_sphere,
    set_numbers,
    snapshot,
    sphere,
    tube,
)


class Layout:
    """Collects what a panel draws."""

    def __init__(self):
        self.lines = []

    def box(self):
        return self

    def column(self, **_):
        return self

    def label(self, text, **_):
        self.lines.append(text)

    def operator(self, name, text="", **_):
        self.lines.append((name, text))
        return self


def warning(obj):
    """What the panel says where the object's own faces are to carry the pattern."""
    layout, obj.synch.surface = Layout(), "FACES"
    refine.draw_warning(layout, obj)
    return layout.lines, getattr(layout, "levels", 0)


@pytest.mark.parametrize("build", [sphere, tube, quad_sphere, grid])
@pytest.mark.parametrize("scale", [(1, 1, 1), (3, 0.5, 1)])
def test_what_the_panel_sees_is_what_the_automatic_spacing_takes(build, scale):
    obj = build()
    obj.scale = scale
    bpy.context.view_layer.update()
    exact = carried_spacing(meshes.read_mesh(obj).mesh.edge_lengths)
    assert refine.mesh_detail(obj).spacing == pytest.approx(exact, rel=0.1)


def test_the_faces_that_are_expected_are_more_where_the_map_is_finer():
    """A map that halves the edges on half of a square: two and a half times as many quads."""
    obj = grid(40)
    few = refine.expected_faces(obj, obj.synch)
    add_group(obj, "finer", [vertex.index for vertex in obj.data.vertices if vertex.co.x > 0])
    obj.synch.spacing_map, obj.synch.spacing_range = "finer", 0.5
    assert refine.expected_faces(obj, obj.synch) == pytest.approx(2.5 * few, rel=0.05)
    obj.synch.surface = "FACES"
    expected = refine.expected_faces(obj, obj.synch)
    api.quad_mesh(obj, spacing_map="finer", spacing_range=0.5, surface="faces")
    assert len(bpy.context.active_object.data.polygons) == pytest.approx(expected, rel=0.15)


@pytest.mark.parametrize("command", ["stripes", "quads"])
@pytest.mark.parametrize("build", [sphere, tube, grid])
def test_the_panel_tells_the_automatic_spacing(build, command):
    obj = build()
    obj.scale = (3, 0.5, 1)
    add_group(obj, "finer", range(len(obj.data.vertices)))
    obj.synch.spacing_map, obj.synch.spacing_range = "finer", 0.25  # multiplies what is told
    bpy.context.view_layer.update()
    exact = automatic_spacing(meshes.read_mesh(obj).mesh, lines_in_period(command))
    assert refine.expected_spacing(command, obj) == pytest.approx(exact, rel=0.1)


def test_what_the_panel_tells_is_a_length_in_the_units_of_the_scene():
    obj, layout = grid(), Layout()
    refine.draw_expected_spacing(layout, "stripes", obj)
    told = refine.expected_spacing("stripes", obj)
    assert layout.lines == [translate("About {length} apart", length=f"{told:.3g} m")]
    told = refine.expected_spacing("quads", obj)  # that of two lines
    refine.draw_expected_spacing(layout, "quads", obj)
    assert layout.lines.pop() == translate("About {length} for two quads", length=f"{told:.3g} m")
    refine.draw_expected_spacing(layout, "quad_mesh", obj)
    assert layout.lines.pop() == translate("Edges of about {length}", length=f"{told / 2:.3g} m")
    obj.synch.automatic_spacing = False
    refine.draw_expected_spacing(layout, "stripes", obj)
    assert len(layout.lines) == 1


def test_a_sample_of_many_faces_is_close():
    obj = sphere(5)
    obj.data.transform(((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 3, 0), (0, 0, 0, 1)))
    exact = carried_spacing(meshes.read_mesh(obj).mesh.edge_lengths)
    assert len(obj.data.polygons) > 8 * refine.FACES_SEEN
    assert refine.mesh_detail(obj).spacing == pytest.approx(exact, rel=0.1)


@pytest.mark.parametrize("automatic", [False, True])
def test_no_warning_where_most_edges_have_no_length(automatic):
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), *[(0, 0, 0)] * 300]
    obj = add_object(corners, np.arange(303).reshape(-1, 3))
    obj.synch.automatic_spacing = automatic
    assert refine.mesh_detail(obj).spacing == 0 and refine.mesh_detail(obj).size == 1
    assert warning(obj) == ([], 0)


def test_warning_appears_where_the_spacing_is_too_fine_and_goes_after_subdividing():
    obj = grid()
    obj.synch.automatic_spacing = False
    obj.synch.spacing = 1.0
    assert warning(obj) == ([], 0)
    obj.synch.spacing = 0.2
    (label, button), levels = warning(obj)
    assert label.startswith(translate("Coarse mesh: carries {spacing}", spacing=""))
    assert button == ("synch.refine", translate("Subdivide to {count:,} Faces", count=2304))
    assert bpy.ops.synch.refine(levels=levels) == {"FINISHED"}
    bpy.context.view_layer.update()
    assert len(obj.data.polygons) == 2304
    assert warning(obj) == ([], 0)
    report = api.stripes(obj, spacing=0.2, method="spectral")
    assert not report["warnings"]


def test_no_warning_where_the_pattern_has_a_surface_of_its_own():
    bpy.ops.mesh.primitive_cube_add()
    layout = Layout()
    refine.draw_warning(layout, bpy.context.active_object)
    assert not layout.lines


def test_automatic_spacing_warns_of_few_lines():
    bpy.ops.mesh.primitive_cube_add()
    obj = bpy.context.active_object
    assert warning(obj)[0][0] == translate("Coarse mesh: about one line across")
    report = api.refine(obj)
    bpy.context.view_layer.update()
    assert report["faces"] == len(obj.data.polygons) == 24 * 4 ** (report["levels"] - 1)
    assert warning(obj) == ([], 0)


def test_spacing_map_counts():
    obj = grid()
    obj.synch.automatic_spacing = False
    obj.synch.spacing = 1.0
    set_numbers(obj, "factor", np.full(len(obj.data.vertices), 0.1))
    obj.synch.spacing_map = "factor"
    assert warning(obj)[1] == 3
    add_group(obj, "wide", range(len(obj.data.vertices)))
    obj.synch.spacing_map, obj.synch.spacing_range = "wide", 4.0
    assert warning(obj)[1] == 0


def test_moved_vertices_are_seen():
    obj = grid()
    before = refine.mesh_detail(obj).spacing
    obj.data.transform(((3, 0, 0, 0), (0, 3, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)))
    obj.data.update()
    bpy.context.view_layer.update()
    assert refine.mesh_detail(obj).spacing == pytest.approx(3 * before, rel=1e-5)


@pytest.mark.parametrize("build", [sphere, quad_sphere])
def test_everything_on_the_mesh_goes_over(build):
    obj = build()
    corners = np.array([loop.vertex_index for loop in obj.data.loops])
    before = places(obj)
    # Linear in the position: what is interpolated has to be it again.
    layer = obj.data.uv_layers.new(name="Map")
    layer.uv.foreach_set("vector", np.float32(before[corners][:, :2]).ravel())
    set_numbers(obj, "height", before[:, 2])
    add_group(obj, "upper", np.flatnonzero(before[:, 2] > 0))
    mark_edges(obj, "seams", np.abs(before[:, 2]) < 0.3)
    obj.data.materials.append(bpy.data.materials.new("Mine"))
    area = sum(p.area for p in obj.data.polygons)
    seams = sum(e.use_seam for e in obj.data.edges)
    api.refine(obj, 2)
    now = places(obj)
    assert np.allclose(now[: len(before)], before, atol=1e-6)
    assert len(obj.data.polygons) == 4 * len(corners)
    assert sum(p.area for p in obj.data.polygons) == pytest.approx(area, rel=1e-4 if build is sphere else 1e-2)
    corners = np.array([loop.vertex_index for loop in obj.data.loops])
    assert np.allclose(attribute(obj, "Map"), now[corners][:, :2], atol=1e-5)
    assert np.allclose(attribute(obj, "height"), now[:, 2], atol=1e-5)
    assert sum(e.use_seam for e in obj.data.edges) == 4 * seams > 0
    weights = groups.read_weights(obj, "upper")
    assert (weights[now[:, 2] > 0.5] > 0.99).all() and (weights[now[:, 2] < -0.5] == 0).all()
    assert obj.data.materials[0].name == "Mine" and not obj.modifiers


def test_pattern_of_the_old_faces_goes_and_directions_stay():
    obj = sphere()
    api.stripes(obj, spacing=0.5)
    api.refine(obj, 1)
    assert [a.name for a in obj.data.attributes if a.name.startswith("synch_")] == ["synch_direction"]
    assert not obj.children and not obj.synch.result
    assert api.stripes(obj, spacing=0.5)["energy"] > 0


def test_undo_brings_the_coarse_mesh_back():
    sphere()
    undo_and_redo(lambda: bpy.ops.synch.refine(levels=1))


def test_modifiers_and_other_users_stay_as_they_are():
    obj = sphere()
    twin = bpy.data.objects.new("Twin", obj.data)
    bpy.context.scene.collection.objects.link(twin)
    obj.modifiers.new("Bend", "SIMPLE_DEFORM")
    bpy.context.scene.render.use_simplify = True
    bpy.context.scene.render.simplify_subdivision = 0
    faces = len(twin.data.polygons)
    api.refine(obj, 1)
    assert [m.name for m in obj.modifiers] == ["Bend"]
    assert len(obj.data.polygons) == 3 * faces and len(twin.data.polygons) == faces
    assert bpy.context.scene.render.use_simplify


def test_refused_subdivision_changes_nothing():
    obj = sphere()
    before = snapshot()
    for levels in (0, 7, 1.5):
        with pytest.raises(SynchError, match="level"):
            api.refine(obj, levels)
    obj.shape_key_add(name="Basis")
    with pytest.raises(SynchError, match="shape keys"):
        api.refine(obj, 1)
    assert not bpy.ops.synch.refine.poll()
    assert snapshot() == before


def smooth_grid():
    """A bumpy grid of quads, shaded smooth."""
    obj = grid()
    for vertex in obj.data.vertices:
        vertex.co.z = 0.2 * np.sin(3 * vertex.co.x) * np.cos(2 * vertex.co.y)
    obj.data.shade_smooth()
    return obj


def test_what_looks_smooth_goes_to_its_limit_surface():
    """Catmull and Clark (1978): inside a regular grid 16 parts of a vertex, 4 of its neighbours, 1 of those across."""
    obj = smooth_grid()
    before, size = places(obj), 13
    table = np.empty((size, size, 3))
    order = np.lexsort((before[:, 0].round(4), before[:, 1].round(4)))
    table[:] = before[order].reshape(size, size, 3)
    shifted = {(i, j): table[1 + i : size - 1 + i, 1 + j : size - 1 + j] for i in (-1, 0, 1) for j in (-1, 0, 1)}
    parts = {0: 16, 1: 4, 2: 1}
    limit = sum(parts[abs(i) + abs(j)] * points for (i, j), points in shifted.items()) / 36
    report = api.refine(obj, 2)
    assert report["smooth"] and len(obj.data.polygons) == 16 * 144
    after = places(obj)
    apart = np.linalg.norm(after[:, None] - limit.reshape(-1, 3), axis=2).min(axis=0)
    assert apart.max() < 1e-5 and np.linalg.norm(limit - table[1:-1, 1:-1], axis=2).max() > 1e-3
    # Corners of an open mesh stay.
    np.testing.assert_allclose(after.min(axis=0)[:2], before.min(axis=0)[:2], atol=1e-6)


@pytest.mark.parametrize("how", ["flat", "one flat face", "sharp", "by angle"])
def test_what_has_edges_to_be_seen_keeps_its_shape(how):
    obj = smooth_grid()
    if how == "flat":
        obj.data.shade_flat()
    if how == "one flat face":
        obj.data.polygons[3].use_smooth = False
    if how == "sharp":
        obj.data.edges[5].use_edge_sharp = True
    if how == "by angle":
        group = bpy.data.node_groups.new("Smooth by Angle", "GeometryNodeTree")
        obj.modifiers.new("Sharp", "NODES").node_group = group
    before = places(obj)
    assert not api.refine(obj, 1)["smooth"]
    np.testing.assert_allclose(places(obj)[: len(before)], before, atol=1e-6)


def test_with_a_modifier_of_its_own_as_many_faces_are_seen_as_before():
    obj = quad_sphere()
    modifier = obj.modifiers.new("Mine", "SUBSURF")
    modifier.levels, modifier.render_levels = 2, 3

    def seen():
        return len(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.polygons)

    before = seen()
    assert api.refine(obj, 1)["smooth"] and (modifier.levels, modifier.render_levels) == (1, 2)
    assert seen() == before


def test_no_warning_on_a_mesh_of_quads_that_was_made():
    obj = quad_sphere()
    made = bpy.data.objects[api.quad_mesh(obj, spacing=0.5)["quad_mesh"]["object"]]
    made.synch.automatic_spacing, made.synch.spacing = False, 0.01
    assert refine.missing_levels(made) > 0 and warning(made) == ([], 0)


@pytest.mark.parametrize(
    ("system", "unit", "scale", "words"),
    [
        ("METRIC", "METERS", 1.0, "2 m"),
        ("METRIC", "METERS", 0.001, "0.002 m"),
        ("METRIC", "MILLIMETERS", 0.001, "2 mm"),
        ("METRIC", "MILLIMETERS", 1.0, "2000 mm"),
        ("METRIC", "CENTIMETERS", 0.01, "2 cm"),
        ("METRIC", "ADAPTIVE", 0.001, "2 mm"),
        ("IMPERIAL", "FEET", 0.3048, "2'"),
        ("NONE", None, 0.001, "2"),
    ],
)
def test_lengths_are_said_in_the_unit_of_the_scene(system, unit, scale, words):
    """As Blender's own fields do; without units the scale does not count."""
    units = bpy.context.scene.unit_settings
    units.system = system
    if unit is not None:
        units.length_unit = unit
    units.scale_length = scale
    assert refine.as_length(2.0).strip() == words
