# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sharp edges beside others are left out where no quad fits between, and only there."""

import numpy as np
import pytest

from synch_fields.core.fields.constraints import crowded
from synch_fields.core.fields.constraints.crowded import without_crowded_lines
from synch_fields.core.fields.constraints.features import feature_edges
from synch_fields.core.geometry import TriangleMesh

from ...meshes import grid_quads, icosphere, split_quads

SIDE, LENGTH = 0.1, 1.0


def folded(*parts):
    """A sheet of width :data:`LENGTH` that goes on by a length in a direction of degrees, part after part."""
    steps = np.concatenate([
        np.full(max(round(length / 0.05), 1), length / max(round(length / 0.05), 1)) * np.exp(1j * np.radians(degrees))
        for length, degrees in parts
    ])  # fmt: skip
    across = np.append(0, np.cumsum(steps))
    along = np.linspace(0, LENGTH, 21)
    x, y = np.repeat(across, 21), np.tile(along, len(across))
    triangles = split_quads(grid_quads(len(across) - 1, 20))
    return TriangleMesh(np.column_stack([x.real, y, x.imag]), triangles)


def lines_left(mesh, side):
    """The places along the profile of the sharp edges that are left, without the boundary."""
    edges = feature_edges(mesh, np.radians(30), side)
    left = without_crowded_lines(mesh, edges, side)
    assert np.isin(edges[mesh.edge_face_counts[edges] == 1], left).all()
    inside = left[mesh.edge_face_counts[left] == 2]
    return sorted({tuple(place) for place in mesh.vertices[mesh.edges[inside, 0]][:, [0, 2]].round(6)})


@pytest.mark.parametrize("width", [0.03, 0.05])
def test_one_line_of_a_narrow_chamfer_is_left_and_the_sharper_one(width):
    """Of two bends by 40 and 50 degrees the latter stays; where a quad fits between, both."""
    mesh = folded((0.5, 0), (width, 40), (0.5, 90))
    second = np.array([0.5, 0]) + width * np.array([np.cos(np.radians(40)), np.sin(np.radians(40))])
    assert lines_left(mesh, SIDE) == [tuple(second.round(6))]
    assert len(lines_left(mesh, width / 2)) == 2


def test_a_narrow_step_keeps_one_line_and_a_thin_part_both():
    assert len(lines_left(folded((0.5, 0), (0.03, 90), (0.5, 0)), SIDE)) == 1
    assert len(lines_left(folded((0.5, 0), (0.03, 90), (0.5, 180)), SIDE)) == 2


def test_every_other_line_of_a_stair_of_narrow_steps_is_left():
    """Lines 0.03 apart, at sides of 0.08: of three neighbours in a row no two are left."""
    mesh = folded((0.5, 0), *[(0.03, 90), (0.03, 0)] * 4, (0.5, 90))
    places = np.array(lines_left(mesh, 0.08))
    assert 0 < len(places) < 6
    gaps = np.linalg.norm(places[:, None] - places, axis=2) + np.eye(len(places))
    assert gaps.min() > 0.6 * 0.08 - 0.01


def test_a_mirrored_surface_keeps_the_mirrored_lines():
    mesh = folded((0.5, 0), (0.03, 40), (0.4, 90), (0.02, 45), (0.5, 0))
    mirrored = TriangleMesh(mesh.vertices * [-1, 1, 1], mesh.triangles[:, ::-1])
    edges = feature_edges(mesh, np.radians(30), SIDE)
    left, others = (
        without_crowded_lines(one, one.edges_between(*mesh.edges[edges].T), SIDE) for one in (mesh, mirrored)
    )
    np.testing.assert_array_equal(np.sort(mesh.edges_between(*mirrored.edges[others].T)), np.sort(left))
    assert 0 < len(left) < len(edges)


def test_surfaces_without_lines_and_with_too_many_pairs_are_left_as_they_are(monkeypatch):
    assert len(without_crowded_lines(icosphere(1), np.empty(0, int), SIDE)) == 0
    mesh = folded((0.5, 0), (0.03, 40), (0.5, 90))
    edges = feature_edges(mesh, np.radians(30), SIDE)
    assert len(without_crowded_lines(mesh, edges, SIDE)) < len(edges)
    monkeypatch.setattr(crowded, "MOST_PAIRS", 10)
    np.testing.assert_array_equal(without_crowded_lines(mesh, edges, SIDE), edges)
