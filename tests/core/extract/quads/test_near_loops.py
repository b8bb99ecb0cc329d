# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Walks that come back beside their beginning, on tubes whose turns are known and around cones."""

import numpy as np
import pytest

from synch_fields.core.extract.quads.measure.near_loops import ASIDE, near_loops

from ...meshes import voxel_quads
from .test_quad_loops import of_quads, tube


def rows_of(near):
    """(steps, aside, quads) of each class."""
    return sorted(zip(near.steps.tolist(), near.asides.tolist(), near.quads.tolist(), strict=True))


@pytest.mark.parametrize("seed", [None, 0])
@pytest.mark.parametrize(("across", "step"), [(40, 0), (40, 1), (40, 3), (40, ASIDE), (40, ASIDE + 1), (16, 5)])
def test_a_tube_comes_back_as_many_quads_aside_as_it_is_twisted(across, step, seed):
    around = 12
    near = near_loops(of_quads(tube(around, across, step), seed), 45)
    turns = {}
    for turn in range(1, 4):  # each place beside is reached by the shortest walk
        aside = min(turn * step % across, -turn * step % across)
        if aside <= ASIDE and aside not in turns.values():
            turns[around * turn] = aside
    expected = [(steps, aside, around * across) for steps, aside in turns.items()]
    assert rows_of(near) == sorted([*expected, (across, 0, around * across)])


@pytest.mark.parametrize(("across", "step"), [(40, 3), (40, 0)])
def test_walks_are_closed_and_follow_edges(across, step):
    quads = of_quads(tube(12, across, step))
    edges = {tuple(edge) for edge in quads.edges[0].tolist()}
    near = near_loops(quads, 45)
    for walk, steps, aside in zip(near.walks, near.steps, near.asides, strict=True):
        assert walk[0] == walk[-1] and len(walk) == steps + aside + 1
        assert all(tuple(sorted(way)) in edges for way in zip(walk[:-1].tolist(), walk[1:].tolist(), strict=True))


def test_loops_of_a_cube_are_three_classes():
    """One for each axis; its corners lie between them."""
    cells = 5
    _, faces = voxel_quads(np.argwhere(np.ones((cells, cells, cells), bool)))
    near = near_loops(of_quads(faces, 1), 4 * cells)
    closed = near.asides == 0
    assert near.steps[closed].tolist() == [4 * cells] * 3
    assert near.quads[closed].tolist() == [4 * cells * cells] * 3


def test_walks_end_at_other_faces():
    faces = [face.tolist() for face in tube(12, 9, 0)]
    middle = faces.pop(0)
    faces += [middle[:3], [middle[0], middle[2], middle[3]]]
    near = near_loops(of_quads(faces), 12)
    assert near.quads[near.steps == 12].sum() == 12 * 8 and near.quads[near.steps == 9].sum() == 9 * 11
