# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Variations of an opened file: found again by the same solve, while the pattern that is shown stays as it is."""

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.jobs.job import run
from synch_fields.synch_addon.patterns import memory
from synch_fields.synch_addon.patterns.found_again import VariationsJob

from ..scenes import grid, mark_edges, places, save_and_reopen
from .test_favourites import agree, pattern, solved


@pytest.mark.parametrize("kind", ["stripes", "quads with a map"])
@pytest.mark.parametrize("number", [0, 2])
def test_variations_are_found_again_and_the_pattern_stays(kind, number, tmp_path):
    obj = solved(kind)
    other = api.vary(obj, 3)["energy"]
    energy = api.vary(obj, number)["energy"]
    before = pattern(obj)
    obj = save_and_reopen(tmp_path / "kept.blend", obj.name)
    assert not memory.holds(obj)
    assert bpy.ops.synch.find_variations() == {"FINISHED"}
    assert agree(obj, before) and obj.synch_shown.variation == number
    state = memory.recall(obj)
    assert state.plain["energy"] == pytest.approx(energy, rel=1e-5) and state.number == number
    assert api.vary(obj, 3)["energy"] == pytest.approx(other, rel=1e-5)
    assert not bpy.ops.synch.find_variations.poll()  # they are there


def test_placed_defects_stay(tmp_path):
    obj = solved("stripes")
    ends = len(api.place_defects(obj, [17])["dislocations"])
    before = pattern(obj)
    obj = save_and_reopen(tmp_path / "kept.blend", obj.name)
    assert bpy.ops.synch.find_variations() == {"FINISHED"} and agree(obj, before)
    assert len(memory.recall(obj).plain["dislocations"]) == ends


def test_a_changed_mesh_is_told(tmp_path):
    obj = solved("stripes")
    obj = save_and_reopen(tmp_path / "kept.blend", obj.name)
    coordinates = np.empty(3 * len(obj.data.vertices), np.float32)
    obj.data.vertices.foreach_get("co", coordinates)
    coordinates[2::3] *= 2
    obj.data.vertices.foreach_set("co", coordinates)
    obj.data.update()
    assert "this is another pattern" in run(VariationsJob(obj))["warnings"][-1] and memory.holds(obj)


def test_a_pattern_with_cuts_is_refused():
    obj = grid()
    mark_edges(obj, "seams", np.abs(places(obj)[:, 0]) < 1e-6)
    row = obj.synch.constraints.add()
    row.where, row.what = "SEAMS", "CUT"
    assert bpy.ops.synch.stripes(spacing=0.3) == {"FINISHED"}
    memory.forget(obj)
    with pytest.raises(RuntimeError, match="has cuts"):
        bpy.ops.synch.find_variations()
