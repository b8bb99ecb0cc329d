# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers in the solids of mesh objects: exact on blocks, flush on groups, the same by every way."""

import json
import re

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import Cancelled, SettingError, SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.nodes.canvas import set_inputs
from synch_fields.synch_addon.nodes.layers import opening_modifier
from synch_fields.synch_addon.panels.overlay import layer_faces
from synch_fields.synch_addon.solids import memory

from ..scenes import (
    add_curve,
    add_group,
    add_object,
    attribute,
    empties,
    make_active,
    save_and_reopen,
    set_numbers,
    set_vectors,
    snapshot,
)
from ..solid_objects import bent_bar, block, layers_of, made, triangles_of


@pytest.mark.parametrize("axis", "XZ")
def test_a_constant_field_gives_exact_layers(axis):
    report = api.layers(block((1.0, 0.8, 0.6)), guidance=f"axis:{axis}", spacing=0.2, size=0.1)
    assert report["energy"] < 1e-12
    assert report["spacings"]["thinnest"] == pytest.approx(0.2, rel=1e-6)
    assert report["spacings"]["thickest"] == pytest.approx(0.2, rel=1e-6)
    assert report["dislocation_curves"] == [] and report["curves_object"] is None
    k = "XYZ".index(axis)
    heights = [places[:, k] for places in layers_of(made(report))]
    assert max(np.ptp(height) for height in heights) < 1e-6
    np.testing.assert_allclose(np.diff([height.mean() for height in heights]), 0.2, atol=1e-6)


def test_cavities_are_left_out_whichever_way_their_faces_look():
    """Recalculate Outside turns those of a cavity outwards like all others."""
    outer, cavity = block((2, 2, 2)), block()
    with bpy.context.temp_override(active_object=outer, selected_editable_objects=[outer, cavity]):
        bpy.ops.object.join()
    report = api.layers(outer, spacing=0.7, size=0.3)
    assert report["warnings"] == []
    solid = memory.recall_layers(outer).solid
    assert solid.volumes.sum() == pytest.approx(7, rel=1e-3)
    middles = solid.vertices[solid.tets].mean(axis=1)
    assert np.abs(middles).max(axis=1).min() > 0.5


def test_layers_are_numbered_upwards_face_up_and_are_cut_at_the_surface():
    report = api.layers(block(), spacing=0.25, size=0.1)
    obj = made(report)
    assert report["layers"] == len(layers_of(obj)) == 4
    triangles, places = triangles_of(obj), attribute(obj, "position")
    a, b, c = np.moveaxis(places[triangles], 1, 0)
    normals = np.cross(b - a, c - a)
    assert (normals[:, 2] > 0).all()
    areas = np.bincount(attribute(obj, "synch_layer"), np.linalg.norm(normals, axis=1) / 2)
    np.testing.assert_allclose(areas, 1, rtol=0.02)
    np.testing.assert_allclose(areas, report["layer_areas"], rtol=1e-5)


def test_scale_place_and_turn_of_the_object_count():
    """The spacing is in the scene's units, and what is made lies where the object is, mirrored ones too."""
    for mirror in (1, -1):
        obj = block()
        obj.scale, obj.location, obj.rotation_euler = (2 * mirror, 1, 0.5), (3, -1, 2), (0.3, 0.2, -0.5)
        report = api.layers(obj, guidance="axis:X", spacing=0.4, size=0.2)
        layers = made(report)
        np.testing.assert_allclose(np.abs(layers.scale), 1, atol=1e-6)
        inward = np.linalg.inv(np.array(obj.matrix_world))
        along = np.array(obj.matrix_world)[:3, 0] / 2
        heights = [places @ along for places in layers_of(layers)]
        assert len(heights) == 5 and max(np.ptp(height) for height in heights) < 1e-5
        np.testing.assert_allclose(np.abs(np.diff([height.mean() for height in heights])), 0.4, atol=1e-5)
        for places in layers_of(layers):
            inside = places @ inward[:3, :3].T + inward[:3, 3]
            assert np.abs(inside).max() < 0.5 + 1e-5


def test_layers_lie_flush_on_groups():
    """Between two faces a distance apart that is no multiple of the spacing, both carry a layer."""
    obj = block((1.0, 1.0, 0.9))
    report = api.layers(obj, guidance="harmonic:Bottom:Top", groups="Bottom=layer,Top=layer", spacing=0.2, size=0.1)
    assert report["warnings"] == []
    layering = memory.recall_layers(obj)
    vertices, phases = layering.solid.vertices, layering.pattern.vertex_phases
    reach = np.linalg.norm(np.ptp(vertices, axis=0))
    heights = layers_of(made(report))
    for height, places in ((-0.45, heights[0]), (0.45, heights[-1])):
        on = np.abs(vertices[:, 2] - height) < 1e-6 * reach
        assert on.sum() > 50
        np.testing.assert_allclose(phases[on], 0, atol=1e-12)
        assert np.abs(places[:, 2] - height).max() < 1e-6 * reach
    assert 5 <= report["layers"] <= 6


def test_layers_lie_flush_on_a_part_of_a_face_up_to_its_rim():
    """Every vertex of the solid on the marked faces has the layer's phase, those at the rim too."""
    obj = block(faces=(5, 5, 2))
    places = attribute(obj, "position")
    pad = (np.abs(places[:, :2]) < 0.31).all(axis=1) & (places[:, 2] > 0.4)
    add_group(obj, "Pad", np.flatnonzero(pad))
    report = api.layers(obj, groups="Pad=layer", spacing=0.35, size=0.13)
    (warning,) = report["warnings"]
    assert re.match("the solid's triangles cover 9[0-4]% of the vertex group 'Pad'", warning)
    assert warning.endswith("reduce the size of its tetrahedra, 0.13")
    layering = memory.recall_layers(obj)
    vertices = layering.solid.vertices
    on = (np.abs(vertices[:, :2]) < 0.3 + 1e-7).all(axis=1) & (np.abs(vertices[:, 2] - 0.5) < 1e-7)
    rim = on & (np.abs(np.abs(vertices[:, :2]).max(axis=1) - 0.3) < 1e-7)
    assert on.sum() > 20 and rim.sum() > 8
    np.testing.assert_allclose(layering.pattern.vertex_phases[on], 0, atol=1e-12)


def test_without_groups_layers_are_not_flush():
    obj = block((1.0, 1.0, 0.9))
    report = api.layers(obj, guidance="harmonic:Bottom:Top", spacing=0.2, size=0.1)
    assert layers_of(made(report))[0][:, 2].min() > -0.45 + 1e-3


def test_constant_groups_are_parallel_to_layers():
    """On the slanted end of a block, the phase may be any, but the same all over."""
    obj = block((1.0, 1.0, 1.0), (2, 2, 2))
    places = attribute(obj, "position")
    places[places[:, 2] > 0.4, 2] += 0.2 * places[places[:, 2] > 0.4, 0]
    obj.data.vertices.foreach_set("co", places.ravel())
    for groups, spread in (("Top=constant", (0, 1e-9)), ("", (0.5, np.pi))):
        api.layers(obj, groups=groups, spacing=0.3, size=0.12)
        layering = memory.recall_layers(obj)
        vertices = layering.solid.vertices
        on = np.abs(vertices[:, 2] - 0.5 - 0.2 * vertices[:, 0]) < 1e-6
        phases = np.exp(1j * layering.pattern.vertex_phases[on])
        apart = np.abs(np.angle(phases / phases[0])).max()
        assert on.sum() > 30 and spread[0] <= apart <= spread[1]


def test_guides_give_the_layers_that_they_should():
    """Distances from a face, along a curve, around a curve, from another mesh, and along an attribute."""
    obj = block()
    add_curve([(0, 0, -2), (0, 0, 2)], "Line")
    add_object([(-3, -3, -0.7), (3, -3, -0.7), (3, 3, -0.7), (-3, 3, -0.7)], [(0, 1, 2, 3)], "Bed")
    make_active(obj)
    set_vectors(obj, "grow", np.tile([0, 0, 3.0], (len(obj.data.vertices), 1)))
    for guidance in ("distance:Bed", "curve:Line", "attribute:grow"):
        report = api.layers(obj, guidance=guidance, spacing=0.3, size=0.12)
        for places in layers_of(made(report)):
            assert np.ptp(places[:, 2]) < 1e-5, guidance
    # A group's faces end where the solid's edges are cut off: from there the shortest ways are slanted.
    report = api.layers(obj, guidance="distance:Bottom", spacing=0.3, size=0.12)
    for places in layers_of(made(report)):
        inner = np.abs(places[:, :2]).max(axis=1) < 0.3
        assert inner.sum() > 20 and np.ptp(places[inner, 2]) < 0.03
    report = api.layers(obj, guidance="around:Line", groups="", spacing=0.3, size=0.12)
    for places in layers_of(made(report)):
        assert np.ptp(np.hypot(*places[:, :2].T)) < 0.15


def test_a_spacing_map_widens_layers_where_it_says():
    obj = block((0.6, 0.6, 2.0), (2, 2, 8))
    heights = attribute(obj, "position")[:, 2]
    set_numbers(obj, "wider", 1.5 + 0.5 * heights)
    report = api.layers(obj, spacing=0.2, spacing_map="wider", size=0.08)
    steps = np.diff([places[:, 2].mean() for places in layers_of(made(report))])
    middles = np.cumsum(steps)
    assert (np.diff(steps) > 0).all() and steps[-1] / steps[0] > 1.5 and len(middles) >= 5


def test_a_bent_bar_fans_out_with_dislocations():
    """Its outer side is twice as long as its inner one: layers end inside, at curves whose ends are marked."""
    obj = bent_bar()
    report = api.layers(obj, guidance="harmonic:Begin:End", spacing=0.22, size=0.1, seed=1)
    curves = report["dislocation_curves"]
    layers, dislocations = made(report), made(report, "curves")
    assert len(curves) == len(dislocations.data.splines) > 0
    assert [spline.use_cyclic_u for spline in dislocations.data.splines] == [curve["closed"] for curve in curves]
    ends = empties(layers, "dislocation")
    assert len(ends) == 2 * sum(not curve["closed"] for curve in curves)
    assert sum(empty["synch_index"] for empty in ends) == 0


def test_the_three_ways_agree(tmp_path):
    settings = {"guidance": "axis:X", "groups": "Top=constant", "spacing": 0.375, "size": 0.1875}
    places = []
    for way in ("api", "operator", "command line"):
        bpy.ops.wm.read_homefile(use_empty=True)
        obj = block()
        if way == "api":
            api.layers(obj, **settings)
        elif way == "operator":
            assert bpy.ops.synch.layers(**settings) == {"FINISHED"}
        else:
            flags = [f"--{key}={value}" for key, value in settings.items()]
            report = tmp_path / "layers.json"
            assert main.main(["layers", "--quiet", f"--report={report}", *flags], loaded=True) == 0
            assert json.loads(report.read_text())["layers_object"] == "Block Layers"
        places.append(attribute(bpy.data.objects["Block Layers"], "position"))
    np.testing.assert_array_equal(places[0], places[1])
    np.testing.assert_array_equal(places[0], places[2])


def test_a_second_run_gives_the_same_objects_new_data():
    obj = block()
    first = api.layers(obj, spacing=0.3, size=0.14)
    material = bpy.data.materials.new("Mine")
    made(first).material_slots[0].material = material
    objects, meshes = len(bpy.data.objects), len(bpy.data.meshes)
    assert bpy.context.active_object == made(first) and obj.hide_get()
    assert bpy.ops.synch.layers(spacing=0.25, size=0.12) == {"FINISHED"}  # of the object whose layers are active
    assert (len(bpy.data.objects), len(bpy.data.meshes)) == (objects, meshes)
    assert len(layers_of(made(first))) == 4 and made(first).material_slots[0].material == material


def test_a_second_run_leaves_the_edit_mode_of_the_layers():
    obj = block()
    first = api.layers(obj, spacing=0.4, size=0.2)
    for again in (lambda: bpy.ops.synch.layers(spacing=0.3, size=0.15), lambda: api.layers(obj, spacing=0.4, size=0.2)):
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        again()
        layers = made(first)
        assert layers.mode == "OBJECT" and len(attribute(layers, "synch_layer")) == len(layers.data.polygons)
    bpy.ops.object.mode_set(mode="EDIT")
    make_active(other := block())
    before = snapshot()
    with pytest.raises(SynchError, match="Block Layers is in another mode and not active"):
        api.layers(obj, spacing=0.3, size=0.15)
    assert snapshot() == before and bpy.context.active_object == other


def test_what_is_known_of_layers_is_what_is_shown():
    """After undo the run before, where the layers are now; nothing once they are gone."""
    block()
    counts = []
    for spacing in (0.25, 0.4):
        counts.append(api.layers(bpy.data.objects["Block"], spacing=spacing, size=0.125)["layers"])
        bpy.ops.ed.undo_push(message="layers")
    assert memory.recall_layers(bpy.data.objects["Block"]).surfaces.count == counts[1] != counts[0]
    bpy.ops.ed.undo()
    obj, layers = bpy.data.objects["Block"], bpy.data.objects["Block Layers"]
    assert memory.recall_layers(obj).surfaces.count == len(layers_of(layers)) == counts[0]
    layers.location = (3, 2, 1)
    np.testing.assert_allclose(memory.recall_layers(obj).matrix[:3, 3], (3, 2, 1))
    bpy.data.objects.remove(layers)
    assert not memory.holds_layers(obj)
    with pytest.raises(SynchError, match="no layers of Block are in memory"):
        api.layer_export(obj, "layers.stl")


def test_layers_are_saved_with_the_file(tmp_path):
    report = api.layers(block(), spacing=0.3, size=0.14)
    before = attribute(made(report), "synch_layer").copy()
    layers = save_and_reopen(tmp_path / "layers.blend", report["layers_object"])
    np.testing.assert_array_equal(attribute(layers, "synch_layer"), before)
    block_again = bpy.data.objects["Block"]
    with pytest.raises(Exception, match="no layers of Block are in memory"):
        memory.recall_layers(block_again)
    bpy.context.view_layer.objects.active = layers
    assert bpy.ops.synch.layers(spacing=0.3, size=0.14) == {"FINISHED"}
    assert sum(obj.name.startswith("Block Layers") for obj in bpy.data.objects) == 1


def test_cancelling_leaves_nothing():
    obj = block()
    before = snapshot()
    for stage in ("filling", "guidance", "layers"):
        with pytest.raises(Cancelled):
            api.layers(obj, lambda now, _, stage=stage: not now.startswith(stage), spacing=0.3, size=0.14)
        assert snapshot() == before
    with pytest.raises(SettingError, match="the setting 'spacings' is unknown"):
        api.layers(obj, spacings=1)


def test_layers_are_cut_open_and_peeled_by_their_modifier():
    obj, settings = block((1.0, 0.8, 0.6)), {"guidance": "axis:Z", "size": 0.1}
    layers = made(api.layers(obj, spacing=0.1, **settings))
    modifier = opening_modifier(layers)

    def seen(**values):
        set_inputs(modifier, values)
        bpy.context.view_layer.update()
        mesh = layers.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        numbers = [item.value for item in mesh.attributes["synch_layer"].data]
        return len(numbers), max(numbers), max(vertex.co.x for vertex in mesh.vertices)

    whole, last, right = seen()
    assert whole == len(layers.data.polygons)
    count, top, cut = seen(**{"Cut Open": 0.5})
    width = right - min(vertex.co.x for vertex in layers.data.vertices)
    assert count < whole and top == last and cut < right - 0.3 * width
    count, top, _ = seen(**{"Cut Open": 0.0, "Peel": 0.5})
    assert count < whole and abs(top - last / 2) <= 1
    [(corners, _)] = layer_faces(layers)
    assert len(corners) == count  # the overlay shows what is left
    assert len(made(api.layers(obj, spacing=0.2, **settings)).modifiers) == 1
