# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small pictures: what is seen at each point is what a ray from the eye meets first, and shows the pattern there."""

import numpy as np
import pytest

from synch_fields.core.extract.pictures.thumbnails import Seen
from synch_fields.core.fields import direction_field
from synch_fields.core.fields.patterns import PatternWishes, solve_pattern

from ...meshes import icosphere, mixed_torus

PIXELS = 24
# From in front, a little to the right and above.
VIEW = np.array([[0.912, 0.41, 0], [-0.17, 0.377, 0.91], [0.373, -0.83, 0.414]])


def met_first(seen):
    """Triangle and depth that a ray meets first at each point, by trying all; -1 where there is none."""
    corners = seen.places[seen.corners]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    found, depths = np.full(seen.size**2, -1), np.full(seen.size**2, -np.inf)
    for point in range(seen.size**2):
        offset = np.array([point % seen.size, point // seen.size]) + 0.5 - corners[:, 0, :2]
        b, c = np.linalg.solve(np.stack([first[:, :2], second[:, :2]], axis=2), offset[..., None])[..., 0].T
        depth = np.where(
            (b >= 0) & (c >= 0) & (b + c <= 1), corners[:, 0, 2] + b * first[:, 2] + c * second[:, 2], -np.inf
        )
        if depth.max() > -np.inf:
            found[point], depths[point] = depth.argmax(), depth.max()
    return found, depths


@pytest.mark.parametrize("mesh", [icosphere(2), mixed_torus()[0]], ids=["sphere", "torus"])
def test_what_a_ray_meets_first_is_seen(mesh):
    seen = Seen.of(mesh.vertices, mesh.triangles, PIXELS, VIEW)
    found, depths = met_first(seen)
    np.testing.assert_array_equal(np.sort(seen.points), np.flatnonzero(found >= 0))
    reached = np.einsum("ki,kix->kx", seen.weights, seen.places[mesh.triangles[seen.triangles]])
    np.testing.assert_allclose(reached[:, 2], depths[seen.points], atol=1e-9)
    np.testing.assert_allclose(reached[:, 0], seen.points % seen.size + 0.5, atol=1e-9)
    np.testing.assert_allclose(reached[:, 1], seen.points // seen.size + 0.5, atol=1e-9)


@pytest.mark.parametrize("symmetry", [2, 4])
def test_ink_is_where_lines_are(symmetry):
    mesh = icosphere(3)
    pattern = solve_pattern(mesh, direction_field(mesh, symmetry), PatternWishes(0.6))
    seen = Seen.of(mesh.vertices, mesh.triangles, PIXELS, VIEW)
    ink = seen.ink(pattern.edge_phases)
    at_vertex = seen.weights.max(axis=1) > 0.9
    nearest = mesh.triangles[seen.triangles[at_vertex], seen.weights[at_vertex].argmax(axis=1)]
    heights = np.cos(pattern.vertex_phases[nearest])
    wanted = (1 + heights[:, 0]) / 2 if symmetry == 2 else np.max(heights**8, axis=1)
    assert at_vertex.sum() > 20 and np.abs(ink[at_vertex] - wanted).max() < 0.35
    assert np.corrcoef(ink[at_vertex], wanted)[0, 1] > 0.97


def test_dots_are_drawn_where_they_are_not_hidden():
    mesh = icosphere(3)
    seen = Seen.of(mesh.vertices, mesh.triangles, PIXELS, VIEW)
    plain = seen.picture((0, 0, 0), (1, 1, 1), np.zeros(len(seen.points)), [])
    depths = seen.places[mesh.triangles][..., 2].mean(axis=1)
    for triangle, is_seen in ((depths.argmax(), True), (depths.argmin(), False)):
        dotted = seen.picture((0, 0, 0), (1, 1, 1), np.zeros(len(seen.points)), [([triangle], (1, 0, 0))])
        row, column = np.nonzero(np.abs(dotted - plain).max(axis=2))
        assert bool(len(row)) == is_seen
        if is_seen:
            middle = seen.places[mesh.triangles[triangle], :2].mean(axis=0) / seen.size * PIXELS
            assert np.abs(np.column_stack([column, row]) + 0.5 - middle).max() < 2
    assert plain.shape == (PIXELS, PIXELS, 4) and plain[0, 0, 3] == 0 and plain[PIXELS // 2, PIXELS // 2, 3] == 1


def test_surfaces_without_extent_have_pictures():
    flat = Seen.of(np.zeros((3, 3)), np.array([[0, 1, 2]]), PIXELS, VIEW)
    assert np.isfinite(flat.picture((0, 0, 0), (1, 1, 1), np.zeros(len(flat.points)), [([0], (1, 0, 0))])).all()
