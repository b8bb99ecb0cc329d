# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All corners of a bad quad mesh brought nearer to right angles on average."""

import numpy as np

from synch_fields.core.extract.quads.measure.quality import corner_angles, quality
from synch_fields.core.extract.quads.smooth.mean_angles import BAD_MEAN, NEAR, SHORT, lower_mean_angle
from synch_fields.core.geometry.barycentric import barycentric

from .test_worst_corners import CELLS, distances, grid, moved


def rough_grid(share, height=None):
    """The square of :func:`grid` with its inner vertices displaced by up to a share of a quad, on the surface."""
    mesh, quads, inside = grid(height)
    random = np.random.default_rng(0)
    by = random.uniform(-share, share, (inside.sum(), 3)) / CELLS
    quads = moved(quads, inside, by * [1, 1, 0])
    quads.vertices[:], quads.triangles[:] = mesh.finder.nearest(quads.vertices)
    quads.weights[:] = barycentric(mesh, quads.triangles, quads.vertices)
    return mesh, quads, inside


def mean(quads):
    return np.abs(corner_angles(quads) - 90).mean()


def test_displaced_vertices_find_right_angles_again():
    mesh, rough, inside = rough_grid(0.45)
    after = lower_mean_angle(rough, mesh, inside)
    assert mean(rough) > 2 * BAD_MEAN and mean(after) < mean(rough) / 4
    assert quality(after)["folds"] == 0
    np.testing.assert_array_equal(after.vertices[~inside], rough.vertices[~inside])
    at = np.einsum("nk,nkx->nx", after.weights, mesh.vertices[mesh.triangles[after.triangles]])
    np.testing.assert_allclose(after.vertices, at, atol=1e-12)


def test_good_meshes_stay_as_they_are():
    mesh, quads, inside = rough_grid(0.1)
    assert 2 < mean(quads) < BAD_MEAN
    assert lower_mean_angle(quads, mesh, inside) is quads


def test_faces_stay_near_a_ridge_and_edges_long():
    mesh, rough, inside = rough_grid(0.4, lambda x: -np.abs(x - 0.5))
    after = lower_mean_angle(rough, mesh, inside)
    assert mean(after) < 0.7 * mean(rough)
    ridge = np.column_stack([np.full(201, 0.5), np.linspace(0, 1, 201), np.zeros(201)])
    limit = max(distances(rough, ridge).max(), NEAR * rough.edge_lengths.mean())
    assert distances(after, ridge).max() <= 1.2 * limit
    shortest = min(rough.edge_lengths.min(), SHORT * rough.edge_lengths.mean())
    assert after.edge_lengths.min() >= shortest
