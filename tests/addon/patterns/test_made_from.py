# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a quad mesh is noticed to be of other modifiers, guides, constraints or pins than its source has now."""

import time

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.meshes import read_mesh
from synch_fields.synch_addon.blender.strokes import polylines
from synch_fields.synch_addon.jobs.kept_results import read_result
from synch_fields.synch_addon.patterns import memory
from synch_fields.synch_addon.patterns.made_from import made_from
from synch_fields.synch_addon.patterns.other_settings import shows_other_settings
from synch_fields.synch_addon.reading.refinement import state_of
from synch_fields.synch_addon.reading.surface import settings_for
from synch_fields.synch_addon.settings.fields import stored_settings

from ..scenes import (
    add_curve,
    add_group,
    grid,
    make_active,
    mark_edges,
    places,
    save_and_reopen,
    set_numbers,
    set_vectors,
    sphere,
)


def made_of(obj, **settings):
    """The quad mesh of an object, by the operator with the settings that the object keeps."""
    obj.synch.method = "SPECTRAL"
    make_active(obj)
    assert bpy.ops.synch.quad_mesh(**kept(obj), **settings) == {"FINISHED"}
    bpy.context.view_layer.update()
    return bpy.context.active_object


def kept(obj):
    """What the panel would hand to the operator."""
    plain = stored_settings(obj)
    return {"method": "SPECTRAL", "guidance": plain.guidance, "surface": obj.synch.surface, "faces": 150}


def is_noticed(made):
    """Whether the button offers an update."""
    bpy.context.view_layer.update()
    return memory.is_outdated(made) or shows_other_settings(made, "quad_mesh")


def renew(obj, name, values, key="value"):
    """Give an attribute other values."""
    obj.data.attributes[name].data.foreach_set(key, np.float32(values).ravel())
    obj.data.update()


def wave(obj):
    modifier = obj.modifiers.new("Cast", "CAST")
    modifier.factor = 0.2
    return modifier


def test_modifiers_count_where_the_surface_is_what_they_make():
    ball = sphere()
    ball.synch.surface = "SEEN"
    modifier = wave(ball)
    made = made_of(ball)
    assert not is_noticed(made)
    for name, value in (("factor", 0.3), ("show_viewport", False)):
        before = getattr(modifier, name)
        setattr(modifier, name, value)
        assert is_noticed(made), name
        setattr(modifier, name, before)
        assert not is_noticed(made), name
    modifier.name, modifier.show_expanded = "Another Name", False
    assert not is_noticed(made)
    ball.modifiers.new("Subdivision", "SUBSURF").levels = 1
    assert is_noticed(made)


def test_what_a_modifier_depends_on_counts_too():
    ball, target = sphere(), sphere()
    ball.synch.surface = "SEEN"
    modifier = ball.modifiers.new("Cast", "CAST")
    modifier.object, modifier.factor = target, 0.2
    made = made_of(ball)
    assert not is_noticed(made)
    target.location.z = 0.3
    assert is_noticed(made)
    target.location.z = 0.0
    assert not is_noticed(made)


@pytest.mark.parametrize("switch", ["object", "collection", "layer"])
def test_a_source_that_is_not_evaluated_counts_as_before(switch):
    collection = bpy.data.collections.new("Sources")
    bpy.context.scene.collection.children.link(collection)
    ball = sphere()
    for other in ball.users_collection:
        other.objects.unlink(ball)
    collection.objects.link(ball)
    layer = bpy.context.view_layer.layer_collection.children["Sources"]
    ball.synch.surface = "SEEN"
    modifier = wave(ball)
    made = made_of(ball)
    owner = {"object": ball, "collection": collection, "layer": layer}[switch]
    name = "exclude" if switch == "layer" else "hide_viewport"
    setattr(owner, name, True)
    bpy.context.view_layer.update()
    seen = ball.evaluated_get(bpy.context.evaluated_depsgraph_get())
    np.testing.assert_array_equal(places(seen), places(ball))  # the modifier does not run
    for hidden in (True, False, True):
        setattr(owner, name, hidden)
        assert not is_noticed(made), hidden
    modifier.factor = 0.4
    assert not is_noticed(made)  # not yet known
    setattr(owner, name, False)
    assert is_noticed(made)


@pytest.mark.any_surface
def test_modifiers_of_a_coarse_mesh_count_and_those_of_its_own_faces_do_not():
    for surface, expected in (("AUTOMATIC", True), ("FACES", False)):
        cube = sphere(1)
        cube.synch.surface = surface
        made = made_of(cube)
        assert not is_noticed(made)
        modifier = cube.modifiers.new("Subdivision", "SUBSURF")
        assert is_noticed(made) == expected
        modifier.show_viewport = False
        assert not is_noticed(made)
        cube.modifiers.remove(modifier)
        wave(cube)  # its faces stay as they are
        assert not is_noticed(made)


@pytest.mark.any_surface
def test_levels_of_renders_count():
    cube = sphere(1)
    modifier = cube.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 1, 2
    made = made_of(cube)
    assert not is_noticed(made)
    modifier.render_levels = 3
    assert is_noticed(made)


def test_constraints_and_pins_count():
    ball = sphere()
    half = [v.index for v in ball.data.vertices if v.co.z > 0]
    add_group(ball, "Half", half)
    row = ball.synch.constraints.add()
    row.where, row.vertex_group, row.what = "GROUP", "Half", "ALONG"
    ball.synch.pins = "3=1"
    made = made_of(ball)
    assert not is_noticed(made)
    for owner, name, value in ((row, "what", "ACROSS"), (row, "enabled", False), (ball.synch, "pins", "3=2")):
        before = getattr(owner, name)
        setattr(owner, name, value)
        assert is_noticed(made), name
        setattr(owner, name, before)
        assert not is_noticed(made), name
    ball.vertex_groups["Half"].remove(half[:5])
    ball.data.update()
    assert is_noticed(made)


def test_values_that_guides_name_count():
    ball = sphere()
    heights = places(ball)[:, 2]
    set_numbers(ball, "height", heights)
    set_numbers(ball, "other", heights)
    ball.synch.guidance, ball.synch.guide.numbers = "GRADIENT", "height"
    made = made_of(ball)
    assert not is_noticed(made)
    renew(ball, "other", -heights)
    assert not is_noticed(made)
    renew(ball, "height", heights**2)
    assert is_noticed(made)


def test_vectors_that_guide_exactly_count():
    ball = sphere()
    set_vectors(ball, "flow", np.cross(places(ball), (0.1, 0.2, 1.0)))
    ball.synch.guidance, ball.synch.guide.vectors = "ATTRIBUTE", "flow"
    made = made_of(ball)
    assert not is_noticed(made)
    renew(ball, "flow", np.cross(places(ball), (1.0, 0.2, 0.1)), "vector")
    assert is_noticed(made)


def test_files_that_guide_count(tmp_path):
    ball, path = sphere(), tmp_path / "field.rosy"
    for angle in (0.0, 0.5):
        api.directions(ball, guidance="axis:Z", angle=angle)
        api.export_field(ball, tmp_path / f"{angle}.rosy", "line")
    texts = [(tmp_path / f"{angle}.rosy").read_bytes() for angle in (0.0, 0.5)]
    assert texts[0] != texts[1]
    path.write_bytes(texts[0])
    ball.synch.guidance, ball.synch.guide.path = "FILE", str(path)
    made = made_of(ball)
    assert not is_noticed(made)
    path.write_bytes(texts[1])
    assert is_noticed(made)
    made = made_of(ball)
    assert not is_noticed(made)
    path.unlink()
    assert is_noticed(made)


@pytest.mark.parametrize("thickness", [0.0, 0.1])
def test_curves_count_by_their_course_and_place(thickness):
    ball = sphere()
    curve = add_curve([(0, 0, 1.2), (1.2, 0, 0), (0, 0, -1.2)])
    curve.data.bevel_depth = thickness
    row = ball.synch.constraints.add()
    row.where, row.curve, row.what = "CURVE", curve, "ALONG"
    made = made_of(ball)
    assert not is_noticed(made)
    blocks = len(bpy.data.objects), len(bpy.data.curves)
    curve.location.y = 0.2
    assert is_noticed(made)
    curve.location.y = 0.0
    assert not is_noticed(made)
    curve.data.splines[0].points[1].co.y += 0.3
    curve.data.update_tag()
    assert is_noticed(made)
    assert (len(bpy.data.objects), len(bpy.data.curves)) == blocks


def test_shape_keys_of_thick_curves_count():
    ball = sphere()
    curve = add_curve([(0, 0, 1.2), (1.2, 0, 0), (0, 0, -1.2)])
    bezier = curve.data.splines.new("BEZIER")
    bezier.bezier_points.add(1)
    for point, place in zip(bezier.bezier_points, ((0, -1.2, 0), (-1.2, 0, 0)), strict=True):
        point.co = point.handle_left = point.handle_right = place
    curve.data.bevel_depth = 0.1
    for name in ("Basis", "Bent", "Wide"):
        key = curve.shape_key_add(name=name, from_mix=False)
        key.value = 0.5
        key.data[1].co.x += len(curve.data.shape_keys.key_blocks) / 10
    keys = curve.data.shape_keys
    bent = keys.key_blocks["Bent"]
    row = ball.synch.constraints.add()
    row.where, row.curve, row.what = "CURVE", curve, "ALONG"
    made = made_of(ball)
    assert not is_noticed(made)
    changes = [(bent.data[1], "co", (1.0, 0.4, 0.0)), (bent.data[4], "handle_left", (-1.0, -0.4, 0.0))]
    changes += [(bent, "mute", True), (bent, "relative_key", keys.key_blocks["Wide"]), (bent, "value", 0.2)]
    changes += [(keys, "use_relative", False)]
    for owner, name, value in changes:
        before, lines = getattr(owner, name), np.concatenate(polylines(curve))
        before = before.copy() if hasattr(before, "copy") else before
        setattr(owner, name, value)
        now = np.concatenate(polylines(curve))
        assert now.shape != lines.shape or abs(now - lines).max() > 0.01, name
        assert is_noticed(made), name
        setattr(owner, name, before)
        assert not is_noticed(made), name
    keys.use_relative = False
    made = made_of(ball)
    for owner, name, value in ((keys, "eval_time", 15.0), (bent, "interpolation", "KEY_CARDINAL")):
        lines = np.concatenate(polylines(curve))
        setattr(owner, name, value)
        assert abs(np.concatenate(polylines(curve)) - lines).max() > 1e-3, name
        assert is_noticed(made), name
        made = made_of(ball)
        assert not is_noticed(made), name


def test_marks_of_edges_count():
    plate = grid()
    made = made_of(plate)
    assert not is_noticed(made)
    mark_edges(plate, "sharp", np.abs(places(plate)[:, 0]) < 0.01)
    plate.data.update()
    assert is_noticed(made)


def test_it_is_known_after_the_file_was_opened_again(tmp_path):
    ball = sphere()
    ball.synch.surface = "SEEN"
    wave(ball)
    made = made_of(ball)
    made = save_and_reopen(tmp_path / "kept.blend", made.name)
    assert not is_noticed(made)
    made.synch.source.modifiers["Cast"].factor = 0.4
    assert is_noticed(made)


def test_quad_meshes_of_earlier_versions_are_compared_by_their_meshes():
    ball = sphere()
    made = made_of(ball)
    made.synch.made_from = state_of(ball)
    assert not is_noticed(made)
    ball.data.vertices[0].co.x += 0.1
    ball.data.update()
    assert is_noticed(made)


@pytest.mark.any_surface
def test_quads_that_are_traced_get_no_update_until_they_are_made_again():
    cube = sphere(1)
    cube.synch.pins = "3=1"
    make_active(cube)
    assert bpy.ops.synch.quads(spacing=0.5, method="SPECTRAL", seed=5) == {"FINISHED"}
    assert cube.synch.pins != "3=1"  # it is on the finer surface
    assert bpy.ops.synch.trace_quads() == {"FINISHED"}
    made = bpy.context.active_object
    assert read_result(made.synch.result, made.name)["settings"]["pins"] == cube.synch.pins
    assert not is_noticed(made)
    made.synch.smoothing += 1
    cube.data.vertices[0].co.x += 0.1
    cube.data.update()
    assert not is_noticed(made)
    assert bpy.ops.synch.quad_mesh_again() == {"FINISHED"}
    assert not is_noticed(made)
    made.synch.smoothing += 1
    assert is_noticed(made)


@pytest.mark.parametrize("name, value", [("pins", "3=1"), ("seed", 4), ("surface", "FACES"), ("method", "DIFFUSION")])
def test_patterns_notice_these_settings_as_well(name, value):
    ball = sphere()
    ball.synch.method = "SPECTRAL"
    make_active(ball)
    assert bpy.ops.synch.stripes(method="SPECTRAL", spacing=0.5) == {"FINISHED"}
    assert not shows_other_settings(ball, "stripes")
    setattr(ball.synch, name, value)
    assert shows_other_settings(ball, "stripes")


def test_looking_takes_a_fraction_of_reading_the_mesh_for_a_solve():
    plate = grid(224)
    plate.synch.surface = "SEEN"
    wave(plate)
    bpy.context.view_layer.update()
    settings = settings_for("quad_mesh", plate, stored_settings(plate))
    looks = [lambda: made_from(plate, settings, reads_modifiers=True), lambda: read_mesh(plate)]
    taken = [[], []]
    for _ in range(5):
        for look, times in zip(looks, taken, strict=True):
            start = time.process_time()
            look()
            times.append(time.process_time() - start)
    assert 4 * min(taken[0]) < min(taken[1])
