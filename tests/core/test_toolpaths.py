# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths on layers: straight on planes, circles on spheres, and on the layer that they say."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.extract.layer_surfaces import layer_surfaces
from synch_fields.core.extract.toolpaths import toolpaths
from synch_fields.core.fields.layers import LayerGroup, solve_layers
from synch_fields.core.fields.solid_guidance import axis_directions

from .layered_solids import block, shell


def test_on_planes_paths_are_straight_and_evenly_spaced():
    mesh = block((5, 5, 5), jitter=0.2)
    floor = LayerGroup.of_vertices(mesh, mesh.vertices[:, 2] == 0, 0.0)
    pattern = solve_layers(mesh, axis_directions(mesh, (0, 0, 1)), 0.23, [floor])
    layers = layer_surfaces(pattern.edge_phases, pattern.heights)
    lines, numbers = toolpaths(layers, mesh.vertices[:, 0] - 0.05, 0.1)
    np.testing.assert_array_equal(numbers, np.repeat(np.arange(5), 10))
    np.testing.assert_allclose(lines.lengths, 1, rtol=1e-6)
    points = lines.points
    np.testing.assert_allclose(points[:, 2], 0.23 * numbers[lines.numbers], atol=1e-7)
    first = points[lines.starts, 0]
    np.testing.assert_allclose(points[:, 0], first[lines.numbers], atol=1e-7)
    for number in range(5):
        np.testing.assert_allclose(np.sort(first[numbers == number]), np.arange(0.05, 1, 0.1), atol=1e-7)


def test_on_spheres_paths_close():
    mesh = shell(np.linspace(1, 1.6, 4), 2)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    group = LayerGroup.of_vertices(mesh, mesh.boundary_vertices, 0.0)
    pattern = solve_layers(mesh, mesh.vertices / radius[:, None], 0.3, [group])
    layers = layer_surfaces(pattern.edge_phases, pattern.heights)
    lines, numbers = toolpaths(layers, mesh.vertices[:, 2] + 0.11, 0.25)
    assert lines.closed.all() and layers.count == 3
    heights = 0.25 * np.arange(-9, 10) - 0.11
    expected = [np.count_nonzero(np.abs(heights) < radius) for radius in (1, 1.3, 1.6)]
    np.testing.assert_array_equal(np.bincount(numbers), expected)
    height = lines.points[lines.starts, 2]
    reach = np.array([1, 1.3, 1.6])[numbers]
    around = 2 * np.pi * np.sqrt(np.maximum(reach**2 - height**2, 0))
    np.testing.assert_allclose(lines.lengths, around, atol=0.25)


@pytest.mark.parametrize("step", [0, -1, np.nan])
def test_steps_are_positive(step):
    with pytest.raises(SettingError, match="positive"):
        toolpaths(None, np.zeros(3), step)
