# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Empties stand where the defects are, and are those of the last run."""

import bpy
import numpy as np
from mathutils import Vector

from synch_fields.synch_addon.blender.defect_empties import defect_empties, write_defects

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
    collection = bpy.data.collections["Synch Defects: face"]
    assert set(collection.objects) == {plus, minus, turn}
    assert collection.name in bpy.data.collections["Synch Defects"].children
    assert "Synch Defects" in bpy.context.scene.collection.children


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


def test_two_objects_keep_their_own_empties_and_hidden_collections_stay_hidden():
    first, second = FACES["regular quad"].build(), FACES["regular quad"].build()
    write_defects(first, some_defects())
    write_defects(second, some_defects())
    bpy.data.collections["Synch Defects: face"].hide_viewport = True
    write_defects(first, some_defects()[:2])
    assert len(defect_empties(first)) == 2 and len(defect_empties(second)) == 3
    assert bpy.data.collections["Synch Defects: face"].hide_viewport
    write_defects(first, [])
    assert "Synch Defects: face" not in bpy.data.collections
    assert len(bpy.data.collections["Synch Defects: face.001"].objects) == 3
