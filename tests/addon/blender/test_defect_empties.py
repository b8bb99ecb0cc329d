# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Empties stand where the defects are, and are those of the last run."""

import bpy
import numpy as np
from mathutils import Vector

from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import left_defects
from synch_fields.synch_addon.blender.defect_empties import defect_empties, orphaned_empties, write_defects
from synch_fields.synch_addon.operators.defects import place_of

from ..scenes import sphere
from ..single_faces import FACES, some_defects

EMPTY_NAMES = ["disclination +1/2.001", "disclination -1/2.001", "dislocation +1.001"]


def test_empties_stand_where_the_defects_are():
    obj = FACES["regular quad"].build()
    obj.location, obj.scale = (1, 2, 3), (2, 2, 2)
    write_defects(obj, some_defects(), length=0.1)
    bpy.context.view_layer.update()
    plus, minus, turn = (bpy.data.objects[name] for name in EMPTY_NAMES)
    assert np.allclose(plus.matrix_world.translation, (1.2, 2.4, 3.0))
    assert plus["synch_index"] == 0.5 and minus["synch_index"] == -0.5
    assert turn["synch_kind"] == "dislocation" and turn["synch_face"] == 2
    assert np.allclose(turn.matrix_world.to_quaternion() @ Vector((0, 0, 1)), (1, 0, 0), atol=1e-6)
    assert plus.color[0] > plus.color[2] and minus.color[2] > minus.color[0]
    assert plus.empty_display_type != turn.empty_display_type
    collection = bpy.data.collections["Defects: face"]
    assert set(collection.objects) == {plus, minus, turn}
    assert collection.name in bpy.data.collections["Defects"].children
    assert "Defects" in bpy.context.scene.collection.children


def test_a_second_run_replaces_the_empties_of_the_kinds_that_it_is_given():
    obj = FACES["regular quad"].build()
    write_defects(obj, some_defects())
    write_defects(obj, some_defects())
    assert sorted(bpy.data.objects.keys()) == sorted([*EMPTY_NAMES, "face"])
    write_defects(obj, some_defects()[:1], kinds=("disclination",))
    assert sorted(bpy.data.objects.keys()) == sorted([EMPTY_NAMES[0], EMPTY_NAMES[2], "face"])
    assert len(bpy.data.collections) == 2
    write_defects(obj, [], kinds=("dislocation",))
    assert sorted(bpy.data.objects.keys()) == sorted([EMPTY_NAMES[0], "face"])
    write_defects(obj, [])
    assert bpy.data.objects.keys() == ["face"] and not bpy.data.collections


def test_collections_of_earlier_versions_get_the_present_names():
    obj = FACES["regular quad"].build()
    write_defects(obj, some_defects())
    for collection in list(bpy.data.collections):  # a new name moves one
        collection.name = f"Synch {collection.name}"
    write_defects(FACES["regular quad"].build(), some_defects())
    write_defects(obj, some_defects())
    assert sorted(bpy.data.collections.keys()) == ["Defects", "Defects: face", "Defects: face.001"]
    for collection in list(bpy.data.collections):  # a new name moves one
        collection.name = f"Synch {collection.name}"
    delete(obj)
    assert len(orphaned_empties()) == 3


def test_two_objects_keep_their_own_empties_and_hidden_collections_stay_hidden():
    first, second = FACES["regular quad"].build(), FACES["regular quad"].build()
    write_defects(first, some_defects())
    write_defects(second, some_defects())
    bpy.data.collections["Defects: face"].hide_viewport = True
    write_defects(first, some_defects()[:2])
    assert len(defect_empties(first)) == 2 and len(defect_empties(second)) == 3
    assert bpy.data.collections["Defects: face"].hide_viewport
    write_defects(first, [])
    assert "Defects: face" not in bpy.data.collections
    assert len(bpy.data.collections["Defects: face.001"].objects) == 3


def test_a_new_collection_may_be_hidden_and_what_a_user_shows_stays_shown():
    obj = sphere()
    obj.location, obj.rotation_euler = (1, 2, 3), (0.3, 0, 1)
    bpy.context.view_layer.update()
    first = write_defects(obj, some_defects(), mesh=obj.data)[0]
    bpy.context.view_layer.update()
    place = first.matrix_world.copy()
    write_defects(obj, [])
    hidden = write_defects(obj, some_defects(), mesh=obj.data, hidden=True)[0]
    (collection,) = hidden.users_collection
    assert collection.hide_viewport and not hidden.visible_get()
    np.testing.assert_allclose(place_of(hidden), place, atol=1e-6)
    collection.hide_viewport = False
    assert write_defects(obj, some_defects(), mesh=obj.data, hidden=True)[0].visible_get()


def delete(obj):
    bpy.ops.object.select_all(action="DESELECT")
    obj.select_set(True)
    bpy.ops.object.delete()
    bpy.context.view_layer.update()


def test_empties_of_a_deleted_object_go_and_undo_brings_both_back():
    obj, other = (FACES["regular quad"].build() for _ in range(2))
    for one in (obj, other):
        write_defects(one, some_defects())
    name, free = obj.name, bpy.data.objects.new("Mine", None)
    bpy.data.collections[f"Defects: {name}"].objects.link(free)
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="before")
    delete(obj)
    bpy.ops.ed.undo_push(message="deleted")
    assert left_defects._watch._timer.runs
    left_defects.remove_left_defects()
    assert len(defect_empties(bpy.data.objects[other.name])) == 3
    assert {o.name for o in bpy.data.objects if o.type == "EMPTY" and o.parent is None} == {"Mine"}
    for _ in range(2):
        bpy.ops.ed.undo()
        back = bpy.data.objects[name]
        assert len(defect_empties(back)) == 3
        assert len(bpy.data.collections[f"Defects: {name}"].objects) == 4
        bpy.ops.ed.redo()
        assert name not in bpy.data.objects
        left_defects.remove_left_defects()


def test_empties_that_a_user_frees_from_their_object_stay():
    obj = FACES["regular quad"].build()
    write_defects(obj, some_defects())
    for empty in defect_empties(obj):
        empty.parent = None
    left_defects.remove_left_defects()
    assert sum(o.type == "EMPTY" for o in bpy.data.objects) == 3


def test_the_collection_of_a_deleted_object_goes_with_its_empties():
    obj = FACES["regular quad"].build()
    write_defects(obj, some_defects())
    bpy.data.objects.remove(obj)
    left_defects.remove_left_defects()
    assert not bpy.data.objects and not bpy.data.collections


def test_empties_follow_the_faces_where_modifiers_bend_them():
    obj = sphere()
    obj.scale, obj.rotation_euler = (1, 2, 1.5), (0.3, 0.4, 0.5)
    api.stripes(obj, spacing=0.5, surface="faces")
    bpy.context.view_layer.update()
    found = defect_empties(obj)
    assert found and all(empty.parent_type == "VERTEX_3" for empty in found)
    for empty in found:  # their location stays that in the object's space
        place = obj.matrix_world @ empty.location
        assert np.allclose(empty.matrix_world.translation, place, atol=1e-5)
    obj.modifiers.new("Array", "ARRAY")
    bend = obj.modifiers.new("Twist", "SIMPLE_DEFORM")
    bend.deform_method, bend.angle = "TWIST", 2.0
    depsgraph = bpy.context.evaluated_depsgraph_get()
    seen = obj.evaluated_get(depsgraph).data
    for empty in found:
        corners = [obj.matrix_world @ seen.vertices[v].co for v in obj.data.polygons[empty["synch_face"]].vertices]
        middle = sum(corners, Vector()) / len(corners)
        assert (empty.matrix_world.translation - middle).length < 0.05
    obj.modifiers.new("Remesh", "REMESH")
    api.stripes(obj, spacing=0.45, surface="faces")
    assert all(empty.parent_type == "OBJECT" for empty in defect_empties(obj))
