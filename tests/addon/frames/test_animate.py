# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Patterns on moving meshes: nothing moves without need, each frame shows its own solve, refusals change nothing."""

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import Cancelled, SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.patterns.frame_attributes import frame_layout

from ..baked_images import picture
from ..moving_meshes import moving, seen, stored_frames, swaying, turned
from ..rebuilt_pattern import largest_jump
from ..scenes import (
    add_object,
    attribute,
    empties,
    grid,
    hexagon_sphere,
    quad_sphere,
    set_vectors,
    snapshot,
    sphere,
    tube,
)


def pattern_at(obj, frame):
    return attribute(obj, f"synch_pattern.{frame}").astype(float)


# What stays and what changes


@pytest.mark.parametrize(("pattern", "build"), [("stripes", sphere), ("quads", quad_sphere)])
def test_a_mesh_that_turns_keeps_its_phases(pattern, build):
    obj = build()
    points = attribute(obj, "position").reshape(-1, 3).astype(float)
    moving(obj, [turned(points, angle) + [angle, 0, 0] for angle in (0, 0.7, 2.0)])
    report = api.animate(obj, frames=(1, 3), pattern=pattern, spacing=0.5)
    for frame in (2, 3):
        for name in [name for name in frame_layout(pattern) if name.startswith(("synch_phase", "synch_index"))]:
            first, now = (obj.data.attributes.get(f"{name}.{k}") for k in (1, frame))
            assert (first is None) == (now is None)
            if first is not None:
                np.testing.assert_allclose(attribute(obj, now.name), attribute(obj, first.name), atol=2e-3)
        directions = turned(attribute(obj, "synch_direction.1"), (0, 0.7, 2.0)[frame - 1])
        np.testing.assert_allclose(attribute(obj, f"synch_direction.{frame}"), directions, atol=1e-3)
        assert report["frames"][frame - 1]["change"] < 1e-3


def test_an_object_that_moves_keeps_its_phases():
    obj = tube()
    for frame, angle in ((1, 0.0), (2, 1.0)):
        obj.location.x, obj.rotation_euler.y = angle, angle
        obj.keyframe_insert("location", frame=frame)
        obj.keyframe_insert("rotation_euler", frame=frame)
    api.animate(obj, frames=(1, 2), spacing=0.5)
    np.testing.assert_allclose(attribute(obj, "synch_phase.2"), attribute(obj, "synch_phase.1"), atol=2e-3)


def test_a_bone_that_turns_everything_keeps_the_phases():
    obj = tube()
    obj.vertex_groups.new(name="Bone").add(range(len(obj.data.vertices)), 1.0, "REPLACE")
    rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones.new("Bone").tail = (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.modifiers.new("Armature", "ARMATURE").object = rig
    for frame, angle in ((1, 0.0), (2, 1.0)):
        rig.pose.bones["Bone"].rotation_quaternion = (np.cos(angle), np.sin(angle), 0, 0)
        rig.pose.bones["Bone"].keyframe_insert("rotation_quaternion", frame=frame)
    assert not np.allclose(attribute(seen(obj, 1), "position"), attribute(seen(obj, 2), "position"), atol=0.1)
    api.animate(obj, frames=(1, 2), spacing=0.5)
    np.testing.assert_allclose(attribute(obj, "synch_phase.2"), attribute(obj, "synch_phase.1"), atol=2e-3)


def test_a_gentle_deformation_changes_little():
    """A tenth of the change between solves of each frame alone; the energy of a solve along the same directions."""
    frames = 4
    obj = swaying(sphere(), frames, much=0.04)
    report = api.animate(obj, frames=(1, frames), spacing=0.35)
    alone, energies = [], []
    for frame in range(1, frames + 1):
        shape = seen(obj, frame)
        copy = add_object(attribute(shape, "position").reshape(-1, 3), [p.vertices[:] for p in shape.data.polygons])
        api.stripes(copy, spacing=0.35)
        alone.append(attribute(copy, "synch_pattern").astype(float))
        set_vectors(copy, "same", attribute(obj, f"synch_direction.{frame}"))
        energies.append(api.stripes(copy, spacing=0.35, guidance="attribute:same")["energy"])
    changes = [figures["change"] for figures in report["frames"][1:]]
    assert changes == pytest.approx(
        [np.abs(pattern_at(obj, k + 1) - pattern_at(obj, k)).mean() for k in range(1, frames)], abs=1e-5
    )
    independent = np.abs(np.diff(alone, axis=0)).mean()
    assert max(changes) < 0.1 * independent
    for figures, energy in zip(report["frames"], energies, strict=True):
        assert figures["energy"] < 1.01 * energy


def test_automatic_spacing_is_that_of_the_first_frame():
    points = attribute(sphere(), "position").reshape(-1, 3)
    obj = moving(bpy.context.active_object, [points, 3 * points])
    report = api.animate(obj, frames=(1, 2))
    alone = sphere()
    assert report["settings"]["spacing"] == pytest.approx(api.stripes(alone)["settings"]["spacing"])
    assert obj["synch_spacing"] == pytest.approx(alone["synch_spacing"])


def test_an_object_that_a_script_has_scaled_just_now_is_measured_so():
    expected = api.animate(_doubled(), frames=(1, 2))["settings"]["spacing"]
    obj = _doubled()
    obj.scale = (1, 1, 1)
    bpy.context.view_layer.update()
    obj.scale = (2, 2, 2)
    assert api.animate(obj, frames=(1, 2))["settings"]["spacing"] == pytest.approx(expected)


def _doubled():
    obj = sphere(2)
    obj.scale = (2, 2, 2)
    bpy.context.view_layer.update()
    return obj


def test_given_directions_go_along():
    obj = grid(6)
    points = attribute(obj, "position").reshape(-1, 3)
    set_vectors(obj, "east", np.tile([1.0, 0, 0], (len(points), 1)))
    moving(obj, [turned(points, angle) for angle in (0, 1.0)])
    api.animate(obj, frames=(1, 2), spacing=0.5, guidance="attribute:east")
    wanted = np.tile([np.cos(1.0), np.sin(1.0), 0], (len(points), 1))
    np.testing.assert_allclose(attribute(obj, "synch_direction.2"), wanted, atol=1e-5)


# What is stored and shown


@pytest.mark.parametrize(
    ("pattern", "build"), [("stripes", quad_sphere), ("stripes", hexagon_sphere), ("quads", sphere)]
)
def test_each_frame_shows_its_own_solve_without_a_seam(pattern, build):
    """Also before and after the range, and through modifiers that deform; faces that are split keep their shapes."""
    obj = swaying(build(), 2)
    shape = attribute(seen(obj, 2), "position")
    obj.modifiers.new("Wave", "WAVE").height = 0.0
    report = api.animate(obj, frames=(1, 2), pattern=pattern, spacing=0.7)
    splits = [line for line in report["warnings"] if "were split into triangles" in line]
    assert len(splits) == (build is hexagon_sphere)
    assert [modifier.type for modifier in obj.modifiers] == ["WAVE", "NODES"]
    assert stored_frames(obj) == [1, 2]
    for frame in (-4, 1, 2, 9):
        now = seen(obj, frame)
        for name in frame_layout(pattern):
            stored = obj.data.attributes.get(f"{name}.{np.clip(frame, 1, 2)}")
            values = attribute(now, name)
            np.testing.assert_array_equal(values, attribute(obj, stored.name) if stored else np.zeros_like(values))
        assert largest_jump(now)[0] < 1e-4
    assert (pattern_at(obj, 1) != pattern_at(obj, 2)).any()
    np.testing.assert_array_equal(attribute(seen(obj, 2), "position"), shape)


def test_the_bake_of_a_frame_is_that_of_its_pattern(tmp_path):
    """What Cycles renders follows the modifier: as a mesh that has the frame's attributes as its own."""
    obj = swaying(tube(segments=16, rings=9), 2, much=0.5)
    api.animate(obj, frames=(1, 2), spacing=0.7)
    images = {}
    for frame in (1, 2):
        bpy.context.scene.frame_set(frame)
        made = api.bake(obj, maps="mask", size=64, samples=1, unwrap=frame == 1, margin=0)
        images[frame] = mask_of(made)
    assert np.abs(images[1] - images[2]).mean() > 0.01
    for name in frame_layout("stripes"):
        if f"{name}.2" in obj.data.attributes:
            values = attribute(obj, f"{name}.2")
            kind = obj.data.attributes[name].data_type
            obj.data.attributes[name].data.foreach_set(
                {"FLOAT_VECTOR": "vector", "FLOAT_COLOR": "color"}.get(kind, "value"), values.ravel()
            )
    obj.modifiers.clear()
    np.testing.assert_allclose(
        mask_of(api.bake(obj, maps="mask", size=64, samples=1, margin=0)), images[2], atol=2 / 255
    )


def mask_of(report):
    return picture(bpy.data.images[report["maps"]["mask"]["image"]], 64)


def test_the_scene_is_as_it_was_and_has_the_pattern():
    obj = swaying(sphere(), 2)
    bpy.context.scene.frame_set(7, subframe=0.25)
    api.stripes(obj, spacing=0.5)
    api.number_stripes(obj)
    assert empties(obj) and obj.synch.result and "synch_number" in obj.data.attributes
    api.animate(obj, frames=(1, 2), spacing=0.5)
    assert (bpy.context.scene.frame_current, bpy.context.scene.frame_subframe) == (7, 0.25)
    assert obj.active_material.name.startswith("Synch Stripes")
    # Of a pattern that is gone:
    assert not empties(obj) and not obj.synch.result and "synch_number" not in obj.data.attributes
    np.testing.assert_array_equal(attribute(obj, "synch_phase"), attribute(obj, "synch_phase.1"))
    with pytest.raises(SynchError, match="has no solve in memory"):
        api.vary(obj, 1)


def test_a_single_solve_takes_the_animation_out():
    obj = swaying(sphere(), 2)
    obj.data.attributes.new("synch_phase.mine", "FLOAT", "POINT")
    api.animate(obj, frames=(1, 2), spacing=0.5)
    api.animate(obj, frames=(2, 2), pattern="quads", spacing=0.7)
    assert [m.node_group.name for m in obj.modifiers] == ["Synch Quad Frames"]
    assert "synch_phase.1" not in obj.data.attributes and "synch_phase_x.2" in obj.data.attributes
    api.stripes(obj, spacing=0.5)
    assert not obj.modifiers and [a.name for a in obj.data.attributes if "." in a.name[1:]] == ["synch_phase.mine"]


@pytest.mark.parametrize("is_seen", [False, True])
def test_relief_and_subdivisions_come_after(is_seen):
    obj = swaying(sphere(), 2)
    smooth = obj.modifiers.new("Subdivision", "SUBSURF")
    smooth.show_viewport = is_seen
    api.animate(obj, frames=(1, 2), spacing=0.7)
    assert [modifier.type for modifier in obj.modifiers] == ["NODES", "SUBSURF"]
    api.relief(obj, height=0.2, level=1)
    first, second = (attribute(seen(obj, frame), "position") for frame in (1, 2))
    assert len(first) > 3 * len(attribute(obj, "position")) and (first != second).any()
    again = api.animate(obj, frames=(1, 2), spacing=0.7)  # neither the relief nor the frames are in the way
    assert len(again["frames"]) == 2
    assert [modifier.type for modifier in obj.modifiers] == ["NODES", "SUBSURF", "NODES"]
    assert smooth.show_viewport is is_seen and obj.modifiers[0].show_viewport


# Refused, cancelled


def test_faces_that_change_are_refused_by_frame_and_modifier():
    obj = swaying(sphere(2), 3)
    obj.modifiers.new("Smooth", "SMOOTH")
    growing = obj.modifiers.new("Grower", "SUBSURF")
    for frame, levels in ((2, 0), (3, 1)):
        growing.levels = levels
        growing.keyframe_insert("levels", frame=frame)
    obj.modifiers.new("Cast", "CAST")
    bpy.context.scene.frame_set(1)
    before = snapshot()
    with pytest.raises(SynchError, match=r"frame 3: the modifier Grower .* hide it") as caught:
        api.animate(obj, frames=(1, 3), spacing=0.7)
    assert "\n" not in str(caught.value)
    assert snapshot() == before and all(modifier.show_viewport for modifier in obj.modifiers)
    assert bpy.context.scene.frame_current == 1
    assert len(api.animate(obj, frames=(1, 2), spacing=0.7)["frames"]) == 2


def test_a_shape_that_cannot_carry_a_field_is_refused_by_its_frame():
    points = attribute(sphere(2), "position").reshape(-1, 3)
    obj = moving(bpy.context.active_object, [points, points * [1, 1, 0] * 0])
    with pytest.raises(SynchError, match=r"^frame 2: "):
        api.animate(obj, frames=(1, 2), spacing=0.7)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (dict(frames=(3, 1)), "frames"),
        (dict(frames=(1, 2.5)), "frames"),
        (dict(frames=(1, 2), pattern="dots"), "pattern"),
        (dict(frames=(1, 2), hold=-1), "hold"),
        (dict(frames=(1, 2), symmetry="cross"), "stripes need"),
    ],
)
def test_settings_are_refused_in_one_line(settings, words):
    before = snapshot() if sphere(2) else None
    with pytest.raises(SynchError, match=words) as caught:
        api.animate(bpy.context.active_object, **settings)
    assert "\n" not in str(caught.value) and ": " in str(caught.value)
    assert snapshot() == before


def test_hidden_objects_are_refused():
    obj = swaying(sphere(2), 2)
    obj.hide_set(True)
    with pytest.raises(SynchError, match="show it"):
        api.animate(obj, frames=(1, 2))


@pytest.mark.parametrize("when", ["read frame 2", "frame 1: relax", "frame 2: descent"])
def test_cancelling_changes_nothing(when):
    obj = swaying(sphere(2), 2)
    before, asked = snapshot(), []

    def callback(stage, fraction):
        asked.append(fraction)
        return not stage.startswith(when)

    with pytest.raises(Cancelled):
        api.animate(obj, callback, frames=(1, 2), spacing=0.7)
    assert snapshot() == before and bpy.context.scene.frame_current == 1
    assert asked == sorted(asked) and 0 <= asked[-1] < 1


def test_more_frames_than_can_be_kept_are_refused_before_they_are_read():
    with pytest.raises(SynchError, match="the frames are 2 to 1000000: give 100000 frames or fewer at once"):
        api.animate(sphere(), frames=(2, 10**6))
