# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Boundaries, sharp edges and corners of the surface stay edges and vertices of its quad mesh."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.bench.meshes import read_obj
from synch_fields.core.extract.quads.features import feature_lines
from synch_fields.core.extract.quads.features.chains import CORNER_REACH, follow_features
from synch_fields.core.extract.quads.features.feature_lines import FeatureLines
from synch_fields.core.extract.quads.measure.quality import corner_angles
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh, quad_mesh
from synch_fields.core.fields import direction_field, quad_pattern
from synch_fields.core.fields.constraints.features import feature_edges, line_corners
from synch_fields.core.geometry import TriangleMesh

from ...meshes import SHARED, cube, cylinder, double_torus, grid_quads
from ...sharp_shapes import ANGLE, chamfered_cube, distances_from_edges, flat_cells, kept_quads, plate, polygon, samples
from ...topology import euler, is_surface

# Of a quad's side.
ON_CHAIN = 0.02
# Shape, spacing, and curvature of its bent lines.
SHAPES = [
    pytest.param(plate, 0.08, 1 / 0.22, id="plate"),
    pytest.param(lambda: cylinder(1.0, 2.0, 96, 40), 0.2, 1.0, id="open-cylinder"),
    pytest.param(chamfered_cube, 0.16, 0.0, id="chamfered-cube"),
    pytest.param(lambda: chamfered_cube(16, 0.3 * 0.1 / np.sqrt(2)), 0.2, 0.0, id="chamfer-0.3"),
    pytest.param(lambda: cube(20), 0.163, 0.0, id="cube"),
    pytest.param(lambda: double_torus(3), 0.81, 0.0, id="double-torus"),
    pytest.param(
        lambda: flat_cells([(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)], 10),
        0.39,
        0.0,
        id="frame",
    ),
    pytest.param(lambda: polygon(5), 0.26, 0.0, id="5-gon"),
]


@pytest.mark.parametrize(("build", "spacing", "curvature"), SHAPES)
def test_chains_lie_on_features_and_corners_stay(build, spacing, curvature, request):
    mesh, mesh_name = build(), request.node.callspec.id
    quads, edges = kept_quads(mesh, spacing)
    side = spacing / 2
    assert (quads.sizes == 4).all() and is_surface(quads)
    assert euler(quads) == mesh.euler_characteristic
    lengths = np.linalg.norm(np.diff(quads.vertices[quads.edges[0]], axis=1), axis=2)
    # A straight edge is this far from the arc between its ends.
    bulge = curvature * lengths.max() ** 2 / 8
    # Beside a chamfer of a third of a quad a piece of one line may be lost, which depends on the field.
    off = distances_from_edges(quads, samples(mesh, edges)) > ON_CHAIN * side + bulge
    assert off.mean() <= (0.02 if mesh_name == "chamfer-0.3" else 0.0)
    corners = mesh.vertices[line_corners(mesh, edges)]
    if len(corners):
        assert cKDTree(quads.vertices).query(corners)[0].max() < 1e-6 * side
    assert off.any() or corner_angles(quads).max() < 150


def test_without_features_the_same_shapes_lose_them():
    """What holds above is not so by itself."""
    mesh = cube(20)
    turned = TriangleMesh(mesh.vertices @ _turn(), mesh.triangles)
    quads, edges = kept_quads(turned, 0.163)
    assert distances_from_edges(quads, samples(turned, edges)).max() < ON_CHAIN * 0.0815
    plain = quad_mesh(quad_pattern(turned, direction_field(turned, 4), 0.163, branching=0.0).edge_phases)
    assert distances_from_edges(plain, samples(turned, edges)).max() > 5 * ON_CHAIN * 0.0815


def _turn():
    return np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]


@pytest.mark.full_search
def test_fandisk_keeps_its_lines_but_for_a_piece():
    path = SHARED / "fandisk.obj"
    if not path.exists():
        pytest.skip("shared meshes are not here")
    mesh = read_obj(path)
    spacing = 4 * float(np.median(mesh.edge_lengths))
    quads, edges = kept_quads(mesh, spacing)
    assert (quads.sizes == 4).all() and euler(quads) == 2
    apart = distances_from_edges(quads, samples(mesh, edges, 2)) / (spacing / 2)
    assert apart.max() < 0.5 and (apart < 0.02).mean() > 0.9
    corners = mesh.vertices[line_corners(mesh, edges)]
    assert cKDTree(quads.vertices).query(corners)[0].max() < 1e-6


def ring_on_cylinder(left_out=0, kink=0.0):
    """A cylinder of rows of quads as a QuadMesh of its own faces, and the line around it at half its height.

    One of its vertices may be higher than the others, which makes it a corner.
    """
    around, rows = 24, 8
    mesh, faces = cylinder(1.0, 2.0, around, rows), grid_quads(around, rows, wrap_columns=True)
    mesh = TriangleMesh(
        mesh.vertices + np.outer(np.arange(mesh.vertex_count) == rows // 2, [0, 0, kink]), mesh.triangles
    )
    corner = np.zeros(mesh.vertex_count, int)
    corner[mesh.triangles.ravel()] = np.arange(3 * mesh.triangle_count)
    quads = QuadMesh(mesh.vertices, corner // 3, np.eye(3)[corner % 3], faces.ravel(), np.full(len(faces), 4))
    middle = (rows + 1) * np.arange(around) + rows // 2
    ring = np.column_stack([middle, np.roll(middle, -1)])[: around - left_out]
    return quads, FeatureLines.of(mesh, mesh.edges_between(*ring.T)), ring


@pytest.mark.parametrize("left_out", range(4))
def test_a_chain_goes_along_a_line_whose_ends_are_near_each_other(left_out):
    quads, features, ring = ring_on_cylinder(left_out)
    _, chains = follow_features(quads, features)
    assert len(features.lines) == 1 and len(chains.lost) == 0
    assert set(np.flatnonzero((chains.lines == 0) | chains.fixed)) == set(ring.ravel())


def test_vertices_at_the_end_of_a_line_are_moved_apart():
    """One stands at the corner, and the next one nearly so."""
    quads, features, ring = ring_on_cylinder(4)
    places = quads.vertices.copy()
    places[ring[0, 1]] = places[ring[0, 0]] + 1e-7 * (places[ring[0, 1]] - places[ring[0, 0]])
    found, chains = follow_features(replace(quads, vertices=places), features)
    assert len(chains.lost) == 0
    lengths = np.linalg.norm(np.diff(found.vertices[ring], axis=1)[:, 0], axis=1)
    assert lengths.min() > 0.2 * lengths.mean()


def test_a_face_that_a_line_crosses_is_cut_along_it():
    """Two quads that have become one hexagon: the edge between them is made again."""
    quads, features, ring = ring_on_cylinder()
    faces = quads.corner_vertices.reshape(-1, 4).tolist()
    beside = [k for k, face in enumerate(faces) if set(ring[5]) <= set(face)]
    tail, head = ring[5].tolist()
    turned = [faces[k][faces[k].index(v) :] + faces[k][: faces[k].index(v)] for k in beside for v in (tail, head)]
    # Each from the end of the edge that it passes last, with that end first.
    first, second = (face for face in turned if face[-1] in (tail, head))
    hexagon = [*first[:-1], *second[:-1]]
    others = [face for k, face in enumerate(faces) if k not in beside]
    sizes = np.array([6, *[4] * len(others)])
    joined = replace(quads, corner_vertices=np.concatenate([hexagon, *others]), sizes=sizes)
    assert is_surface(joined)
    _, chains = follow_features(joined, features)
    assert chains.lost == pytest.approx(features.lengths / 24)  # 23 of 24 edges are still there
    assert set(np.flatnonzero(chains.lines == 0)) == set(ring.ravel())
    mended, chains = follow_features(joined, features, cut=True)
    assert len(chains.lost) == 0 and is_surface(mended)
    assert set(map(tuple, mended.edges[0])) == set(map(tuple, quads.edges[0]))


@pytest.mark.parametrize(
    ("left_out", "kink", "places"),
    [(0, 0.0, [0, 8, 13]), (4, 0.0, [0, 8, 13]), (0, 0.095, [8, 13]), (0, 0.095, [0, 8, 13]), (0, 0.095, [12])],
    ids=["closed", "open without an end", "with one corner", "without its corner", "from the corner on both sides"],
)
def test_edges_follow_the_parts_of_a_line_that_they_lie_on(left_out, kink, places):
    """A line along which faces are missing at some places."""
    quads, features, ring = ring_on_cylinder(left_out, kink)
    assert len(features.corners) == (2 if left_out else kink > 0)
    missing = ring[places, 0]
    left = quads.only(~np.isin(quads.corner_vertices.reshape(-1, 4), missing).any(axis=1))
    _, chains = follow_features(left, features)
    there = ring[~np.isin(ring, missing).any(axis=1)]
    assert chains.followed == pytest.approx([np.linalg.norm(np.diff(quads.vertices[there], axis=1), axis=2).sum()])
    assert chains.lost == pytest.approx(features.lengths - chains.followed)
    on_line = left.vertices[(chains.lines == 0) | chains.fixed]
    assert set(map(tuple, on_line)) == set(map(tuple, quads.vertices[np.unique(there)]))


def test_a_corner_stays_with_the_vertex_that_stands_there():
    """The vertex beside it has the right number of edges, and would leave an edge without length between the two."""
    mesh = TriangleMesh([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], [[0, 1, 2], [0, 2, 3]])
    features = FeatureLines.of(mesh, mesh.boundary_edges)
    cells = grid_quads(4, 4)
    points = np.array([[x, y, 0] for y in range(5) for x in range(5)], float)
    corner = np.flatnonzero((points == 0).all(axis=1))[0]
    # The cell at the corner is cut in two: its vertex there has an edge too many.
    cell = cells[(cells == corner).any(axis=1)][0]
    turned = np.roll(cell, -int(np.flatnonzero(cell == corner)[0]))
    faces = [face.tolist() for face in cells if corner not in face] + [
        turned[[0, 1, 2]].tolist(),
        turned[[0, 2, 3]].tolist(),
    ]
    points[turned[1]] = np.where(points[turned[1]] > 0, 0.1, 0)
    assert np.linalg.norm(points[turned[1]]) < CORNER_REACH
    quads = QuadMesh(
        points,
        np.zeros(len(points), int),
        np.full((len(points), 3), 1 / 3),
        np.concatenate(faces),
        np.array([len(face) for face in faces]),
    )
    found, _ = follow_features(quads, features)
    edges = found.edges[0]
    assert np.linalg.norm(np.diff(found.vertices[edges], axis=1)[:, 0], axis=1).min() > 1e-3


def test_points_are_put_on_lines_of_their_own_all_at_once(monkeypatch):
    """The nearest of many points along each line, whatever part of the pairs is compared at a time."""
    mesh = cube(5)
    features = FeatureLines.of(mesh, feature_edges(mesh, ANGLE, 0.1))
    assert len(features.lines) == 12
    random = np.random.default_rng(0)
    numbers, points = random.integers(12, size=200), random.uniform(-0.2, 1.2, (200, 3)) * np.ptp(mesh.vertices)
    monkeypatch.setattr(feature_lines, "PAIRS", 50)
    ways, apart = features.nearest(numbers, points)
    places, triangles, weights = features.at(numbers, ways)
    for number, way, away, place, point in zip(numbers, ways, apart, places, points, strict=True):
        first, last = mesh.vertices[features.lines[number][[0, -1]]]
        along = np.linspace(first, last, 1001)
        gaps = np.linalg.norm(along - point, axis=1)
        step = features.lengths[number] / 1000
        assert gaps.min() - step < away <= gaps.min() and abs(way - step * gaps.argmin()) <= step
        np.testing.assert_allclose(place, first + way / features.lengths[number] * (last - first), atol=1e-12)
    on_surface = np.einsum("pk,pkx->px", weights, mesh.vertices[mesh.triangles[triangles]])
    np.testing.assert_allclose(on_surface, places, atol=1e-12)
