# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers as triangles: complete, manifold, in order, and exactly on the surfaces that are to carry one."""

import numpy as np
import pytest

from synch_fields.core.extract.layers.surfaces import layer_surfaces
from synch_fields.core.fields.guidance.solid_distance import solid_distance
from synch_fields.core.fields.guidance.solids import axis_directions
from synch_fields.core.fields.layers import solve_layers
from synch_fields.core.geometry.tet_mesh import TetMesh, positive

from ...layered_solids import (
    bent_bar,
    block,
    faces_carried,
    gradient_directions,
    group_of,
    is_manifold_at_vertices,
    lies_on_boundary,
    normals,
    on_faces,
    phases_of,
    random_phases,
    rims,
    shell,
    surfaces_of,
)
from ...meshes import icosphere

NOISES = [0.3, 2, 12]


# Planes


@pytest.mark.parametrize("offset", [0.0, 2.0])
@pytest.mark.parametrize("spacing", [0.23, 0.07])
def test_constant_directions_give_whole_planes_at_exact_distances(spacing, offset):
    mesh = block((5, 4, 6), (1, 1.2, 1.1), jitter=0.2)
    pattern = solve_layers(
        mesh, axis_directions(mesh, (0, 0, 1)), spacing, [group_of(mesh, mesh.vertices[:, 2] == 0, -offset)]
    )
    layers = surfaces_of(pattern)
    expected = np.arange(offset / (2 * np.pi) * spacing, 1.1, spacing)
    assert layers.count == len(expected)
    heights = layers.vertices[layers.triangles][:, :, 2]
    np.testing.assert_allclose(heights, np.tile(expected[layers.layers, None], 3), atol=1e-6 * spacing)
    np.testing.assert_allclose(layers.areas, 1.2, rtol=1e-6)
    assert (normals(layers)[:, 2] > 0).all() and (np.diff(layers.layers) >= 0).all()
    assert lies_on_boundary(mesh, layers, rims(layers)).all()


def test_tilted_planes_are_cut_off_by_the_solid():
    """The area of a level is the derivative of the volume below it: areas add up to the volume over the spacing."""
    mesh = block((6, 6, 6), jitter=0.2)
    axis, spacing = np.array([3, 2, 6]) / 7, 0.04
    layers = surfaces_of(solve_layers(mesh, axis_directions(mesh, axis), spacing))
    places = layers.vertices[layers.triangles] @ axis
    assert np.ptp(places, axis=1).max() < 1e-6
    steps = np.diff([places[layers.layers == k].mean() for k in range(layers.count)])
    np.testing.assert_allclose(steps, spacing, atol=1e-6 * spacing)
    assert layers.areas.sum() * spacing == pytest.approx(1, rel=2e-3)
    assert ((normals(layers) @ axis) > 0).all()


def towers(gap=0.0):
    """A floor up to 0.4 with two towers on it, up to 1 and to 0.75; or, apart by a gap, the towers alone."""
    mesh = block((9, 3, 20), (1, 0.4, 1))
    x, _, z = mesh.vertices[mesh.tets].mean(axis=1).T
    kept = (x < 1 / 3) | ((x > 2 / 3) & (z < 0.75)) | ((z < 0.4) & (gap == 0))
    moved = mesh.vertices + np.outer(mesh.vertices[:, 0] > 0.5, [0, 0, gap])
    return TetMesh(moved, mesh.tets[kept])


def test_levels_have_one_number_where_pieces_have_one_each():
    mesh = towers()
    floor = group_of(mesh, mesh.vertices[:, 2] == 0, -np.pi / 2)  # a quarter of the spacing below a layer
    pattern = solve_layers(mesh, axis_directions(mesh, (0, 0, 1)), 0.1, [floor])
    pieces = layer_surfaces(pattern.edge_phases, pattern.heights)
    levels = layer_surfaces(pattern.edge_phases, pattern.heights, by_level=True)
    # At 0.025 to 0.325 one piece each, then two, and from 0.75 on one.
    assert pieces.count == 4 + 2 * 4 + 2 and levels.count == 10
    assert pieces.level_count == levels.level_count == 10
    heights = levels.vertices[levels.triangles][:, :, 2]
    np.testing.assert_allclose(heights, np.tile(0.1 * levels.layers[:, None] + 0.025, 3), atol=1e-5)
    assert (np.diff(levels.layers) >= 0).all()
    np.testing.assert_allclose(levels.areas.sum(), pieces.areas.sum())
    assert levels.areas[5] == pytest.approx(2 / 3 * 0.4) and levels.areas[8] == pytest.approx(0.4 / 3)


def test_levels_of_separate_bodies_count_from_the_lowest_layer_of_each():
    """Each begins where its own phase does: the second tower stands 0.03 higher."""
    mesh = towers(0.03)
    floors = [group_of(mesh, mesh.vertices[:, 2] == height, 0.0) for height in (0, 0.03)]
    pattern = solve_layers(mesh, axis_directions(mesh, (0, 0, 1)), 0.1, floors)
    levels = layer_surfaces(pattern.edge_phases, pattern.heights, by_level=True)
    points = levels.vertices[levels.triangles].mean(axis=1)
    expected = 0.1 * levels.layers + np.where(points[:, 0] > 0.5, 0.03, 0)
    np.testing.assert_allclose(points[:, 2], expected, atol=1e-5)
    assert levels.count == 11


@pytest.mark.parametrize("ratio", [6, 9])
def test_levels_go_on_where_layers_end(ratio):
    """Nine layers along the outer half of a bar and six along the inner one: the levels are as many as either side."""
    mesh, around = bent_bar((8, 27, 4), 1, 2, np.pi / 2, 0.2)
    x, y, _ = mesh.vertices.T
    spacing = np.hypot(x, y) * np.pi / 2 / np.where(np.hypot(x, y) < 1.49, ratio, 15 - ratio)
    pattern = solve_layers(mesh, around, spacing, [group_of(mesh, end < 1e-9, 0.0) for end in (x, y)])
    levels = layer_surfaces(pattern.edge_phases, pattern.heights, by_level=True)
    assert pattern.face_numbers.any() and 6 < levels.count <= 10
    middles = levels.vertices[levels.triangles].mean(axis=1)
    turns = np.arctan2(middles[:, 1], middles[:, 0])
    means = np.bincount(levels.layers, turns) / np.bincount(levels.layers)
    assert (np.diff(means) > 0).all()


def test_layers_of_a_spherical_shell_are_concentric_and_evenly_spaced():
    """Between an inner and an outer sphere on which layers lie: successive distances within 2 % of the spacing."""
    mesh, spacing = shell(np.linspace(1, 1.8, 13), 3, jitter=0.003), 0.2
    radius = np.linalg.norm(mesh.vertices, axis=1)
    groups = [group_of(mesh, mesh.boundary_vertices & side, 0.0) for side in (radius < 1.01, radius > 1.79)]
    layers = surfaces_of(solve_layers(mesh, mesh.vertices / radius[:, None], spacing, groups))
    assert layers.count == 5
    shares = np.linalg.norm(normals(layers), axis=1)
    places = np.linalg.norm(layers.vertices, axis=1)[layers.triangles].mean(axis=1)
    means = np.bincount(layers.layers, shares * places) / np.bincount(layers.layers, shares)
    np.testing.assert_allclose(np.diff(means), spacing, rtol=0.02)
    off = places - means[layers.layers]
    assert np.abs(off).max() < 0.02 * spacing


def test_places_in_between_are_the_weights_of_the_corners():
    mesh = block((4, 4, 4), jitter=0.2)
    layers = surfaces_of(solve_layers(mesh, axis_directions(mesh, (1, 1, 2)), 0.21))
    places = np.einsum("pk,pkx->px", layers.weights, mesh.vertices[layers.corners])
    np.testing.assert_allclose(places, layers.vertices, atol=1e-12)


# Exactly on surfaces


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_vertices_on_a_level_leave_neither_slivers_nor_holes(jitter, direction):
    """Every plane of the grid is a level, the two ends of the block too."""
    mesh = block((4, 4, 4), jitter=0)
    vertices = mesh.vertices + jitter / 4 * np.random.default_rng(0).uniform(-1, 1, mesh.vertices.shape) * [1, 1, 0]
    mesh = TetMesh(vertices, mesh.tets)
    random = np.random.default_rng(1)
    angles = direction * 8 * np.pi * mesh.vertices[:, 2] + 1e-10 * random.standard_normal(mesh.vertex_count)
    layers = layer_surfaces(phases_of(mesh, angles), angles)
    assert layers.count == 5 and len(layers.triangles) == 5 * 32
    assert layers.weights.max(axis=1).min() == 1 and is_manifold_at_vertices(layers)
    assert np.ptp(layers.vertices[layers.triangles][:, :, 2], axis=1).max() < 1e-12
    flat = np.unique(
        np.sort(layers.corners[layers.triangles, layers.weights[layers.triangles].argmax(axis=2)], axis=1), axis=0
    )
    assert len(flat) == 5 * 32
    assert (direction * normals(layers)[:, 2] > 0).all()
    # From the bottom of the growth upwards.
    levels = layers.vertices[layers.triangles][:, 0, 2]
    np.testing.assert_allclose(levels, layers.layers / 4 if direction > 0 else 1 - layers.layers / 4)


def test_between_concentric_spheres_every_layer_is_a_closed_sphere():
    count = 4
    mesh = shell(np.linspace(1, 1.8, 6), 3, jitter=0.005)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    inner, outer = mesh.boundary_vertices & (radius < 1.01), mesh.boundary_vertices & (radius > 1.79)
    groups = [group_of(mesh, chosen, 0.0) for chosen in (inner, outer)]
    spacing = 0.8 / count
    layers = surfaces_of(solve_layers(mesh, mesh.vertices / radius[:, None], spacing, groups))
    assert layers.count == count + 1 and len(rims(layers)) == 0 and is_manifold_at_vertices(layers)
    for group in groups:
        assert faces_carried(layers, group.triangles) == [1] * len(group.triangles)
    assert (layers.layers == 0).sum() == len(groups[0].triangles)
    assert (layers.layers == count).sum() == len(groups[1].triangles)
    found = [
        np.linalg.norm(layers.vertices[layers.triangles[layers.layers == k]], axis=2).mean() for k in range(count + 1)
    ]
    np.testing.assert_allclose(np.diff(found), spacing, rtol=0.02)
    centres = layers.vertices[layers.triangles].mean(axis=1)
    assert (np.einsum("tx,tx->t", normals(layers), centres) > 0).all()
    for k in range(count + 1):
        piece = layers.triangles[layers.layers == k]
        assert len(np.unique(piece)) - len(piece) // 2 == 2


@pytest.mark.parametrize("sign", [1, -1])
def test_tetrahedra_with_all_corners_on_the_surface_do_not_hide_it(sign):
    """A ball of tetrahedra around its centre, and a tent on one of their faces."""
    ball = icosphere(1)
    peak, centre = 0, ball.vertex_count + 1
    tets = np.column_stack([ball.triangles + 1, np.full(ball.triangle_count, centre)])
    vertices = np.vstack([1.4 * ball.vertices[ball.triangles[0]].mean(axis=0), ball.vertices, np.zeros(3)])
    tets = np.vstack([tets, [*(ball.triangles[0] + 1), peak]])
    mesh = TetMesh(vertices, positive(vertices, tets))
    group = group_of(mesh, mesh.boundary_vertices, 0.0)
    assert len(group.triangles) == len(mesh.boundary_triangles) == ball.triangle_count + 2
    inwards = gradient_directions(mesh, solid_distance(mesh, mesh.boundary_vertices))
    pattern = solve_layers(mesh, sign * inwards, 1.7, [group])
    layers = surfaces_of(pattern)
    assert layers.count == 1 and len(layers.triangles) == len(group.triangles)
    assert faces_carried(layers, group.triangles) == [1] * len(group.triangles)
    assert len(rims(layers)) == 0


def test_a_layer_goes_on_where_its_surface_ends():
    """Half the floor is a layer; where it ends, the layer goes on inside the solid as the same piece."""
    mesh = block((8, 4, 8), (2, 1, 1))
    x, _, z = mesh.vertices.T
    angles = 2 * np.pi * np.where(x <= 1, z, z - 0.4 * (x - 1)) / 0.5
    layers = layer_surfaces(phases_of(mesh, angles), angles)
    floor = mesh.boundary_triangles[(mesh.vertices[mesh.boundary_triangles][:, :, 2] == 0).all(axis=1)]
    left = floor[(mesh.vertices[floor][:, :, 0] <= 1).all(axis=1)]
    assert faces_carried(layers, left) == [1] * len(left)
    lowest = layers.triangles[layers.layers == 0]
    expected = 1 + np.hypot(1, 0.4)
    assert layers.areas[0] == pytest.approx(expected, rel=0.01) and layers.count == 3
    assert np.ptp(layers.vertices[lowest][:, :, 0]) == 2


@pytest.mark.parametrize("sign", [1, -1])
def test_a_level_that_is_only_touched_is_no_layer(sign):
    mesh = block((3, 3, 4))
    z = mesh.vertices[:, 2]
    assert layer_surfaces(phases_of(mesh, sign * np.abs(z - 0.5)), z).count == 0
    assert layer_surfaces(phases_of(mesh, sign * (z - 0.5)), z).count == 1


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("noise", NOISES)
def test_a_surface_is_whole_whatever_is_beside_it(noise, seed):
    mesh = block((4, 4, 3), jitter=0.2)
    z = mesh.vertices[:, 2]
    groups = [group_of(mesh, chosen, 0.0) for chosen in (z == 0, z == 1)]
    random = np.random.default_rng(seed)
    # Many more vertices on levels than chance has it.
    resting = np.flatnonzero((z == 0) | (z == 1) | (random.random(len(z)) < 0.3))
    edge_phases = random_phases(mesh, noise, seed, resting)
    for group in groups:
        edge = mesh.edges_between(*group.sides.T)
        edge_phases.changes[edge] = 0
    layers = layer_surfaces(edge_phases, z)
    for group in groups:
        assert faces_carried(layers, group.triangles) == [1] * len(group.triangles)
        assert len(np.unique(layers.layers[on_faces(layers, group.vertices)])) == 1
    rims(layers)
    assert is_manifold_at_vertices(layers)
    assert (np.linalg.norm(normals(layers), axis=1) > 0).all()


def test_half_layers_stand_between_the_layers_that_they_part():
    """Eight layers at the inside of a bent bar and eleven at the outside: three end within."""
    mesh, around = bent_bar((8, 33, 4), 1, 2, np.pi / 2, 0.2)
    x, y, _ = mesh.vertices.T
    radius = np.hypot(x, y)
    spacing = radius * np.pi / 2 / np.where(radius < 1.49, 8, 11)
    groups = [group_of(mesh, end < 1e-9, 0.0) for end in (x, y)]
    pattern = solve_layers(mesh, around, spacing, groups)
    layers = surfaces_of(pattern)
    assert layers.count == 12
    turn = np.arctan2(layers.vertices[:, 1], layers.vertices[:, 0])[layers.triangles].mean(axis=1)
    middles = [turn[layers.layers == k].mean() for k in range(layers.count)]
    assert (np.diff(middles) > 0).all()
    reach = np.hypot(layers.vertices[:, 0], layers.vertices[:, 1])[layers.triangles].min(axis=1)
    halves = [reach[layers.layers == k].min() > 1.2 for k in range(layers.count)]
    assert sum(halves) == 3 and not (halves[0] or halves[-1])
    for end in (0, -1):
        carried = faces_carried(layers, groups[end].triangles)
        assert carried == [1] * len(carried)
    assert (layers.areas[halves] < 0.7 * np.median(layers.areas)).all()
