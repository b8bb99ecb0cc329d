# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Patterns behind other modifiers: phases go through as they are, and what vertices have is that of the base."""

from unittest.mock import MagicMock

import bpy
import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.core.errors import SynchError
from synch_fields.core.interpolate import evaluate
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.modifiers import carries, changing_modifiers
from synch_fields.synch_addon.panels.sidebar import draw_made

from ..rebuilt_pattern import largest_jump, phases_of, polygons_of
from ..scenes import attribute, bent, grid, quad_sphere, snapshot


class Evaluated:
    """What an object's modifiers make of it."""

    def __init__(self, obj):
        self.data = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data


def patterned(command, build=lambda: quad_sphere(9)):
    obj = build()
    getattr(api, command)(obj, spacing=0.45)
    return obj


def suffixes(obj):
    return ("_x", "_y") if "synch_phase_x" in obj.data.attributes else ("",)


def apart(lines, others):
    """(k,) sines of the angles between unit vectors that count with their opposites."""
    return np.linalg.norm(np.cross(lines, others), axis=1)


@pytest.mark.parametrize("command", ["stripes", "quads"])
def test_a_finer_mesh_has_the_pattern_of_the_base_at_its_vertices(command):
    obj = patterned(command)
    polygons, triangles = polygons_of(obj), polygons_of(obj).triangles
    count, base = len(obj.data.vertices), attribute(obj, "synch_pattern")
    edges = np.unique(np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1), axis=0)
    middles = attribute(obj, "position")[edges].mean(axis=1)
    which = [np.flatnonzero((triangles == a).any(axis=1) & (triangles == b).any(axis=1))[0] for a, b in edges]
    halves = ((triangles[which] == edges[:, :1]) | (triangles[which] == edges[:, 1:])) / 2
    waves = [np.cos(evaluate(phases_of(obj, s), polygons, np.array(which), halves)) for s in suffixes(obj)]
    obj.modifiers.new("Fine", "SUBSURF").subdivision_type = "SIMPLE"
    before = attribute(Evaluated(obj), "synch_pattern")
    api.carry(obj)
    fine = Evaluated(obj)
    after, places = attribute(fine, "synch_pattern"), attribute(fine, "position")
    np.testing.assert_allclose(after[:count], base, atol=1e-5)
    away, nearest = cKDTree(places).query(middles)
    at = away < 1e-6  # diagonals of quads have their middles elsewhere
    assert at.sum() > 2 * count - 10
    assert np.abs(after[nearest[at]] - np.prod(waves, axis=0)[at]).max() < 1e-4
    assert np.abs(before[nearest[at]] - np.prod(waves, axis=0)[at]).max() > 0.1  # means of cosines are none


def test_phases_go_on_from_face_to_face_behind_each_modifier():
    """But for the middle of a triangle with a defect, which has no phase."""
    for name, values in (("SUBSURF", {}), ("MIRROR", {}), ("SOLIDIFY", {"thickness": 0.1})):
        obj = patterned("stripes", lambda: bent(grid(24)))
        modifier = obj.modifiers.new(name, name)
        for key, value in values.items():
            setattr(modifier, key, value)
        api.carry(obj)
        made = Evaluated(obj)
        assert len(made.data.polygons) > len(obj.data.polygons)
        jump, compared = largest_jump(made)
        assert jump < 1e-3 and compared > 1000, name


def test_directions_lie_along_the_lines_of_the_base_and_their_phases_grow_to_the_left():
    obj = patterned("stripes", lambda: bent(grid(24)))
    along, phases = attribute(obj, "synch_direction"), attribute(obj, "synch_vertex_phase")
    obj.modifiers.new("Fine", "SUBSURF").subdivision_type = "SIMPLE"
    api.carry(obj)
    made, count = Evaluated(obj), len(along)
    carried = attribute(made, "synch_direction")
    np.testing.assert_allclose(np.linalg.norm(carried, axis=1), 1, atol=1e-4)
    off = apart(carried[:count], along)
    assert np.median(off) < np.sin(np.radians(2)) and np.percentile(off, 95) < np.sin(np.radians(6))
    same = np.sign((carried[:count] * along).sum(axis=1))
    found = np.exp(1j * attribute(made, "synch_vertex_phase")[:count])
    assert np.abs(found - np.exp(1j * same * phases))[off < 0.1].max() < 1e-3


def test_a_mirror_turns_directions_round_and_walls_have_the_same_on_both_sides():
    obj = patterned("stripes", lambda: bent(grid(24)))
    count = len(obj.data.vertices)
    mirror = obj.modifiers.new("Mirror", "MIRROR")
    mirror.use_axis, mirror.use_mirror_merge = (False, False, True), False
    api.carry(obj)
    made = Evaluated(obj)
    along, pattern = attribute(made, "synch_direction"), attribute(made, "synch_pattern")
    np.testing.assert_allclose(pattern[count:], pattern[:count], atol=1e-5)
    assert np.median(apart(along[count:], along[:count] * (1, 1, -1))) < 1e-4
    obj.modifiers.remove(mirror)
    wall = obj.modifiers.new("Wall", "SOLIDIFY")
    wall.thickness = 0.05
    obj.modifiers.move(len(obj.modifiers) - 1, 0)
    pattern = attribute(Evaluated(obj), "synch_pattern")
    np.testing.assert_allclose(pattern, np.tile(attribute(obj, "synch_pattern"), 2), atol=1e-5)


def test_the_modifier_is_one_of_ours_and_there_is_one_of_it():
    obj = grid()
    with pytest.raises(SynchError, match="no stripes or quads"):
        api.carry(obj)
    api.stripes(obj, spacing=0.45)
    assert api.carry(obj)["modifier"] == api.carry(obj)["modifier"]
    assert [carries(modifier) for modifier in obj.modifiers] == [True] and changing_modifiers(obj) == []
    report = api.quads(obj, spacing=0.45)
    assert not any("before its modifiers" in warning for warning in report["warnings"])
    api.carry(obj)
    (group,) = (modifier.node_group for modifier in obj.modifiers)
    assert group.name == "Synch Quad Carry" and group.is_modifier
    before = snapshot()
    assert bpy.ops.synch.carry() == {"FINISHED"} and snapshot() == before


@pytest.mark.any_surface
@pytest.mark.parametrize("surface", ["automatic", "faces"])
def test_it_is_offered_where_modifiers_follow_the_mesh_with_the_pattern(surface):
    """A surface of the pattern's own is of what the modifiers before it make."""
    obj = grid()
    obj.modifiers.new("Wall", "SOLIDIFY")

    def offered():
        layout = MagicMock()
        draw_made(layout, obj)
        return "synch.carry" in [call.args[0] for call in layout.operator.call_args_list]

    api.stripes(obj, spacing=0.45, surface=surface)
    assert offered() == (surface == "faces")
    later = obj.modifiers.new("Mirror", "MIRROR")
    assert offered()
    later.show_viewport = False
    assert offered() == (surface == "faces")
