# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Loops of quads on grids, whose number and lengths are known, and on a helix, where one loop is all of them."""

import numpy as np
import pytest

from synch_fields.core.extract.quads.measure.loops import quad_loops
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh

from ...meshes import grid_quads, voxel_quads


def of_quads(faces, seed=None):
    """A QuadMesh of faces alone; with a seed, each begins at a random corner."""
    faces = [
        np.roll(face, 0 if seed is None else np.random.default_rng(seed + k).integers(9))
        for k, face in enumerate(faces)
    ]
    count = max(map(max, faces)) + 1
    return QuadMesh(np.zeros((count, 3)), None, None, np.concatenate(faces), np.array([len(face) for face in faces]))


def tube(around, across, step):
    """Quads of a closed tube, so many around in one direction, and after each turn some rows on."""
    i, j = (a.ravel() for a in np.mgrid[:around, :across])

    def vertex(i, j):
        return (i % around) * across + (j + step * (i // around)) % across

    return np.column_stack([vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)])


@pytest.mark.parametrize("seed", [None, 0])
def test_a_grid_has_its_rows_and_columns(seed):
    loops = quad_loops(of_quads(grid_quads(5, 3), seed))
    assert sorted(loops.lengths.tolist()) == [3] * 5 + [5] * 3
    assert (np.diff(loops.lengths) <= 0).all()
    assert loops.figures == {"loops": 8, "longest_loop": 5, "spirals": 0, "short_loop_share": 1.0}


def test_every_loop_of_a_cube_goes_around_it():
    cells = 3
    _, faces = voxel_quads(np.argwhere(np.ones((cells, cells, cells), bool)))
    loops = quad_loops(of_quads(faces, 1))
    assert loops.lengths.tolist() == [4 * cells] * (3 * cells)
    assert not loops.spirals.any()


@pytest.mark.parametrize(("across", "step"), [(3, 1), (5, 1), (16, 1), (16, 2), (16, 4), (16, 8), (40, 20)])
def test_on_a_tube_that_closes_some_quads_further_loops_are_spirals(across, step):
    around = 12
    loops = quad_loops(of_quads(tube(around, across, step)))
    count = np.gcd(step, across)
    turns = across // count
    winding = loops.lengths == around * turns
    assert winding.sum() == count + around * (around * turns == across)
    assert sorted(loops.lengths.tolist()) == sorted([around * turns] * count + [across] * around)
    # Two turns are there and back, or come by far away.
    assert loops.spirals.sum() == (count if turns > 2 else 0)


def test_loops_end_at_other_faces():
    faces = [face.tolist() for face in grid_quads(3, 3)]
    middle = faces.pop(4)
    faces += [middle[:3], [middle[0], middle[2], middle[3]]]
    loops = quad_loops(of_quads(faces))
    # The middle row and column are cut into two loops each of one quad; the triangles' common side is in none.
    assert loops.lengths.tolist() == [3] * 4 + [1] * 4


@pytest.mark.parametrize("turns", [2, 3, 4])
def test_a_ribbon_wound_on_a_tube_is_one_spiral_wherever_its_faces_begin(turns):
    """Its upper side is its lower one a turn later; its middle comes first among the faces, where no loop ends."""
    around = 12
    faces = np.arange(around * turns)[:, None] + (0, 1, around + 1, around)
    faces = faces[np.argsort(np.abs(np.arange(len(faces)) - (len(faces) - 1) / 2), kind="stable")]
    loops = quad_loops(of_quads(faces))
    assert loops.lengths.tolist() == [around * turns] + [turns] * around
    assert loops.spirals.tolist() == [turns > 2] + [False] * around
