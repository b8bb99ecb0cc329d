# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines traced through triangles: where they are, how many they are, and that they lie on the surface."""

from functools import cache

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from synch_fields.core.extract.quads.trace.grid_lines import grid_lines
from synch_fields.core.fields import direction_field, quad_pattern
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.interpolate import (
    EdgePhases,
    disclination_centres,
    dislocation_numbers,
    evaluate,
    face_phases,
)

from ...flat_crosses import cone, plane_edge_phases, random_crosses, random_edge_phases
from ...meshes import annulus, bent_square, cube, disk, double_torus, icosphere, rounded_cube, square, torus


def size(mesh):
    return np.linalg.norm(np.ptp(mesh.vertices, axis=0))


def places(mesh, lines):
    return np.einsum("nk,nkx->nx", lines.weights, mesh.vertices[mesh.triangles[lines.triangles]])


def singular(edge_phases):
    """(m,) bool, triangles with a defect of either kind."""
    numbers, torn = dislocation_numbers(edge_phases, edge_phases.mesh.triangles)
    return torn | numbers.any(axis=1)


PATTERNS = {
    "plane": lambda: plane_edge_phases(square(7), 23, 0.31, (0.2, 0.1, 0)),
    "cone-3": lambda: cone(3, 5.3),
    "cone-5": lambda: cone(5, 5.3),
    "solved-sphere": lambda: solved("solved-sphere", 7),
    "solved-cube": lambda: solved("solved-cube", 6),
    "solved-double-torus": lambda: solved("solved-double-torus", 8),
    "solved-bent-square": lambda: solved("solved-bent-square", 7),
    "random-phases": lambda: randomly(icosphere(2), True),
    "random-bounded": lambda: randomly(bent_square(), True),
    "random-crosses": lambda: randomly(torus(), False),
}
MESHES = {
    "solved-sphere": lambda: icosphere(3),
    "solved-cube": lambda: cube(7),
    "solved-double-torus": lambda: double_torus(2),
    "solved-bent-square": bent_square,
}


@cache
def phases_of(name):
    return PATTERNS[name]()


@cache
def lines_of(name):
    return grid_lines(phases_of(name))


@cache
def crosses_on(name):
    return direction_field(MESHES[name](), 4)


def solved(name, cells):
    field = crosses_on(name)
    return quad_pattern(field.mesh, field, size(field.mesh) / cells).edge_phases


def randomly(mesh, smooth, seed=0, cells=8):
    field = direction_field(mesh, 4) if smooth else random_crosses(mesh, seed)
    return random_edge_phases(mesh, field, size(mesh) / cells, seed)


@pytest.mark.parametrize("name", PATTERNS)
def test_lines_are_where_a_phase_is_a_multiple_of_pi(name):
    """As the shader's formula has it: one phase on lines, both where they cross."""
    edge_phases, lines = phases_of(name), lines_of(name)
    mesh = edge_phases.mesh
    polygons = Polygons.of_triangles(mesh)
    parts = face_phases(edge_phases, polygons)
    sines = np.abs([np.sin(evaluate(part, polygons, lines.triangles, lines.weights)) for part in parts])
    degrees = lines.graph.degrees
    used = (degrees > 0) & ~lines.graph.kept
    corners = (lines.weights > 1 - 1e-12).any(axis=1) & (degrees == 2)  # of triangles: boundary between lines
    regular = ~singular(edge_phases)[lines.triangles]
    assert (used & regular).sum() > 40 or "random" in name
    assert sines.min(axis=0)[used & ~corners & regular].max(initial=0) < 1e-6
    assert sines.max(axis=0)[used & regular & (degrees == 4)].max(initial=0) < 1e-6
    if not name.startswith("random"):
        assert (degrees == 4).sum() > 10


def lattice_points(edge_phases):
    """Brute force: the points of regular triangles at which both phases, linear there, are multiples of pi."""
    mesh = edge_phases.mesh
    values, _ = edge_phases.around(mesh.triangles)
    found = []
    for triangle in np.flatnonzero(~singular(edge_phases)):
        corners = values[triangle, :3] / np.pi
        low, high = np.ceil(corners.min(axis=0)).astype(int), np.floor(corners.max(axis=0)).astype(int)
        for x in range(low[0], high[0] + 1):
            for y in range(low[1], high[1] + 1):
                matrix = np.vstack([corners.T, np.ones(3)])
                weights = np.linalg.solve(matrix, [x, y, 1])
                if (weights > 0).all():
                    found.append(weights @ mesh.vertices[mesh.triangles[triangle]])
    return np.array(found)


@pytest.mark.parametrize("name", [name for name in PATTERNS if name != "random-phases"])
def test_crossings_are_all_lattice_points_of_the_triangles(name):
    edge_phases, lines = phases_of(name), lines_of(name)
    mesh = edge_phases.mesh
    inside = (lines.weights > 1e-9).all(axis=1) & ~singular(edge_phases)[lines.triangles]
    found, expected = places(mesh, lines)[inside], lattice_points(edge_phases)
    assert len(found) == len(expected) > 0
    distances, nearest = cKDTree(expected).query(found)
    assert distances.max() < 1e-6 * size(mesh) and len(np.unique(nearest)) == len(expected)
    assert (lines.graph.degrees[inside] == 4).all()


@pytest.mark.parametrize("name", PATTERNS)
def test_every_edge_is_crossed_as_often_as_phases_pass_multiples_of_pi(name):
    edge_phases, lines = phases_of(name), lines_of(name)
    mesh = edge_phases.mesh
    begin = edge_phases.arguments[mesh.edges[:, 0]] / np.pi
    counts = np.abs(np.floor(begin + edge_phases.changes / np.pi) - np.floor(begin)).sum(axis=1).astype(int)
    on_edges = np.sort(lines.weights, axis=1)[:, 0] < 1e-12
    on_edges &= (lines.weights < 1 - 1e-12).all(axis=1)
    # Seen from the triangle of a node, the edge is the one away from its zero weight.
    zero = lines.weights[on_edges].argmin(axis=1)
    found = np.bincount(mesh.triangle_edges[lines.triangles[on_edges], (zero + 1) % 3], minlength=len(mesh.edges))
    np.testing.assert_array_equal(found, counts)


@pytest.mark.parametrize("name", ["cone-3", "cone-5", "solved-sphere", "solved-double-torus", "random-crosses"])
def test_centres_have_the_valence_of_their_index(name):
    """Lines pass a centre as often as the phases around it turn by quarters, or two more at a time."""
    edge_phases, lines = phases_of(name), lines_of(name)
    mesh = edge_phases.mesh
    _, torn = dislocation_numbers(edge_phases, mesh.triangles)
    centres = lines.centres
    np.testing.assert_array_equal(np.sort(lines.triangles[centres]), np.flatnonzero(torn))
    np.testing.assert_allclose(lines.weights[centres], 1 / 3, atol=1e-12)
    values, turns = edge_phases.around(mesh.triangles[lines.triangles[centres]])
    np.testing.assert_array_equal(lines.valences[centres], np.array([4, 5, 2, 3])[turns])
    away = (values - disclination_centres(values, turns)[:, None]) @ [1, 1j]
    quarters = np.rint(np.angle(away[:, 1:] / away[:, :-1]).sum(axis=1) / (np.pi / 2)).astype(int)
    degrees = lines.graph.degrees[centres]
    assert (degrees >= np.abs(quarters)).all() and ((degrees - quarters) % 2 == 0).all()
    if name in ("cone-3", "cone-5"):
        np.testing.assert_array_equal(degrees, lines.valences[centres])


@pytest.mark.parametrize("name", ["solved-sphere", "solved-double-torus", "solved-cube"])
def test_valences_are_those_of_the_field(name):
    lines, field = lines_of(name), crosses_on(name)
    expected = {d.triangle: 4 - 4 * d.index for d in field.disclinations}
    assert expected == {lines.triangles[c].item(): lines.valences[c] for c in lines.centres}


# What a graph on a surface cannot be wrong about


def piece_labels(graph):
    """(n,) piece of each node and how many pieces have an edge."""
    count = len(graph.kept)
    pairs = graph.tails.reshape(-1, 2).T
    labels = connected_components(coo_matrix((np.ones(pairs.shape[1]), pairs), shape=(count, count)), directed=False)[1]
    return labels, len(np.unique(labels[graph.tails]))


def genera(graph):
    """Genus of the surface that each piece of the graph would span, from its order around the nodes alone."""
    labels, _ = piece_labels(graph)
    used = np.unique(graph.tails)
    nodes = np.bincount(labels[used], minlength=len(labels))
    darts = np.bincount(labels[graph.tails], minlength=len(labels))
    first = np.unique(graph.face_labels, return_index=True)[1]
    rims = np.bincount(labels[graph.tails[first]], minlength=len(labels))
    twice = 2 - (nodes - darts // 2 + rims)[darts > 0]
    assert (twice % 2 == 0).all()
    return twice // 2


SURFACES = [
    pytest.param(lambda: icosphere(2), 0, id="icosphere"),
    pytest.param(rounded_cube, 0, id="rounded-cube"),
    pytest.param(torus, 1, id="torus"),
    pytest.param(lambda: double_torus(2), 2, id="double-torus"),
    pytest.param(bent_square, 0, id="bent-square"),
    pytest.param(disk, 0, id="disk"),
    pytest.param(annulus, 0, id="annulus"),
]


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("smooth", [True, False])
@pytest.mark.parametrize(("build", "genus"), SURFACES)
def test_no_piece_of_the_lines_has_more_handles_than_the_surface(build, genus, smooth, seed):
    """Whatever the phases: one wrong order around a node would be a handle too many."""
    edge_phases = randomly(build(), smooth, seed, 12)
    graph = grid_lines(edge_phases).graph
    assert len(graph.tails) > 100 and singular(edge_phases).any()
    for stage in (graph, graph.contracted(), graph.cleaned()):
        found = genera(stage)
        assert (found >= 0).all() and found.sum() <= genus


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("build", [lambda: square(9), lambda: disk(7, 30), lambda: annulus(rings=7, segments=40)])
def test_in_the_plane_every_piece_has_one_outside(build, seed):
    """Walked with the surface on the left, all rims but one of each piece go around counterclockwise."""
    edge_phases = randomly(build(), False, seed, 9)
    graph, points = grid_lines(edge_phases).graph, places(edge_phases.mesh, grid_lines(edge_phases))
    here, there = points[graph.tails], points[graph.heads]
    areas = np.bincount(graph.face_labels, 0.5 * (here[:, 0] * there[:, 1] - here[:, 1] * there[:, 0]))
    _, count = piece_labels(graph)
    assert count > 3
    assert (areas < 1e-13).sum() == count


@pytest.mark.parametrize("name", PATTERNS)
def test_the_boundary_is_walked_once_with_the_surface_on_its_left(name):
    edge_phases, lines = phases_of(name), lines_of(name)
    mesh = edge_phases.mesh
    points, graph = places(mesh, lines), lines.graph
    outside = graph.outside.reshape(-1, 2)
    assert not outside[:, 0].any()
    border = graph.tails.reshape(-1, 2)[outside[:, 1]]
    steps = points[border[:, 1]] - points[border[:, 0]]
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(mesh.edge_lengths[mesh.boundary_edges].sum(), abs=1e-9)
    np.testing.assert_array_equal(np.sort(border[:, 0]), np.sort(border[:, 1]))
    assert (len(border) > 0) == (len(mesh.boundary_edges) > 0)
    if len(border) and name != "solved-bent-square" and name != "random-bounded":  # flat: counterclockwise
        here, there = points[border[:, 0]], points[border[:, 1]]
        area = 0.5 * (here[:, 0] * there[:, 1] - here[:, 1] * there[:, 0]).sum()
        assert area == pytest.approx(mesh.areas.sum(), rel=1e-9)


def test_without_a_line_there_is_nothing():
    """A sphere smaller than a cell."""
    mesh = icosphere(1)
    none = np.zeros(len(mesh.edges), int)
    still = EdgePhases(mesh, np.ones((mesh.vertex_count, 2)), np.zeros((len(none), 2)), none)
    lines = grid_lines(still)
    assert len(lines.graph.tails) == 0 and len(lines.triangles) == 0
