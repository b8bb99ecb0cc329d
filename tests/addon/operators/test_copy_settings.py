# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of one object for others: all of them, and nothing that a solve left."""

import bpy
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.settings.fields import source_of

from .. import scenes


def values(group):
    """All that a group of properties holds, as plain values."""
    found = {}
    for name in set(group.bl_rna.properties.keys()) - {"rna_type"}:
        value = getattr(group, name)
        if isinstance(value, bpy.types.PropertyGroup):
            value = values(value)
        elif isinstance(value, bpy.types.bpy_prop_collection):
            value = [values(row) for row in value]
        elif isinstance(value, bpy.types.bpy_prop_array):
            value = tuple(value)
        found[name] = value
    return found


def test_the_selected_objects_get_every_setting_and_nothing_of_the_result():
    first, second = scenes.grid(4), scenes.grid(5)
    bpy.ops.object.select_all(action="SELECT")
    bpy.context.view_layer.objects.active = first
    plain = values(second.synch)
    synch = first.synch
    synch.symmetry, synch.spacing, synch.automatic_spacing, synch.mirror = "CROSS", 0.3, False, (True, False, True)
    synch.guidance, synch.guide.kind, synch.guide.strength = "BLEND", "AXIS", 3.0
    for kind in ("AXIS", "CURVATURE_MAX"):
        synch.guides.add().kind = kind
    row = synch.constraints.add()
    row.where, row.what, row.vertex_group, row.soft = "GROUP", "ACROSS", "rim", True
    synch.result, second.synch.result = "{}", "kept"
    second.synch.constraints.add()
    assert values(synch) != plain
    assert bpy.ops.synch.copy_settings() == {"FINISHED"}
    given, taken = values(synch), values(second.synch)
    assert taken.pop("result") == "kept" and given.pop("result") == "{}"
    assert taken == given and len(taken["guides"]) == 2


def test_what_gets_the_settings_of_a_quad_mesh_is_none_itself():
    """Else Quad Mesh Again would put the quads of the other object's source in place of its faces."""
    ball = scenes.sphere()
    made = bpy.data.objects[api.quad_mesh(ball, faces=200)["quad_mesh"]["object"]]
    other = scenes.grid(4)
    other.synch_simple.kind = "quad_mesh"
    made.select_set(True)
    bpy.context.view_layer.objects.active = made
    made.synch.loops = 50
    assert source_of(made) == ball and made.synch.made_from
    assert bpy.ops.synch.copy_settings() == {"FINISHED"}
    assert other.synch.loops == 50 and source_of(other) is None
    assert other.synch.source is None and not (other.synch.made_from or other.synch.made_along)


def test_copying_needs_another_selected_mesh():
    obj = scenes.grid(4)
    obj.select_set(True)
    with pytest.raises(RuntimeError, match="select other meshes too"):
        bpy.ops.synch.copy_settings()
