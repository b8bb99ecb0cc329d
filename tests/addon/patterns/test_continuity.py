# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The pattern as read back from a saved file: continuous across every edge, on faces of any size."""

from fractions import Fraction

import bpy
import numpy as np
import pytest

from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api

from ..quad_meshes import mixed_sphere
from ..rebuilt_pattern import largest_jump
from ..scenes import attribute, empties, grid, hexagon_sphere, quad_sphere, save_and_reopen, sphere, torus

TOLERANCE = 1e-4


def test_regular_polygons_stay_whole():
    obj = hexagon_sphere()
    faces = [p.vertices[:] for p in obj.data.polygons]
    bpy.ops.synch.directions()
    assert [p.vertices[:] for p in obj.data.polygons] == faces


@pytest.mark.parametrize(
    ("build", "edges", "command", "settings"),
    [
        (sphere, 480, "stripes", {"spacing": 0.25, "symmetry": "line"}),
        (quad_sphere, 648, "stripes", {"spacing": 0.25, "symmetry": "vector"}),
        (torus, 864, "stripes", {"spacing": 0.25, "symmetry": "line"}),
        (grid, 408, "stripes", {"spacing": 0.25, "symmetry": "vector"}),
        (sphere, 480, "quads", {"spacing": 0.22}),
        (torus, 864, "quads", {"spacing": 0.3}),
        (mixed_sphere, 1152, "quads", {"spacing": 0.25}),
        (grid, 408, "quads", {"spacing": 0.3}),
    ],
)
def test_saved_pattern_is_continuous_across_every_edge(build, edges, command, settings, tmp_path):
    """Triangles and quads stay whole even with defects."""
    obj = build()
    faces = [p.vertices[:] for p in obj.data.polygons]
    getattr(api, command)(obj, **settings)
    kinds = {e["synch_kind"] for e in empties(obj)}
    assert build is grid or kinds >= {"dislocation", *(["disclination"] if command == "quads" else [])}
    assert [p.vertices[:] for p in obj.data.polygons] == faces or build is mixed_sphere
    obj = save_and_reopen(tmp_path / "pattern.blend", obj.name)
    jump, compared = largest_jump(obj)
    assert compared == edges
    assert jump < TOLERANCE


@pytest.mark.parametrize("command, spacing", [("stripes", 0.3), ("quads", 0.25)])
def test_polygons_with_a_defect_are_split_and_reported(command, spacing, tmp_path):
    obj = hexagon_sphere()
    obj.data.uv_layers.new(name="Mine")
    count = len(obj.data.polygons)
    positions = attribute(obj, "position")
    report = getattr(api, command)(obj, spacing=spacing)
    (warning,) = [line for line in report["warnings"] if "split" in line]
    sizes = np.array([p.loop_total for p in obj.data.polygons])
    assert (sizes == 3).any() and f"{count - np.count_nonzero(sizes > 3)} faces" in warning
    np.testing.assert_array_equal(attribute(obj, "position"), positions)
    assert "Mine" in obj.data.uv_layers and report["disclinations"]
    for defect in report["disclinations"] + report["dislocations"]:
        assert sizes[defect["face"]] == 3
    obj = save_and_reopen(tmp_path / "hexagons.blend", obj.name)
    jump, compared = largest_jump(obj)
    assert compared == 3 * len(obj.data.loop_triangles) // 2
    assert jump < TOLERANCE


@pytest.mark.parametrize("method", ["sdp", "spectral", "diffusion"])
@pytest.mark.parametrize("command", ["stripes", "quads"])
def test_every_method_gives_a_continuous_pattern(command, method):
    obj = sphere()
    report = getattr(api, command)(obj, spacing=0.5, method=method)
    assert sum(Fraction(d["index"]) for d in report["disclinations"]) == 2
    assert report["lower_bound"] <= report["energy"]
    assert largest_jump(obj)[0] < TOLERANCE


@pytest.mark.parametrize("name", ["synch_phase", "synch_phase_y", "synch_closing", "synch_disclination_x"])
def test_a_torn_pattern_would_be_noticed(name):
    """The checks above see a single face that is off."""
    obj = sphere()
    api.run("stripes" if name == "synch_phase" else "quads", obj, SurfaceSettings(spacing=0.5))
    assert largest_jump(obj)[0] < TOLERANCE
    torn = int(np.flatnonzero(attribute(obj, "synch_singularity"))[0])
    found = obj.data.attributes[name]
    if found.domain == "CORNER":
        found.data[0].value += 0.5
    elif name == "synch_closing":
        found.data[torn].vector = (1.0, 2.0)
    else:
        found.data[torn].color = (2.0, 0.3, 0.7, 0.0)
    assert largest_jump(obj)[0] > 0.01
