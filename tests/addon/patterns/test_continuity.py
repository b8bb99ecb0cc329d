# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The pattern as read back from a saved file: continuous across every edge, on faces of any size."""

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api

from ..rebuilt_pattern import largest_jump
from ..scenes import attribute, empties, grid, hexagon_sphere, quad_sphere, save_and_reopen, sphere, torus

TOLERANCE = 1e-4


@pytest.mark.parametrize(
    ("build", "edges", "symmetry"),
    [(sphere, 480, "LINE"), (quad_sphere, 648, "VECTOR"), (torus, 864, "LINE"), (grid, 408, "VECTOR")],
)
def test_saved_pattern_is_continuous_across_every_edge(build, edges, symmetry, tmp_path):
    obj = build()
    bpy.ops.synch.stripes(symmetry=symmetry, spacing=0.25)
    kinds = {e["synch_kind"] for e in empties(obj)}
    assert build is grid or "dislocation" in kinds
    obj = save_and_reopen(tmp_path / "striped.blend", obj.name)
    jump, compared = largest_jump(obj)
    assert compared == edges
    assert jump < TOLERANCE


def test_polygons_with_a_defect_are_split_and_reported(tmp_path):
    obj = hexagon_sphere()
    obj.data.uv_layers.new(name="Mine")
    count = len(obj.data.polygons)
    positions = attribute(obj, "position")
    report = api.stripes(obj, symmetry="line", spacing=0.3)
    (warning,) = [line for line in report["warnings"] if "split" in line]
    sizes = np.array([p.loop_total for p in obj.data.polygons])
    parts = np.count_nonzero(sizes == 3)
    assert parts > 0 and f"{count - np.count_nonzero(sizes > 3)} faces" in warning
    np.testing.assert_array_equal(attribute(obj, "position"), positions)
    assert "Mine" in obj.data.uv_layers
    for defect in report["disclinations"] + report["dislocations"]:
        assert sizes[defect["face"]] == 3
    obj = save_and_reopen(tmp_path / "hexagons.blend", obj.name)
    jump, compared = largest_jump(obj)
    assert compared == 3 * len(obj.data.loop_triangles) // 2
    assert jump < TOLERANCE


def test_regular_polygons_stay_whole():
    obj = hexagon_sphere()
    faces = [p.vertices[:] for p in obj.data.polygons]
    bpy.ops.synch.directions()
    assert [p.vertices[:] for p in obj.data.polygons] == faces


def test_quads_stay_quads_even_with_defects():
    obj = quad_sphere()
    faces = [p.vertices[:] for p in obj.data.polygons]
    bpy.ops.synch.stripes(spacing=0.25)
    assert np.count_nonzero(attribute(obj, "synch_singularity")) and empties(obj, "dislocation")
    assert [p.vertices[:] for p in obj.data.polygons] == faces


def test_a_torn_pattern_would_be_noticed():
    """The check above sees a single face whose phase is off."""
    obj = sphere()
    bpy.ops.synch.stripes(spacing=0.5)
    phase = obj.data.attributes["synch_phase"]
    assert largest_jump(obj)[0] < TOLERANCE
    phase.data[0].value += 0.5
    assert largest_jump(obj)[0] > 0.01
