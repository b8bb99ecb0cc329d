# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects with shape keys: the first shape is measured, or the one that is locked."""

import bpy  # noqa: F401  its modules are on the path once it is loaded
import numpy as np
import pytest
from mathutils import Vector

from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.meshes import is_unchanged, measured_places
from synch_fields.synch_addon.patterns import memory
from synch_fields.synch_addon.patterns.picking import PickedSurface

from ..scenes import attribute, grid


def stretched():
    """A square of sides of 2 with a key that makes it three times as wide, at its full value."""
    obj = grid(48)
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Wide", from_mix=False)
    for point in key.points:
        point.co.x *= 3
    key.value = 1.0
    obj.active_shape_key_index = 1
    return obj


def lines(obj):
    """Turns of the phase across the square along X, and the report."""
    report = api.stripes(obj, spacing=0.5, guidance="axis:Y", symmetry="vector")
    phases = attribute(obj, "synch_vertex_phase")
    places = measured_places(obj)
    row = np.flatnonzero(np.isclose(places[:, 1], places[:, 1].min()))
    row = row[np.argsort(places[row, 0])]
    steps = np.angle(np.exp(1j * np.diff(phases[row])))
    return abs(steps.sum()) / (2 * np.pi), report


def test_the_first_shape_is_measured_whatever_is_mixed_or_the_locked_one():
    obj = stretched()
    turns, report = lines(obj)
    assert turns == pytest.approx(4, abs=0.01) and report["shape_key"] == "Basis"
    obj.show_only_shape_key = True
    turns, report = lines(obj)
    assert turns == pytest.approx(12, abs=0.01) and report["shape_key"] == "Wide"
    obj.data.shape_keys.key_blocks["Wide"].mute = True  # Blender shows the first then
    assert lines(obj)[1]["shape_key"] == "Basis"


def test_another_lock_is_another_mesh():
    obj = stretched()
    api.stripes(obj, spacing=0.5)
    given = memory.solve_of(obj).request.given
    assert is_unchanged(obj, given)
    obj.show_only_shape_key = True
    assert not is_unchanged(obj, given)


def test_objects_without_keys_have_none_in_the_report():
    assert "shape_key" not in api.stripes(grid(8), spacing=0.5)


def test_picked_places_are_on_the_measured_shape():
    obj = stretched()
    obj.show_only_shape_key = True
    surface = PickedSurface.of(obj)
    seen, own = surface.place_at(Vector((2.5, 0.3, 1)), Vector((0, 0, -1)))
    np.testing.assert_allclose(seen, (2.5, 0.3, 0), atol=1e-6)
    np.testing.assert_allclose(own, (2.5, 0.3, 0), atol=1e-6)
    obj.show_only_shape_key = False  # seen is still the mix, and the first shape is what is measured
    seen, own = PickedSurface.of(obj).place_at(Vector((2.5, 0.3, 1)), Vector((0, 0, -1)))
    np.testing.assert_allclose(seen, (2.5, 0.3, 0), atol=1e-6)
    np.testing.assert_allclose(own, (2.5 / 3, 0.3, 0), atol=1e-6)
