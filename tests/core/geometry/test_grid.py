# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Grids: counts, boundaries of boundaries, weights."""

import numpy as np
import pytest

from synch_fields.core.errors import MeshError
from synch_fields.core.geometry.grid import Grid, box_grid

GRIDS = [
    pytest.param(Grid((4, 5)), id="plane"),
    pytest.param(Grid((4, 5), periodic=(True, False)), id="cylinder"),
    pytest.param(Grid((3, 4, 5), spacing=(0.5, 1, 2), origin=(1, 2, 3)), id="box"),
    pytest.param(Grid((3, 4, 5), periodic=(False, True, False)), id="periodic-y"),
    pytest.param(Grid((4, 3, 5), periodic=True), id="periodic"),
]


@pytest.mark.parametrize("grid", GRIDS)
def test_edges_join_neighbours_along_their_axis(grid):
    place = np.array(np.unravel_index(grid.edges, grid.shape))
    for axis in range(grid.dimension):
        step = place[axis, :, 1] - place[axis, :, 0]
        along = grid.edge_axes == axis
        assert (step[~along] == 0).all()
        assert ((step[along] == 1) | (grid.periodic[axis] & (step[along] == 1 - grid.shape[axis]))).all()
    cells = [count - (not wrapped) for count, wrapped in zip(grid.shape, grid.periodic, strict=True)]
    expected = sum(grid.node_count // grid.shape[a] * cells[a] for a in range(grid.dimension))
    assert len(grid.edges) == expected == len(np.unique(grid.edges, axis=0))


@pytest.mark.parametrize("grid", GRIDS)
def test_what_grows_evenly_comes_back_around_faces(grid):
    """The sum of differences around a face is zero, edge by edge: each runs where the face says."""
    values = np.random.default_rng(0).standard_normal(grid.node_count)
    differences = values[grid.edges[:, 1]] - values[grid.edges[:, 0]]
    around = differences[grid.face_edges] * [1, 1, -1, -1]
    np.testing.assert_allclose(around.sum(axis=1), 0, atol=1e-12)
    corners = values[grid.faces]
    np.testing.assert_allclose(around[:, 0], corners[:, 1] - corners[:, 0], atol=1e-12)
    np.testing.assert_allclose(around[:, 2], corners[:, 3] - corners[:, 2], atol=1e-12)


@pytest.mark.parametrize("grid", [g for g in GRIDS if g.values[0].dimension == 3])
def test_what_goes_around_faces_cancels_around_cells(grid):
    values = np.random.default_rng(1).standard_normal(len(grid.edges))
    around = (values[grid.face_edges] * [1, 1, -1, -1]).sum(axis=1)
    np.testing.assert_allclose((around[grid.cell_faces] * grid.outward).sum(axis=1), 0, atol=1e-12)
    cells = np.prod([count - (not wrapped) for count, wrapped in zip(grid.shape, grid.periodic, strict=True)])
    counts = np.bincount(grid.cell_faces.ravel(), minlength=len(grid.faces))
    assert len(grid.cell_faces) == cells and set(counts.tolist()) <= {1, 2}


def test_faces_are_counterclockwise_about_their_normals():
    grid = Grid((3, 4, 5))
    a, b, _, d = np.moveaxis(grid.places[grid.faces], 1, 0)
    normals = np.cross(b - a, d - a)
    for row, plane in zip(normals, grid.face_planes, strict=True):
        assert row[({0, 1, 2} - set(plane.tolist())).pop()] == 1


@pytest.mark.parametrize("grid", GRIDS)
def test_masses_fill_the_box_and_weights_integrate_gradients(grid):
    sizes = grid.spacing * [c - (not p) for c, p in zip(grid.shape, grid.periodic, strict=True)]
    assert grid.masses.sum() == pytest.approx(np.prod(sizes), rel=1e-12)
    for axis in range(grid.dimension):  # of a function that grows by 1 along an axis: the volume
        along = grid.edge_axes == axis
        total = (grid.weights[along] * grid.spacing[axis] ** 2).sum()
        assert total == pytest.approx(np.prod(sizes), rel=1e-12)


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("axis", [0, 1])
def test_a_grid_whose_last_nodes_are_an_obstacle_is_the_smaller_grid(grid, axis):
    solid = np.zeros(grid.shape, bool)
    np.moveaxis(solid, axis, 0)[-1] = True
    masked = Grid(grid.shape, grid.spacing, grid.origin, grid.periodic, solid)
    shape, periodic = list(grid.shape), list(grid.periodic)
    shape[axis], periodic[axis] = shape[axis] - 1, False
    smaller = Grid(shape, grid.spacing, grid.origin, periodic)
    kept = np.flatnonzero(~solid.ravel())
    reached = masked.weights > 0
    np.testing.assert_array_equal(masked.edges[reached], kept[smaller.edges])
    np.testing.assert_allclose(masked.weights[reached], smaller.weights, rtol=1e-12)
    np.testing.assert_allclose(masked.masses[kept], smaller.masses, rtol=1e-12)
    faces = masked.face_signs.any(axis=1)
    np.testing.assert_array_equal(masked.faces[faces], kept[smaller.faces])
    if grid.dimension == 3:
        found = masked.faces[masked.cell_faces]
        np.testing.assert_array_equal(found, kept[smaller.faces[smaller.cell_faces]])


def test_around_an_obstacle_counts_what_lies_in_open_cells():
    """A solid node in the middle takes the eight cells around it."""
    solid = np.zeros((5, 5, 5), bool)
    solid[2, 2, 2] = True
    grid = Grid((5, 5, 5), solid=solid)
    assert grid.open_cells.sum() == len(grid.cell_faces) == 64 - 8
    weights = {tuple(edge): weight for edge, weight in zip(grid.edges.tolist(), grid.weights, strict=True)}
    number = grid.numbers
    assert weights[number[2, 2, 1], number[2, 2, 2]] == weights[number[2, 2, 2], number[3, 2, 2]] == 0
    assert weights[number[2, 2, 0], number[2, 2, 1]] == 1 and weights[number[1, 1, 1], number[1, 1, 2]] == 0.75
    assert weights[number[1, 2, 1], number[1, 2, 2]] == 0.5
    assert grid.masses[number[1, 1, 1]] == 7 / 8 and grid.masses[number[2, 2, 1]] == 0.5


@pytest.mark.parametrize("size", [1e-12, 1.0, 1e12])
def test_boxes_of_any_size_are_covered_by_cubes(size):
    grid = box_grid(np.zeros(3), size * np.array([1.0, 0.5, 0.0]), 9)
    assert grid.shape == (9, 5, 4)  # at least four, also where the box is flat
    np.testing.assert_allclose(grid.places.min(axis=0), size * np.array([0, 0, -1.5 / 8]), atol=1e-14 * size)
    np.testing.assert_allclose(grid.places.max(axis=0), size * np.array([1, 0.5, 1.5 / 8]), rtol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (((1, 5),), "1 nodes along axis X: a grid needs 2"),
        (((4, 2), 1.0, 0.0, True), "2 nodes along axis Y: a grid needs 3"),
        (((4,),), "a grid of 1 axes"),
        (((4, 4), (1, 0)), "positive lengths"),
        (((4, 4), 1.0, 0.0, False, np.zeros((4, 3), bool)), "obstacles of the shape"),
        (((4, 4), 1.0, 0.0, False, np.arange(16).reshape(4, 4) % 2 == 0), "no cell of the grid open"),
    ],
)
def test_grids_that_are_none_are_refused(arguments, message):
    with pytest.raises(MeshError, match=message):
        Grid(*arguments)
