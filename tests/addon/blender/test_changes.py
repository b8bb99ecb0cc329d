# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept of a mesh is computed again once the mesh has changed, whatever changed it."""

import bpy
import pytest

from synch_fields.synch_addon.blender.changes import changes
from synch_fields.synch_addon.jobs.lru_cache import LruCache

from ..scenes import grid


def edit(obj):
    obj.data.vertices[0].co.z = 1.0
    obj.data.update()


def weigh(obj):
    obj.vertex_groups.new(name="weights").add([0], 0.5, "REPLACE")


def undo(_obj):
    bpy.ops.ed.undo_push(message="before")
    bpy.context.object.data.vertices[0].co.z = 2.0
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()


def move(obj):
    obj.location.x = 1.0


def bend_in_time(obj):
    """Go to a frame at which a shape key has another value."""
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="bent")
    key.data[0].co.z = 1.0
    for frame in (1, 10):
        key.value = frame / 10
        key.keyframe_insert("value", frame=frame)
    before = state(obj)
    bpy.context.scene.frame_set(5)
    assert changes.state(obj.data) != before


def add_another(_obj):
    grid().data.update()


def state(obj):
    bpy.context.view_layer.update()
    return changes.state(obj.data)


@pytest.mark.parametrize(
    "change, counts",
    [(edit, True), (weigh, True), (undo, True), (bend_in_time, True), (move, False), (add_another, False)],
)
def test_changes_of_a_mesh_count_in_every_file(change, counts):
    obj = grid()
    before = state(obj)
    assert state(obj) == before
    name = obj.name
    change(obj)
    assert (state(bpy.data.objects[name]) != before) == counts


def test_what_is_kept_is_made_again_for_another_state_only():
    shelf, made = LruCache(2), []

    def make():
        made.append(None)

    for key, at, count in (("a", 1, 1), ("a", 1, 1), ("a", 2, 2), ("b", 2, 3), ("a", 2, 3), ("c", 1, 4), ("a", 2, 5)):
        assert shelf.renewed(key, at, make) is None and len(made) == count
