# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes of known patterns: every vertex and face in closed form, however lines and edges coincide."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.core.extract.quads.measure.quality import quality
from synch_fields.core.extract.quads.trace.quad_mesh import quad_mesh
from synch_fields.core.fields import DirectionField, direction_field, given_directions, quad_pattern
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.interpolate import EdgePhases, disclination_centres, dislocation_numbers

from ...direction_wishes import boundary_row
from ...flat_crosses import cone, plane_crosses, plane_edge_phases, plane_waves, random_turns, turned_crosses
from ...meshes import cube, flat_torus, icosphere, renumbered, square, together
from ...topology import edges_of, euler, face_vectors, irregular, is_surface, on_rim, valences

TOLERANCE = 1e-6  # of a cell


def assert_same_points(found, expected, tolerance):
    assert len(found) == len(expected)
    distances, nearest = cKDTree(expected).query(found)
    assert distances.max() < tolerance and len(np.unique(nearest)) == len(expected)


def lattice(degrees, cell, origin, reach=30):
    """Points of a grid in the plane."""
    i, j = (a.ravel() for a in np.mgrid[-reach : reach + 1, -reach : reach + 1])
    a = np.radians(degrees)
    return origin + cell * np.column_stack([np.cos(a) * i - np.sin(a) * j, np.sin(a) * i + np.cos(a) * j, 0 * i])


def lines_on_unit_square(degrees, cell, origin, reach=30):
    """Where the lines of a grid meet the sides of the unit square."""
    found = []
    for turn in (0, 90):
        a = np.radians(degrees + turn)
        normal = np.array([np.cos(a), np.sin(a)])
        for level in normal @ origin[:2] + cell * np.arange(-reach, reach + 1):
            for axis in (0, 1):
                for side in (0.0, 1.0):
                    if abs(normal[1 - axis]) > 1e-9:
                        along = (level - normal[axis] * side) / normal[1 - axis]
                        if 1e-9 < along < 1 - 1e-9:
                            found.append([side, along, 0] if axis == 0 else [along, side, 0])
    return np.array(found)


def inside(points, margin=1e-9):
    return ((points[:, :2] > margin) & (points[:, :2] < 1 - margin)).all(axis=1)


def flattest_corner(hits):
    """How far the corners of the unit square bulge from between the nearest places, over the distance of these."""
    ratios = []
    for corner in CORNERS:
        a, b = (
            np.abs(hits - corner)[np.abs(hits[:, axis] - corner[axis]) < 1e-12, 1 - axis].min(initial=1)
            for axis in (0, 1)
        )
        ratios.append(a * b / (a**2 + b**2))
    return min(ratios)


CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])


@pytest.mark.parametrize("split", ["alternate", "AC"])
@pytest.mark.parametrize("degrees", [0, 17, 45, 61])
@pytest.mark.parametrize("cell", [0.06, 0.155, 0.4])
def test_a_plane_grid_has_its_vertices_where_they_must_be(cell, degrees, split):
    # A grid whose lines come about as near to a corner on one side as on the other: all corners are kept.
    origins = np.random.default_rng(0).random((1000, 3)) * [1, 1, 0]
    origin = next(o for o in origins if flattest_corner(lines_on_unit_square(degrees, cell, o)) > 0.32)
    quads = quad_mesh(plane_edge_phases(square(7, split=split), degrees, 2 * cell, origin))
    crossings = lattice(degrees, cell, origin)
    crossings = crossings[inside(crossings)]
    expected = np.vstack([crossings, lines_on_unit_square(degrees, cell, origin), CORNERS])
    assert_same_points(quads.vertices, expected, TOLERANCE * cell)
    assert is_surface(quads) and euler(quads) == 1
    areas = face_vectors(quads)
    assert (areas[:, 2] > 0).all() and areas.sum(axis=0) == pytest.approx([0, 0, 1], abs=1e-9)
    # Cells that the boundary does not cut are squares.
    rim = on_rim(quads)
    whole = np.bincount(quads.corner_faces, rim[quads.corner_vertices]) == 0
    np.testing.assert_allclose(areas[whole, 2], cell**2, rtol=1e-6)
    assert (quads.sizes[whole] == 4).all() and (valences(quads)[~rim] == 4).all()
    if degrees == 0:
        assert (quads.sizes == 4).all()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("edges", [1, 2, 4])
@pytest.mark.parametrize("columns", [8, 12])
def test_lines_through_vertices_and_along_edges_and_sides_give_a_clean_grid(columns, edges, seed):
    """A cell as long as some edges of the mesh, whose vertices are crossings and whose sides are lines."""
    cells = columns // edges
    quads = quad_mesh(plane_edge_phases(square(columns), 0, 2 / cells, seed=seed))
    i, j = (a.ravel() / cells for a in np.mgrid[: cells + 1, : cells + 1])
    assert_same_points(quads.vertices, np.column_stack([i, j, 0 * i]), TOLERANCE / cells)
    assert (quads.sizes == 4).all() and is_surface(quads) and euler(quads) == 1
    np.testing.assert_allclose(face_vectors(quads)[:, 2], 1 / cells**2, rtol=1e-5)


@pytest.mark.parametrize("finer", [2, 3, 5])
def test_lines_along_edges_and_between_them(finer):
    cells = 6 * finer
    quads = quad_mesh(plane_edge_phases(square(6), 0, 2 / cells))
    assert len(quads.sizes) == cells**2 and (quads.sizes == 4).all() and euler(quads) == 1
    assert np.abs(quads.vertices * cells - np.rint(quads.vertices * cells)).max() < TOLERANCE


@pytest.mark.parametrize(
    ("degrees", "spacing"),
    [(45, 0.5 * np.sqrt(0.5)), (45, 0.25 * np.sqrt(2)), (np.degrees(np.arctan(0.5)), 0.5 / np.sqrt(5))],
)
def test_slanting_lines_through_vertices(degrees, spacing):
    """Inside, the grid is clean; crossings that lie on the boundary are moved off it."""
    quads = quad_mesh(plane_edge_phases(square(8, split="AC"), degrees, spacing))
    crossings = lattice(degrees, spacing / 2, np.zeros(3))
    rim = on_rim(quads)
    assert_same_points(quads.vertices[~rim], crossings[inside(crossings, 1e-6)], TOLERANCE * spacing)
    assert is_surface(quads) and euler(quads) == 1
    of_vertices, of_faces = irregular(quads)
    assert len(of_vertices) == len(of_faces) == 0
    areas = face_vectors(quads)[:, 2]
    assert areas.min() > 0.2 * (spacing / 2) ** 2 and areas.sum() == pytest.approx(1)


@pytest.mark.parametrize("cells", [(0.1, 0.08), (0.09, 0.12)])
def test_two_spacings_give_rectangles(cells):
    mesh = square(9)
    field, angles = plane_crosses(mesh)
    spacing = 2 * np.array([cells])
    # Phases that grow along x have the first spacing, those along y the second.
    along_x = np.abs(np.cos(angles[:, None] + np.pi / 2 * np.array([1, 2]))) > 0.5
    waves = plane_waves(angles, 1.0, mesh.vertices - [0.05, 0.02, 0]) / np.where(along_x, *spacing[0])
    edge_phases = TargetOneForm.of(mesh, field, spacing).edge_phases(np.exp(1j * waves).ravel())
    quads = quad_mesh(edge_phases)
    x, y = (
        np.append(np.arange(offset % cell, 1, cell), [0, 1]) for offset, cell in zip((0.05, 0.02), cells, strict=True)
    )
    expected = np.stack(np.meshgrid(x, y, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    assert_same_points(quads.vertices, expected, TOLERANCE)
    assert (quads.sizes == 4).all() and euler(quads) == 1


# Around disclinations


def dislocated(quads):
    return sorted(irregular(quads)[0].tolist()), sorted(irregular(quads)[1].tolist())


@pytest.mark.parametrize("side", [None, 0, 1, 2])
@pytest.mark.parametrize("seed", range(8))
def test_three_quadrants_meet_at_a_vertex_of_three_edges(seed, side):
    """Also where the disclination is in the triangle beside the tip of the cone."""
    edge_phases = cone(3, 4.4, side=side, seed=seed)
    quads = quad_mesh(edge_phases)
    assert dislocated(quads) == ([1], [])
    assert is_surface(quads) and euler(quads) == 1 and (face_vectors(quads)[:, 2] > 0).all()


def quarters_around(edge_phases):
    """How often the phases of the disclination's triangle turn by a quarter around its centre."""
    _, torn = dislocation_numbers(edge_phases, edge_phases.mesh.triangles)
    values, turns = edge_phases.around(edge_phases.mesh.triangles[torn])
    ((away),) = (values - disclination_centres(values, turns)[:, None]) @ [1, 1j]
    return round(np.angle(away[1:] / away[:-1]).sum() / (np.pi / 2))


def test_five_quadrants_meet_at_a_vertex_of_five_edges():
    around = [phases for seed in range(30) if quarters_around(phases := cone(5, 4.4, seed=seed)) == 5]
    assert len(around) > 10
    for edge_phases in around:
        quads = quad_mesh(edge_phases)
        assert dislocated(quads) == ([-1], [])
        assert is_surface(quads) and euler(quads) == 1 and (face_vectors(quads)[:, 2] > 0).all()


@pytest.mark.parametrize("side", [None, 0, 1, 2])
@pytest.mark.parametrize("quadrants", [3, 5])
def test_vertices_and_faces_around_a_disclination_lack_what_it_is(quadrants, side):
    """However the lines nearest to it are joined, in sum they turn by its index."""
    for seed in range(10):
        quads = quad_mesh(cone(quadrants, 4.4, side=side, seed=seed))
        assert is_surface(quads) and euler(quads) == 1
        of_vertices, of_faces = irregular(quads)
        assert of_vertices.sum() + of_faces.sum() == 4 - quadrants
        assert len(of_vertices) + len(of_faces) <= 3


@pytest.mark.parametrize("side", [None, 0, 1, 2])
def test_five_quadrants_always_meet_at_one_vertex(side):
    found = [dislocated(quad_mesh(cone(5, 5.4, 8, side, seed))) for seed in range(8)]
    assert found == [([-1], [])] * 8


@pytest.mark.parametrize(("cuts", "cells"), [(5, 3), (6, 4), (9, 7)])
def test_a_cube_has_its_grid_and_eight_vertices_of_three_edges(cuts, cells):
    mesh = cube(cuts)
    pattern = quad_pattern(mesh, direction_field(mesh, 4), 2 / cells)
    quads = quad_mesh(pattern.edge_phases)
    assert (quads.sizes == 4).all() and is_surface(quads)
    degrees = valences(quads)
    assert np.bincount(degrees).tolist() == [0, 0, 0, 8, len(degrees) - 8]
    assert len(quads.sizes) == pytest.approx(6 * cells**2, rel=0.15) and euler(quads) == 2
    centre = np.full(3, 0.5)
    middles = np.add.reduceat(quads.vertices[quads.corner_vertices], quads.starts) / 4
    assert (np.einsum("ij,ij->i", face_vectors(quads), middles - centre) > 0).all()
    near = cKDTree(mesh.vertices[(np.abs(mesh.vertices - 0.5) == 0.5).all(axis=1)]).query(quads.vertices[degrees == 3])
    assert near[0].max() < 2 / cuts and len(np.unique(near[1])) == 8


def test_a_flat_torus_has_nothing_but_regular_vertices():
    mesh, axis = flat_torus(1.0, 0.6, columns=24, rows=16)
    field = turned_crosses(DirectionField(mesh, 4, axis), random_turns(mesh))
    quads = quad_mesh(quad_pattern(mesh, field, 0.2).edge_phases)
    assert len(quads.sizes) == len(quads.vertices) == 10 * 6
    assert (quads.sizes == 4).all() and (valences(quads) == 4).all()
    assert is_surface(quads) and euler(quads) == 0


def test_where_two_quads_go_around_a_tube_one_of_two_edges_between_the_same_vertices_is_divided():
    mesh, axis = flat_torus(1.0, 0.2, columns=24, rows=6)
    quads = quad_mesh(
        quad_pattern(mesh, turned_crosses(DirectionField(mesh, 4, axis), random_turns(mesh)), 0.2).edge_phases
    )
    assert is_surface(quads) and not quads.is_unsound.any() and euler(quads) == 0
    assert sorted(valences(quads)) == 10 * [2] + 20 * [4] and len(quads.sizes) == 20 and quads.sizes.sum() == 80 + 20


# The same mesh by other names


def test_numbering_and_representatives_change_nothing():
    mesh = icosphere(3)
    field = direction_field(mesh, 4)
    pattern = quad_pattern(mesh, field, 0.5)
    quads = quad_mesh(pattern.edge_phases)
    other, vertex, _ = renumbered(mesh)
    old = np.argsort(vertex)
    changes, matched = pattern.edge_phases.between(*old[other.edges].T)
    again = quad_mesh(EdgePhases(other, pattern.edge_phases.arguments[old], changes, matched))
    assert_same_points(again.vertices, quads.vertices, 1e-9)
    np.testing.assert_array_equal(np.sort(again.sizes), np.sort(quads.sizes))
    nearest = cKDTree(quads.vertices).query(again.vertices)[1]
    pairs = {frozenset(p) for p in edges_of(quads)[0].tolist()}
    assert {frozenset(p) for p in nearest[edges_of(again)[0]].tolist()} == pairs


def test_vertices_know_their_place_on_the_surface():
    mesh = together(icosphere(2), square(5), loose=1)
    quads = quad_mesh(quad_pattern(mesh, direction_field_of(mesh), 0.5).edge_phases)
    assert quads.weights.min() >= 0 and quads.weights.sum(axis=1) == pytest.approx(np.ones(len(quads.weights)))
    placed = np.einsum("nk,nkx->nx", quads.weights, mesh.vertices[mesh.triangles[quads.triangles]])
    np.testing.assert_allclose(placed, quads.vertices, atol=1e-12)
    assert euler(quads) == 3 and is_surface(quads)


def direction_field_of(mesh):
    parts = direction_field(TriangleMesh(mesh.vertices[:-1], mesh.triangles), 4).vectors
    return given_directions(mesh, 4, np.vstack([parts, [1, 0, 0]]))


# A boundary with phases


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("spacing", [0.21, 0.3, 0.47])
def test_a_grid_line_on_the_whole_boundary_leaves_no_slivers(spacing, seed):
    mesh = square(10)
    field, _ = plane_crosses(mesh, seed=seed)
    quads = quad_mesh(quad_pattern(mesh, field, spacing, [boundary_row(mesh, "phase")]).edge_phases)
    cells = 2 * round(1 / spacing)
    i, j = (a.ravel() / cells for a in np.mgrid[: cells + 1, : cells + 1])
    assert_same_points(quads.vertices, np.column_stack([i, j, 0 * i]), 1e-3 / cells)
    assert (quads.sizes == 4).all() and len(quads.sizes) == cells**2 and is_surface(quads)


@pytest.mark.parametrize("value", [np.pi / 2, 0.8])
def test_a_grid_beside_the_boundary_leaves_it_as_it_is(value):
    """Half a cell, or 0.8 / pi of one, lies between the first line and the boundary."""
    mesh = square(10)
    field, _ = plane_crosses(mesh)
    spacing = 1 / (3 - value / np.pi)
    quads = quad_mesh(quad_pattern(mesh, field, spacing, [boundary_row(mesh, "phase", value=value)]).edge_phases)
    lines = (np.arange(1, 6) * np.pi - value) * spacing / (2 * np.pi)
    lines = np.concatenate([[0], lines[(lines > 0) & (lines < 1)], [1]])
    expected = np.stack(np.meshgrid(lines, lines, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    assert_same_points(quads.vertices, expected, 1e-6)
    assert (quads.sizes == 4).all() and is_surface(quads)


@pytest.mark.parametrize("near", [0.05, 0.03, 0.015, 0.005])
def test_right_angles_of_the_boundary_are_kept(near):
    """However near to a corner a line comes on one of its sides, and 0.05 on the other."""
    quads = quad_mesh(plane_edge_phases(square(6), 0, 0.2, [near, 0.05, 0]))
    for corner in CORNERS:
        assert np.linalg.norm(quads.vertices - corner, axis=1).min() < 1e-9
    assert face_vectors(quads)[:, 2].sum() == pytest.approx(1)


def test_figures_of_a_perfect_grid_are_perfect():
    figures = quality(quad_mesh(plane_edge_phases(square(6), 0, 0.25)))
    assert figures["faces"] == 64 and figures["vertices"] == 81 and figures["edges"] == 144
    assert figures["quad_share"] == 1 and figures["irregular_vertices"] == 0 and figures["euler_characteristic"] == 1
    assert figures["angle_deviation"] < 1e-3 and figures["length_spread"] < 1e-5 and not figures["closed"]
    assert figures["edge_length"] == pytest.approx(0.125, rel=1e-5)


@pytest.mark.parametrize("size", [1.0, 1e-6])
def test_a_small_component_keeps_the_edges_of_its_own_size(size):
    large = square(12)
    mesh = together(large, TriangleMesh(size * large.vertices, large.triangles))
    values = np.tile(8 * np.pi * large.vertices[:, :2], (2, 1))
    i, j = mesh.edges.T
    quads = quad_mesh(EdgePhases(mesh, values, values[j] - values[i], np.zeros(len(mesh.edges), int)))
    assert len(quads.sizes) == 2 * 64 and (quads.sizes == 4).all()
