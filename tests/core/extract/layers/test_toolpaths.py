# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths on layers: straight on planes, circles on spheres, and on the layer that they say."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.extract.layers.surfaces import layer_surfaces
from synch_fields.core.extract.layers.toolpaths import rim_distances, toolpaths
from synch_fields.core.fields.guidance.solids import axis_directions
from synch_fields.core.fields.layers import solve_layers

from ...layered_solids import block, group_of, shell


def test_on_planes_paths_are_straight_and_evenly_spaced():
    mesh = block((5, 5, 5), jitter=0.2)
    floor = group_of(mesh, mesh.vertices[:, 2] == 0, 0.0)
    pattern = solve_layers(mesh, axis_directions(mesh, (0, 0, 1)), 0.23, [floor])
    layers = layer_surfaces(pattern.edge_phases, pattern.heights)
    lines, numbers = toolpaths(layers.mesh, layers.layers, layers.vertices[:, 0] - 0.05, 0.1)
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
    group = group_of(mesh, mesh.boundary_vertices, 0.0)
    pattern = solve_layers(mesh, mesh.vertices / radius[:, None], 0.3, [group])
    layers = layer_surfaces(pattern.edge_phases, pattern.heights)
    lines, numbers = toolpaths(layers.mesh, layers.layers, layers.vertices[:, 2] + 0.11, 0.25)
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
        toolpaths(None, None, np.zeros(3), step)


def test_steps_that_make_too_many_points_are_refused_with_one_that_does(monkeypatch):
    mesh = block((5, 5, 5), jitter=0.2)
    floor = group_of(mesh, mesh.vertices[:, 2] == 0, 0.0)
    pattern = solve_layers(mesh, axis_directions(mesh, (0, 0, 1)), 0.23, [floor])
    layers = layer_surfaces(pattern.edge_phases, pattern.heights)
    most = len(toolpaths(layers.mesh, layers.layers, layers.vertices[:, 0], 0.02)[0].triangles)
    monkeypatch.setattr("synch_fields.core.extract.layers.toolpaths.MOST_POINTS", most)
    assert len(toolpaths(layers.mesh, layers.layers, layers.vertices[:, 0], 0.03)[0].triangles) < most
    with pytest.raises(SettingError, match=r"give a step of .* or more") as caught:
        toolpaths(layers.mesh, layers.layers, layers.vertices[:, 0], 1e-7)
    remedy = float(str(caught.value).split("step of ")[1].split()[0])
    assert 0.8 * most < len(toolpaths(layers.mesh, layers.layers, layers.vertices[:, 0], remedy)[0].triangles) <= most


def test_contours_run_along_the_rim_one_step_after_the_other():
    """On square layers: squares inside each other, half a step from the rim and then a step apart."""
    mesh = block((6, 6, 4))
    floor = group_of(mesh, mesh.vertices[:, 2] == 0, 0.0)
    pattern = solve_layers(mesh, axis_directions(mesh, (0, 0, 1)), 0.3, [floor])
    layers = layer_surfaces(pattern.edge_phases, pattern.heights)
    step = 0.12
    lines, numbers = toolpaths(layers.mesh, layers.layers, rim_distances(layers.mesh) - step / 2, step)
    np.testing.assert_array_equal(np.bincount(numbers), [4] * 4)
    assert lines.closed.all()
    inward = 0.5 - np.abs(lines.points[:, :2] - 0.5).max(axis=1)
    away = inward / step - 0.5
    means = np.bincount(lines.numbers, away) / lines.sizes
    assert np.abs(means - np.rint(means))[means < 2.5].max() < 0.1
    np.testing.assert_array_equal(np.sort(np.rint(means)), np.repeat(np.arange(4), 4))
    # Fronts from two sides meet inside triangles, whose edges are as long as a step and a half.
    off = np.abs(away - np.rint(means)[lines.numbers])
    assert off.mean() < 0.05 and off.max() < 0.5


def test_on_layers_without_a_rim_contours_start_at_the_lowest_place():
    mesh = shell(np.linspace(1, 1.6, 4), 2)
    group = group_of(mesh, mesh.boundary_vertices, 0.0)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    pattern = solve_layers(mesh, mesh.vertices / radius[:, None], 0.3, [group])
    layers = layer_surfaces(pattern.edge_phases, pattern.heights)
    distances = rim_distances(layers.mesh)
    radius = np.linalg.norm(layers.vertices, axis=1)
    angles = np.arccos(np.clip(-layers.vertices[:, 2] / radius, -1, 1))
    assert np.isfinite(distances).all() and (distances == 0).sum() == layers.count == 3
    np.testing.assert_allclose(distances, radius * angles, atol=0.35)
