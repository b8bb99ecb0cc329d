# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sharp edges and boundaries as lines of the grid, which give way to all other rows."""

import numpy as np
import pytest

from synch_fields.core.fields import DirectionWishes, Row, direction_field, line_of_edges, quad_pattern
from synch_fields.core.fields.constraints.features import feature_edges, feature_row, line_corners, quads_around
from synch_fields.core.geometry import TriangleMesh

from ...direction_wishes import boundary_row
from ...flat_crosses import plane_crosses
from ...meshes import annulus, bent_square, cube, grid_quads, icosphere, split_quads, square, subdivided, torus
from ...sharp_shapes import ANGLE, chamfered_cube, flat_cells, plate, polygon


@pytest.mark.parametrize("cuts", [5, 8])
def test_the_edges_of_a_cube_are_its_features(cuts):
    mesh = cube(cuts)
    edges = feature_edges(mesh, ANGLE, 1 / cuts)
    on_rim = np.isclose(np.abs(mesh.vertices - 0.5), 0.5).sum(axis=1) >= 2
    assert len(edges) == 12 * cuts and on_rim[mesh.edges[edges]].all()
    corners = line_corners(mesh, edges)
    assert len(corners) == 8 and (quads_around(mesh, edges, corners) == 3).all()
    assert len(feature_edges(mesh, np.radians(100), 1 / cuts)) == 0
    marked = feature_edges(mesh, np.radians(100), 1 / cuts, marked=edges)
    np.testing.assert_array_equal(marked, edges)


def test_edges_within_a_face_are_never_sharp():
    bent = TriangleMesh([(0, 0, 0), (1, 0, 0), (1, 1, 1), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)])
    assert len(feature_edges(bent, ANGLE, 0.1)) == 5
    np.testing.assert_array_equal(feature_edges(bent, ANGLE, 0.1, faces=np.array([0, 0])), bent.boundary_edges)
    # Between faces nothing changes: the pairs of triangles of a cube are its squares.
    mesh = cube(5)
    squares = np.unique(np.round(mesh.face_normals), axis=0, return_inverse=True)[1].reshape(-1)
    np.testing.assert_array_equal(feature_edges(mesh, ANGLE, 0.2, faces=squares), feature_edges(mesh, ANGLE, 0.2))


def test_what_a_few_quads_do_not_fit_on_is_no_feature_but_a_boundary_is():
    mesh = cube(6)
    assert len(feature_edges(mesh, ANGLE, 1.1)) == 0
    assert len(feature_edges(square(6), ANGLE, 10.0)) == 24


def test_short_edges_across_the_rim_of_a_plate_are_features():
    # Without them its upper and lower side could be shifted against each other by a quad.
    thin = TriangleMesh(cube(16).vertices * [1, 1, 0.03], cube(16).triangles)
    edges = feature_edges(thin, ANGLE, 0.06)
    upright = np.abs(np.diff(thin.vertices[thin.edges[edges], 2], axis=1)[:, 0]) > 1e-6
    assert upright.sum() == 4 * 16 and len(edges) == 12 * 16
    # On a short plate there is no room for them.
    assert len(feature_edges(thin, ANGLE, 0.3)) == 8 * 16


def test_short_bends_with_free_ends_are_no_features_even_where_shading_marks_them():
    """A sheet with a crease across one half that fades out on both sides, which is one line with two free ends."""
    mesh = square(40)
    x, y, _ = mesh.vertices.T
    slope = 0.7 * np.cos(np.pi / 2 * np.clip((x - 0.5) / 0.35, -1, 1)) ** 2
    height = 0.1 * slope * (1 - np.exp(-np.abs(y - 0.5) / 0.1))
    creased = TriangleMesh(np.column_stack([x, y, height]), mesh.triangles)
    crease = np.flatnonzero((np.abs(creased.vertices[creased.edges][:, :, 1] - 0.5) < 1e-9).all(axis=1))
    sharp = crease[np.abs(creased.angles_between(creased.face_normals))[crease] > ANGLE]
    length, rim = creased.edge_lengths[sharp].sum(), creased.boundary_edges
    assert 10 < len(sharp) < 20
    for sides, is_kept in ((5, False), (7, True)):
        np.testing.assert_array_equal(
            feature_edges(creased, ANGLE, length / sides), np.union1d(rim, sharp) if is_kept else rim
        )
    np.testing.assert_array_equal(feature_edges(creased, ANGLE, length / 5, marked=sharp), rim)


@pytest.mark.parametrize("mesh", [icosphere(3), torus(), cube(12)], ids=["ball", "torus", "cube"])
def test_marks_of_a_mesh_that_is_shown_flat_are_no_features_but_of_facets_that_quads_fit_on(mesh):
    every, length = np.arange(len(mesh.edges)), np.median(mesh.edge_lengths)
    bent = feature_edges(mesh, ANGLE, length / 20)
    np.testing.assert_array_equal(feature_edges(mesh, ANGLE, length, every), feature_edges(mesh, ANGLE, length))
    assert len(feature_edges(mesh, ANGLE, length / 20, every)) == len(mesh.edges) > len(bent)
    heights = mesh.vertices[:, 2] - (mesh.vertices[:, 2].min() + mesh.vertices[:, 2].max()) / 2
    loop = np.flatnonzero(np.abs(heights[mesh.edges]).max(axis=1) < 1e-9)
    assert set(loop) <= set(feature_edges(mesh, ANGLE, length, loop))


def test_on_a_round_body_of_few_polygons_only_right_angles_are_sharp():
    # Twelve sides that bend by about 28 degrees, by 50 at the waist and by 115 at the rims.
    angles = np.arange(12) * np.pi / 6
    heights = np.linspace(-1, 1, 5)
    x, y, z = np.cos(angles), np.sin(angles), np.ones(12)
    radii = 0.534 + 0.466 * np.abs(heights)
    rings = [np.column_stack([radius * x, radius * y, h * z]) for radius, h in zip(radii, heights, strict=True)]
    quads = grid_quads(4, 12, wrap_rows=True)[:, ::-1]
    rim = np.column_stack([np.arange(12), np.roll(np.arange(12), -1)])
    caps = [np.column_stack([rim[:, ::-1], np.full(12, 60)]), np.column_stack([rim + 48, np.full(12, 61)])]
    coarse = TriangleMesh(np.vstack([*rings, (0, 0, -1), (0, 0, 1)]), np.vstack([split_quads(quads), *caps]))
    mesh = subdivided(subdivided(coarse))
    heights = np.abs(mesh.vertices[mesh.edges][:, :, 2])
    features = feature_edges(mesh, ANGLE, 0.2)
    assert len(features) == 24 * 4 and (heights[features] == 1).all()
    with_waist = feature_edges(mesh, ANGLE, 0.05)
    assert len(with_waist) == 36 * 4 and set(np.unique(heights[with_waist])) == {0, 1}


def test_as_many_quads_fit_at_a_corner_as_there_are_right_angles():
    around = {}
    shapes = {
        "triangle": polygon(3),
        "octagon": polygon(8),
        "angle": flat_cells([(0, 0), (1, 0), (0, 1)], 4),
        "chamfers": chamfered_cube(8, 0.15),
    }
    for name, mesh in shapes.items():
        edges = feature_edges(mesh, ANGLE, 1e-3)
        around[name] = sorted(quads_around(mesh, edges, line_corners(mesh, edges)).tolist())
    # A corner of 135 degrees is as near to one as to two, and the even number is taken.
    assert around["triangle"] == [1, 1, 1] and set(around["octagon"]) <= {1, 2}
    assert around["angle"] == [1, 1, 1, 1, 1, 3] and around["chamfers"] == [4] * 24


@pytest.mark.parametrize("build", [plate, lambda: cube(10), lambda: annulus(1, 2, 8, 48), bent_square])
def test_phases_on_features_are_on_lines_and_directions_run_along(build):
    mesh = build()
    spacing = 6 * float(np.median(mesh.edge_lengths))
    edges = feature_edges(mesh, ANGLE, spacing / 2)
    rows = (feature_row(mesh, edges),)
    field = direction_field(mesh, 4, DirectionWishes(rows=rows))
    pattern = quad_pattern(mesh, field, spacing, rows, branching=0.0)
    away = np.setdiff1d(np.unique(mesh.edges[edges]), line_corners(mesh, edges))
    phases = pattern.phases.reshape(-1, 2)[away]
    # Of the two phases of a vertex, one is 1 or -1.
    assert np.abs(phases.imag).min(axis=1).max() < 1e-9
    inner = edges[np.isin(mesh.edges[edges], away).all(axis=1)]
    angles = field.angles[mesh.edges[inner, 0]] - mesh.edge_directions[inner, 0]
    assert np.abs((angles + np.pi / 4) % (np.pi / 2) - np.pi / 4).max() < np.radians(20)
    # An edge on a line has the phase of its line at both ends.
    i, j = mesh.edges[inner].T
    changes = np.abs(pattern.edge_phases.changes[inner]).min(axis=1)
    assert changes.max() < 1e-9 and len(i) == len(j)


@pytest.mark.parametrize("degrees", [0, 90, 30])
def test_features_give_way_to_what_other_rows_ask(degrees):
    mesh = square(14)
    edges = feature_edges(mesh, ANGLE, 0.1)
    asked = boundary_row(mesh, "phase", value=np.radians(degrees))
    rows = (asked, feature_row(mesh, edges))
    field = direction_field(mesh, 4, DirectionWishes(rows=rows))
    alone = direction_field(mesh, 4, DirectionWishes(rows=(asked,)))
    np.testing.assert_array_equal(field.angles, alone.angles)
    with_features = quad_pattern(mesh, field, 0.2, rows)
    without = quad_pattern(mesh, field, 0.2, (asked,))
    np.testing.assert_array_equal(with_features.phases, without.phases)


def test_directions_that_contradict_a_feature_win():
    mesh = square(12)
    edges = feature_edges(mesh, ANGLE, 0.1)
    slanting = Row(line_of_edges(mesh, edges), "angle", np.radians(45))
    field = direction_field(mesh, 4, DirectionWishes(rows=(slanting, feature_row(mesh, edges))))
    rim = np.unique(mesh.edges[edges])
    middle = rim[np.abs(mesh.vertices[rim] - 0.5).min(axis=1) < 0.3]
    x, _ = mesh.tangent_frames
    at = np.angle(field.vectors[middle, 0] + 1j * field.vectors[middle, 1])
    assert np.abs(at % (np.pi / 2) - np.pi / 4).max() < 1e-6 and len(x)


@pytest.mark.parametrize(("degrees", "is_held"), [(0, True), (90, True), (30, True), (45, False)])
def test_no_line_is_held_where_directions_do_not_run_along_it(degrees, is_held):
    mesh = square(14)
    rows = (feature_row(mesh, feature_edges(mesh, ANGLE, 0.1)),)
    field, _ = plane_crosses(mesh, degrees)
    held, free = (quad_pattern(mesh, field, 0.23, asked).phases for asked in (rows, ()))
    assert np.array_equal(held, free) != is_held


def test_a_surface_without_features_asks_for_nothing():
    assert len(feature_edges(torus(1, 0.4, 72, 36), ANGLE, 0.1)) == 0
