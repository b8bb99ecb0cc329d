# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the box "Result" knows of an object: whether its mesh has changed since, and where its defects are."""

import bpy
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.defect_empties import collection_of_defects, defect_empties
from synch_fields.synch_addon.patterns import memory

from ..scenes import empties, grid, sphere


@pytest.fixture
def solved():
    obj = sphere()
    api.stripes(obj, spacing=0.5)
    bpy.context.view_layer.update()
    return obj


def test_a_result_is_of_its_mesh_until_that_changes(solved):
    assert not memory.is_outdated(solved)
    solved.data.vertices[0].co.x += 0.1
    solved.data.update()
    bpy.context.view_layer.update()
    assert memory.is_outdated(solved)
    api.stripes(solved, spacing=0.5)
    bpy.context.view_layer.update()
    assert not memory.is_outdated(solved)
    solved.scale.z = 2
    bpy.context.view_layer.update()
    assert memory.is_outdated(solved)


def test_it_is_looked_at_once_after_a_change(solved, monkeypatch):
    looked = []
    monkeypatch.setattr(memory.own_surface, "is_unchanged", lambda *_: looked.append(1) or True)
    for _ in range(5):
        assert not memory.is_outdated(solved)
    assert len(looked) == 1


def test_variations_and_modes_are_no_change(solved):
    api.vary(solved, 1)
    bpy.context.view_layer.update()
    assert not memory.is_outdated(solved)
    bpy.ops.object.mode_set(mode="EDIT")
    assert not memory.is_outdated(solved)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert not memory.is_outdated(grid())


def test_the_collection_of_defects_hides_them_all(solved):
    found = collection_of_defects(solved)
    assert set(defect_empties(solved)) == set(found.objects) and len(found.objects) > 0
    found.hide_viewport = True
    api.stripes(solved, spacing=0.4)
    assert collection_of_defects(solved) == found and found.hide_viewport
    plain = bpy.data.collections.new("Mine")
    bpy.context.scene.collection.children.link(plain)
    for empty in empties(solved):
        found.objects.unlink(empty)
        plain.objects.link(empty)
    assert collection_of_defects(solved) is None and collection_of_defects(grid()) is None
