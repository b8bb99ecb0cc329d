# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of a grid in a solid: all of them, once, and where they say."""

import numpy as np
import pytest

from synch_fields.core.extract.layers import voxels

from ...layered_solids import block, shell


def grid_of(counts, origin, step):
    return np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3) * step + origin


def points_inside(*arguments):
    """All batches together, and each point once."""
    places, tets, weights = (np.concatenate(parts) for parts in zip(*voxels.points_inside(*arguments), strict=True))
    _, first = np.unique(places, axis=0, return_index=True)
    return places[first], tets[first], weights[first]


@pytest.mark.parametrize("batch", [997, 500_000])
def test_points_are_those_inside_and_lie_where_their_weights_say(batch, monkeypatch):
    monkeypatch.setattr(voxels, "BATCH", batch)
    mesh = shell(np.linspace(1, 1.8, 4), 2, jitter=0.01)
    origin, step, counts = np.array([-1.9, -1.85, -1.8]), 0.11, (36, 35, 34)
    places, tets, weights = points_inside(mesh, origin, step, counts)
    points = origin + step * places
    np.testing.assert_allclose(np.einsum("ki,kix->kx", weights, mesh.vertices[mesh.tets[tets]]), points, atol=1e-12)
    assert weights.min() > -1e-8 and len(np.unique(places, axis=0)) == len(places)
    radius = np.linalg.norm(grid_of(counts, origin, step), axis=1)
    # The shell's walls are flat between the vertices on the spheres.
    assert ((radius > 1) & (radius < 1.74)).sum() <= len(places) <= ((radius > 0.94) & (radius < 1.8)).sum()
    found = np.linalg.norm(points, axis=1)
    assert found.min() > 0.94 and found.max() < 1.8
    assert len(places) * step**3 == pytest.approx(mesh.volumes.sum(), rel=0.02)


def test_points_on_the_walls_count():
    mesh = block((3, 3, 3), jitter=0.2)
    places, _, weights = points_inside(mesh, np.zeros(3), 0.25, (5, 5, 5))
    assert len(places) == 125 and weights.min() >= -1e-8
    assert len(points_inside(mesh, np.full(3, 0.5), 0.25, (2, 2, 2))[0]) == 8
    assert not list(voxels.points_inside(mesh, np.full(3, 1.5), 0.25, (2, 2, 2)))
