# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A quad mesh made anew from the object that it was made of: another count, one click, in the same place."""

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import groups
from synch_fields.synch_addon.patterns import memory, quad_mesh
from synch_fields.synch_addon.patterns.other_settings import shows_other_settings
from synch_fields.synch_addon.settings.fields import source_of

from ..scenes import make_active, places, snapshot, sphere


def made_of(obj, **settings):
    """The quad mesh of an object by the operator, active as it leaves it."""
    make_active(obj)
    assert bpy.ops.synch.quad_mesh(**settings) == {"FINISHED"}
    return bpy.context.active_object


def again(made, **settings):
    """Another quad mesh in its place."""
    make_active(made)
    assert bpy.ops.synch.quad_mesh_again(**settings) == {"FINISHED"}


@pytest.fixture
def ball():
    return sphere()


def test_another_count_takes_the_place_of_the_quad_mesh(ball):
    before = places(ball)
    made = made_of(ball, faces=200)
    assert source_of(made) == ball and made.synch_simple.kind == "quad_mesh"
    name, objects = made.name, set(bpy.data.objects)
    for faces in (500, 300):
        again(made, faces=faces)
        assert len(made.data.polygons) == pytest.approx(faces, rel=0.08)
        assert made.name == name and set(bpy.data.objects) == objects and bpy.context.active_object == made
        assert made.data.name == f"{ball.data.name} Quads" and len(bpy.data.meshes) == 2
        assert ball.hide_get() and not made.hide_get()
    assert (places(ball) == before).all()


def test_modifiers_of_the_hidden_source_count(ball):
    """What is seen is larger than the mesh."""
    own = max(ball.dimensions)
    modifier = ball.modifiers.new("Wide", "CAST")
    modifier.cast_type, modifier.factor, modifier.size, modifier.use_radius_as_size = "SPHERE", 1.0, 2 * own, False
    made = made_of(ball, faces=300, surface="SEEN")
    wide = max(made.dimensions)
    again(made, faces=400, surface="SEEN")
    assert wide > 1.5 * own and max(made.dimensions) == pytest.approx(wide, rel=0.05)


def test_a_failure_leaves_the_quad_mesh_as_it_was(ball, monkeypatch):
    made_of(ball, faces=200)
    before = snapshot()

    def fail(*_):
        raise SynchError("no figures")

    monkeypatch.setattr(quad_mesh, "quality", fail)
    with pytest.raises(RuntimeError, match="no figures"):
        bpy.ops.synch.quad_mesh_again(faces=300)
    assert snapshot() == before and ball.hide_get()


def test_without_its_source_a_quad_mesh_says_so(ball):
    made = made_of(ball, faces=200)
    bpy.data.objects.remove(ball)
    assert source_of(made) is None and not bpy.ops.synch.quad_mesh_again.poll()


def test_directions_follow_what_the_source_follows(ball):
    ball.synch.guidance, ball.synch.guide.axis = "AXIS", "Z"
    made = made_of(ball, faces=300, guidance="axis:Z")
    around = snapshot()
    again(made, faces=300)
    assert snapshot() == around


@pytest.fixture
def click(monkeypatch):
    """click(name, obj): press the button of an operator, which takes the settings that the panel shows."""

    def pressed(name, obj):
        make_active(obj)
        with monkeypatch.context() as patch:
            operator = getattr(bpy.types, f"SYNCH_OT_{name}")
            patch.setattr(operator, "execute", lambda self, context: self.invoke(context, None))
            assert getattr(bpy.ops.synch, name)() == {"FINISHED"}
        return bpy.context.active_object

    return pressed


@pytest.mark.parametrize("automatic", [True, False])
def test_the_button_offers_an_update_where_settings_are_others(ball, click, automatic):
    ball.synch.automatic_spacing, ball.synch.spacing = automatic, 0.5
    ball.synch.faces = 200 if automatic else 0
    made = click("quad_mesh", ball)
    assert not shows_other_settings(made, "quad_mesh")
    changes = [(made, "smoothing", 0), (made, "mesh_branching", 40.0), (ball, "guidance", "AXIS"), (ball, "angle", 0.3)]
    changes += [(made, "faces", 300)] if automatic else [(made, "spacing", 0.4)]
    for obj, name, value in changes:
        before = getattr(obj.synch, name)
        setattr(obj.synch, name, value)
        assert shows_other_settings(made, "quad_mesh"), name
        setattr(obj.synch, name, before)
        assert not shows_other_settings(made, "quad_mesh"), name
    for obj, name, value in changes:
        setattr(obj.synch, name, value)
    click("quad_mesh_again", made)
    assert not shows_other_settings(made, "quad_mesh")
    if automatic:
        assert len(made.data.polygons) == pytest.approx(300, rel=0.1)
    bpy.data.objects.remove(ball)
    assert not shows_other_settings(made, "quad_mesh")  # there is nothing to make it of


@pytest.mark.parametrize(
    "settings", [{"faces": 300, "smoothing": 3}, {"spacing": 0.5, "branching": 0.4, "mirror": "Y", "features": 0.0}]
)
def test_a_mesh_of_a_script_shows_its_settings_and_is_made_again_with_them(ball, click, settings):
    made = bpy.data.objects[api.quad_mesh(ball, **settings)["quad_mesh"]["object"]]
    assert not shows_other_settings(made, "quad_mesh")
    assert made.synch.faces == settings.get("faces", 0) and made.synch.smoothing == settings.get("smoothing", 10)
    assert made.synch.mesh_branching == 100 * settings.get("branching", 0.0)
    assert tuple(made.synch.mirror) == tuple(axis in settings.get("mirror", "") for axis in "XYZ")
    assert made.synch.automatic_spacing == ("spacing" not in settings)
    before = snapshot()
    click("quad_mesh_again", made)
    assert snapshot() == before


def test_an_update_follows_the_directions_that_the_panel_shows(ball, click):
    made = made_of(ball, faces=300)
    ball.synch_simple.direction, ball.synch.guide.axis = "AXIS", "Y"
    click("quad_mesh_again", made)
    other = made_of(ball, faces=300, guidance="axis:Y", angle=ball.synch.angle)
    assert sorted(map(tuple, places(other))) == sorted(map(tuple, places(made)))


def test_a_source_that_has_changed_since_is_noticed(ball, click):
    made = made_of(ball, faces=200)
    assert not memory.is_outdated(made)
    ball.rotation_euler.x, made.location.x = 1.0, 5.0
    bpy.context.view_layer.update()
    assert not memory.is_outdated(made)
    ball.data.vertices[0].co.x += 0.2
    ball.data.update()
    bpy.context.view_layer.update()
    assert memory.is_outdated(made)
    ball.hide_set(False)
    make_active(ball)
    bpy.ops.object.mode_set(mode="EDIT")
    assert not memory.is_outdated(made)  # not yet known
    bpy.ops.object.mode_set(mode="OBJECT")
    click("quad_mesh_again", made)
    assert not memory.is_outdated(made)
    ball.scale.x = 2.0
    assert memory.is_outdated(made)


def test_guides_and_constraints_of_a_quad_mesh_are_those_of_its_source(ball):
    made = made_of(ball, faces=200)
    make_active(made)
    bpy.ops.synch.constraint_add()
    bpy.ops.synch.guide_add()
    assert len(ball.synch.constraints) == len(ball.synch.guides) == 1
    assert not len(made.synch.constraints) + len(made.synch.guides)


def test_settings_that_a_script_does_not_name_are_those_of_the_first_quad_mesh(ball):
    made = made_of(ball, faces=300, guidance="axis:Y", branching=100, seed=3)
    first = snapshot()
    again(made, faces=200)
    assert snapshot() != first
    again(made, faces=300)
    assert snapshot() == first
    again(made)
    assert snapshot() == first


def test_a_spacing_that_a_script_names_counts_and_not_the_first_number_of_faces(ball):
    by_spacing = made_of(ball, spacing=0.4)
    wanted = len(by_spacing.data.polygons)
    bpy.data.objects.remove(by_spacing)
    ball.hide_set(False)
    made = made_of(ball, faces=2 * wanted)
    again(made, spacing=0.4)
    assert len(made.data.polygons) == wanted
    again(made)
    assert len(made.data.polygons) == wanted


def test_the_scale_is_that_of_the_source_as_it_is_now(ball):
    made = made_of(ball, faces=300)
    for scale in ((2, 2, 2), (1, 3, 1)):
        ball.scale = scale
        bpy.context.view_layer.update()
        again(made, faces=300)
        bpy.context.view_layer.update()
        assert list(made.dimensions) == pytest.approx(list(ball.dimensions), rel=0.05)
    for vertex in ball.data.vertices:
        vertex.co *= 0.5
    ball.data.update()
    again(made, faces=300)
    bpy.context.view_layer.update()
    assert list(made.dimensions) == pytest.approx(list(ball.dimensions), rel=0.05)


def test_edit_mode_is_left_first(ball):
    made = made_of(ball, faces=200)
    bpy.ops.object.mode_set(mode="EDIT")
    assert not bpy.ops.synch.quad_mesh_again.poll()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert bpy.ops.synch.quad_mesh_again.poll() and bpy.context.active_object == made


def test_errors_select_vertices_of_the_source(ball):
    """One that is not symmetric, on its own faces, though its quad mesh was made without a mirror."""
    made = made_of(ball, faces=50)
    far = len(ball.data.vertices) - 1
    ball.data.vertices[far].co *= 1.3
    ball.data.update()
    make_active(made)
    with pytest.raises(RuntimeError, match="not symmetric in X"):
        bpy.ops.synch.quad_mesh_again(faces=50, mirror=(True, False, False))
    assert ball.data.vertices[far].select and not all(vertex.select for vertex in ball.data.vertices)


def test_another_kind_is_made_of_the_quad_mesh_itself(ball, click):
    made = made_of(ball, faces=300)
    made.synch_simple.kind, made.synch_simple.lines = "stripes", 8
    assert source_of(made) is None and not bpy.ops.synch.quad_mesh_again.poll()
    faces = len(made.data.polygons)
    click("stripes", made)
    assert made.synch_simple.kind == "stripes" and len(made.data.polygons) == faces
    assert memory.holds(made) and not memory.is_outdated(made)
    made.synch_simple.kind = "quad_mesh"
    assert source_of(made) == ball and bpy.ops.synch.quad_mesh_again.poll()


def weights_of(obj, name):
    return groups.read_weights(obj, name)


@pytest.mark.parametrize("has_map", [True, False])
def test_what_is_painted_on_the_quad_mesh_counts_for_its_source(ball, has_map):
    """On the side of +X the quads become half as long, whether the source had a map before or not."""
    if has_map:
        groups.write_weights(ball, "Fine", (places(ball)[:, 2] > 0.5).astype(float))
        ball.synch.spacing_map, ball.synch.spacing_range = "Fine", 0.8
    before = weights_of(ball, "Fine") if has_map else np.zeros(len(ball.data.vertices))
    made = made_of(ball, faces=400, **({"spacing_map": "Fine", "spacing_range": 0.8} if has_map else {}))
    again(made, faces=400)
    if has_map:  # nothing was painted
        assert (weights_of(ball, "Fine") == before).all()
    make_active(made)
    bpy.ops.synch.paint_map(target="SPACING")
    name = made.synch.spacing_map
    made.synch.spacing_range = 0.5
    groups.write_weights(made, name, np.where(places(made)[:, 0] > 0.2, 1.0, weights_of(made, name)))
    assert bpy.ops.synch.done_painting() == {"FINISHED"} and made.mode == "OBJECT"
    right = places(ball)[:, 0]
    painted = weights_of(ball, name)
    assert painted[right > 0.5].min() > 0.99
    assert np.abs(painted - before)[right < -0.2].max() < 1e-6
    assert memory.is_outdated(made)
    again(made, faces=400, spacing_map=name, spacing_range=0.5)
    right = np.array([face.center.x for face in made.data.polygons])
    areas = np.array([face.area for face in made.data.polygons])
    low = np.array([face.center.z for face in made.data.polygons]) < 0.3
    assert 0.2 < np.median(areas[(right > 0.5) & low]) / np.median(areas[(right < -0.5) & low]) < 0.45
