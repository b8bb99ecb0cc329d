# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Isolines: where they are, how many they are, where they end, and that they never cross."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.core.extract.lines.isolines import End, isolines
from synch_fields.core.extract.quads.trace.quad_mesh import quad_mesh
from synch_fields.core.extract.quads.trace.relocate_disclinations import relocate_disclinations
from synch_fields.core.fields import direction_field, given_directions, quad_pattern, stripe_pattern
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.interpolate import EdgePhases, disclination_centres, dislocation_numbers, evaluate, face_phases

from ...direction_wishes import boundary_row
from ...flat_crosses import plane_edge_phases, random_edge_phases
from ...meshes import annulus, bent_square, cube, cylinder, disk, double_torus, icosphere, renumbered, square, torus
from ...plane_stripes import plane_stripes

WIDTHS = [0, 0.3, 0.5, 1]


def random_stripes(mesh, smooth, seed=0, spacing=None):
    """Random phases, whose triangles are full of dislocations, along smooth or random lines."""
    random = np.random.default_rng(seed)
    field = (
        direction_field(mesh, 2) if smooth else given_directions(mesh, 2, random.standard_normal(mesh.vertices.shape))
    )
    growth = TargetOneForm.of(mesh, field, spacing or np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / 12)
    return growth.edge_phases(np.exp(1j * random.uniform(-np.pi, np.pi, mesh.vertex_count)))


def levels_of(width):
    """Offsets of lines from the middles of stripes, in periods."""
    return [0.5 * width] if width in (0, 1) else [-0.5 * width, 0.5 * width]


def chords_of_square(degrees, spacing, origin, offsets, reach=40):
    """Lengths and signed distances from the origin of the parts of plane lines inside the unit square."""
    along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    across = np.array([-along[1], along[0]])
    found = []
    for level in np.add.outer(np.arange(-reach, reach + 1), offsets).ravel() * spacing:
        foot = np.asarray(origin[:2]) + level * across
        low, high = -np.inf, np.inf
        for axis in (0, 1):
            if abs(along[axis]) < 1e-12:
                inside = -1e-12 < foot[axis] < 1 + 1e-12
                low, high = (low, high) if inside else (1, 0)
            else:
                a, b = sorted([-foot[axis] / along[axis], (1 - foot[axis]) / along[axis]])
                low, high = max(low, a), min(high, b)
        if high - low > 1e-4:
            found.append((high - low, level))
    return np.array(found).reshape(-1, 2)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize(("spacing", "origin"), [(0.1, (0, 0, 0)), (0.23, (0.21, 0.38, 0)), (0.25, (0.5, 0.5, 0))])
@pytest.mark.parametrize("degrees", [0, 17, 45])
def test_plane_stripes_have_their_lines_where_they_must_be(spacing, origin, degrees, width):
    """Also where they pass through vertices, lie on edges, or on the boundary itself."""
    lines = isolines(plane_stripes(square(8), degrees, spacing, origin), width)
    expected = chords_of_square(degrees, spacing, origin, levels_of(width))
    across = np.array([-np.sin(np.radians(degrees)), np.cos(np.radians(degrees)), 0])
    distances = (lines.points - origin) @ across
    level = expected[:, 1][np.abs(distances[lines.starts, None] - expected[:, 1]).argmin(axis=1)]
    assert len(lines.sizes) == len(expected) and len(np.unique(level)) == len(expected)
    assert np.abs(distances - level[lines.numbers]).max() < 1e-6
    order, by_level = np.argsort(level), np.argsort(expected[:, 1])
    np.testing.assert_allclose(lines.lengths[order], expected[by_level, 0], atol=1e-6)
    assert (lines.ends == End.BOUNDARY).all()
    ends = lines.points[np.concatenate([lines.starts, lines.starts + lines.sizes - 1])][:, :2]
    assert np.minimum(np.abs(ends), np.abs(1 - ends)).min(axis=1).max() < 1e-6


@pytest.mark.parametrize("width", WIDTHS)
def test_rings_around_a_tube_are_closed_and_level(width):
    mesh = cylinder(height=2.0)
    spacing, base = 0.31, 0.07
    waves = 2 * np.pi * (mesh.vertices[:, 2] - base) / spacing
    i, j = mesh.edges.T
    none = np.zeros(len(mesh.edges), int)
    lines = isolines(EdgePhases(mesh, waves[:, None], (waves[j] - waves[i])[:, None], none), width)
    heights = np.add.outer(np.arange(-2, 20), levels_of(width)).ravel() * spacing + base
    heights = np.sort(heights[(heights > 0) & (heights < 2)])
    assert lines.closed.all() and len(lines.sizes) == len(heights)
    found = lines.points[:, 2]
    np.testing.assert_allclose(np.sort(found[lines.starts]), heights, atol=1e-9)
    assert np.abs(found - found[lines.starts][lines.numbers]).max() < 1e-9
    np.testing.assert_allclose(lines.lengths, 24 * 2 * np.sin(np.pi / 24), rtol=1e-9)


def test_a_stripe_on_the_boundary_has_its_line_there():
    mesh = square(10)
    field = given_directions(mesh, 2, np.tile([1.0, 0, 0], (mesh.vertex_count, 1)))
    sides = (mesh.vertices[:, 1] == 0) | (mesh.vertices[:, 1] == 1)
    pattern = stripe_pattern(mesh, field, 0.25, [boundary_row(mesh, "phase", vertices=sides)])
    lines = isolines(pattern.edge_phases)
    heights = np.sort([lines.points[lines.numbers == k, 1].mean() for k in range(len(lines.sizes))])
    np.testing.assert_allclose(heights, [0, 0.25, 0.5, 0.75, 1], atol=1e-6)
    np.testing.assert_allclose(lines.lengths, 1, atol=1e-6)


# Quads


@pytest.mark.parametrize("degrees", [0, 17, 45])
def test_plane_quads_have_both_families_of_lines(degrees):
    cell, origin = 0.13, np.array([0.213, 0.377, 0])
    lines = isolines(plane_edge_phases(square(7), degrees, 2 * cell, origin))
    expected = np.vstack([chords_of_square(degrees + turn, cell, origin, [0]) for turn in (0, 90)])
    np.testing.assert_allclose(np.sort(lines.lengths), np.sort(expected[:, 0]), atol=1e-6)


@pytest.mark.parametrize(
    "build",
    [
        lambda: plane_edge_phases(square(7), 17, 0.31, (0.213, 0.377, 0)),
        lambda: quad_pattern(cube(6), direction_field(cube(6), 4), 0.5).edge_phases,
        lambda: quad_pattern(icosphere(3), direction_field(icosphere(3), 4), 0.5).edge_phases,
    ],
    ids=["plane", "cube", "sphere"],
)
def test_edges_of_the_quad_mesh_run_along_lines(build):
    """A vertex of it lies on the lines that cross there, and both ends of an edge on one of them."""
    edge_phases = relocate_disclinations(build())
    lines, quads = isolines(edge_phases), quad_mesh(edge_phases)
    edges, counts = quads.edges
    rim = np.unique(edges[counts == 1])
    on = lines_through(lines, quads, 1e-9 * np.linalg.norm(np.ptp(quads.vertices, axis=0)))
    inner = np.setdiff1d(np.arange(len(quads.vertices)), rim)
    degrees = np.bincount(edges.ravel(), minlength=len(quads.vertices))
    assert len(inner) > 20
    assert all(len(on[v]) >= (2 if degrees[v] == 4 else 1) for v in inner)
    # At a disclination an edge may go on along the line that ends there.
    regular = ~np.isin(edges, rim).any(axis=1) & (degrees[edges] == 4).all(axis=1)
    assert regular.sum() > 20 and all(set(on[a]) & set(on[b]) for a, b in edges[regular])


def lines_through(lines, quads, tolerance):
    """Of each vertex of a quad mesh, the lines that pass it in its triangle, once for each time."""
    here, there = lines.points, lines.points[lines.next]
    by_triangle = {}
    for k, triangle in enumerate(lines.triangles.tolist()):
        by_triangle.setdefault(triangle, []).append(k)
    found = []
    for vertex, triangle in zip(quads.vertices, quads.triangles.tolist(), strict=True):
        k = np.array(by_triangle.get(triangle, []), int)
        way = there[k] - here[k]
        share = np.clip(np.einsum("ij,ij->i", vertex - here[k], way) / np.maximum((way**2).sum(axis=1), 1e-300), 0, 1)
        apart = np.linalg.norm(here[k] + share[:, None] * way - vertex, axis=1)
        found.append(lines.numbers[k[apart < tolerance]].tolist())
    return found


# Ends and joints, whatever the phases


@cache
def solved(build, count):
    mesh = build()
    return stripe_pattern(mesh, direction_field(mesh, 2), np.ptp(mesh.vertices, axis=0).max() / count).edge_phases


def sphere():
    return icosphere(3)


STRIPES = {
    "solved-sphere": lambda: solved(sphere, 9),
    "solved-double-torus": lambda: solved(double_torus, 9),
    "solved-bent-square": lambda: solved(bent_square, 8),
    "random-sphere": lambda: random_stripes(icosphere(2), True),
    "random-bounded": lambda: random_stripes(bent_square(), True),
    "random-disk": lambda: random_stripes(disk(), False),
    "random-annulus": lambda: random_stripes(annulus(), False, 1),
    "random-lines": lambda: random_stripes(torus(), False),
    "random-fine": lambda: random_stripes(torus(), True, 2, 0.04),
}


@cache
def lines_of(name, width):
    """The phases on the edges of a mesh, and the lines."""
    edge_phases = STRIPES[name]()
    return edge_phases, isolines(edge_phases, width)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", STRIPES)
def test_lines_end_at_dislocations_as_often_as_their_numbers_say(name, width):
    edge_phases, lines = lines_of(name, width)
    mesh = edge_phases.mesh
    numbers, torn = dislocation_numbers(edge_phases, mesh.triangles)
    at = np.column_stack([lines.starts, lines.starts + lines.sizes - 1])
    ends = lines.triangles[at[lines.ends == End.DISLOCATION]]
    expected = len(levels_of(width)) * np.abs(numbers[:, 0])
    np.testing.assert_array_equal(np.bincount(ends, minlength=mesh.triangle_count), expected)
    assert expected.sum() > 0
    # At a disclination an odd number of middles end, of stripes or of gaps, and nothing else does.
    ends = np.bincount(lines.triangles[at[lines.ends == End.DISCLINATION]], minlength=mesh.triangle_count)
    values, turns = edge_phases.around(mesh.triangles[torn])
    centres = np.rint(disclination_centres(values, turns)[:, 0] / np.pi) % 2
    np.testing.assert_array_equal(ends[torn] % 2, centres == width)
    assert (ends[~torn] == 0).all() and (ends[torn][centres != width] == 0).all()


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", STRIPES)
def test_lines_close_or_end_on_the_boundary_or_at_a_defect(name, width):
    _, lines = lines_of(name, width)
    mesh = lines.mesh
    assert ((lines.ends[:, 0] == End.CLOSED) == (lines.ends[:, 1] == End.CLOSED)).all()
    at = np.column_stack([lines.starts, lines.starts + lines.sizes - 1])[lines.ends == End.BOUNDARY]
    away = lines.weights[at].argmin(axis=1)
    assert (lines.weights[at, away] == 0).all()
    assert (mesh.edge_face_counts[mesh.triangle_edges[lines.triangles[at], (away + 1) % 3]] == 1).all()
    assert len(at) > 0 or len(mesh.boundary_edges) == 0
    # From point to point they stay in one triangle: the next point has its coordinates there.
    placed = np.einsum("nk,nkx->nx", lines.ahead, mesh.vertices[mesh.triangles[lines.triangles]])
    np.testing.assert_allclose(placed, lines.points[lines.next], atol=1e-12)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", STRIPES)
def test_lines_are_at_their_level_between_the_points_too(name, width):
    """As the shader's formula has it, in every triangle without a defect, and of either side of an edge."""
    edge_phases, lines = lines_of(name, width)
    polygons = Polygons.of_triangles(edge_phases.mesh)
    (phase,) = face_phases(edge_phases, polygons)
    numbers, torn = dislocation_numbers(edge_phases, edge_phases.mesh.triangles)
    regular = ~torn[lines.triangles] & (numbers[lines.triangles, 0] == 0)
    for share in (0.0, 0.5, 1.0):
        weights = (1 - share) * lines.weights + share * lines.ahead
        cosines = np.cos(evaluate(phase, polygons, lines.triangles[regular], weights[regular]))
        assert np.abs(cosines - np.cos(np.pi * width)).max(initial=0) < 1e-6


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", STRIPES)
def test_lines_never_cross(name, width):
    _, lines = lines_of(name, width)
    order = np.argsort(lines.triangles, kind="stable")
    order = order[lines.next[order] != order]
    crossings = 0
    for group in np.split(order, np.flatnonzero(np.diff(lines.triangles[order])) + 1):
        a, b = lines.weights[group, :2], lines.ahead[group, :2]
        crossings += proper_crossings(a, b)
    assert crossings == 0


def proper_crossings(a, b):
    """How many pairs of segments from (k, 2) a to b cross inside both."""

    def sides(p, q, r):
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])

    p, q, r, s = a[:, None], b[:, None], a[None], b[None]
    margin = 1e-9
    apart = (sides(p, q, r) * sides(p, q, s) < -(margin**2)) & (sides(r, s, p) * sides(r, s, q) < -(margin**2))
    clear = np.abs([sides(p, q, r), sides(p, q, s), sides(r, s, p), sides(r, s, q)]).min(axis=0) > margin
    return np.triu(apart & clear, 1).sum()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("build", [lambda: icosphere(2), torus, bent_square])
def test_lines_of_random_quads_end_as_their_numbers_say(build, seed):
    mesh = build()
    edge_phases = random_edge_phases(mesh, direction_field(mesh, 4), np.ptp(mesh.vertices, axis=0).max() / 8, seed)
    lines = isolines(edge_phases)
    numbers, _ = dislocation_numbers(edge_phases, mesh.triangles)
    at = np.column_stack([lines.starts, lines.starts + lines.sizes - 1])[lines.ends == End.DISLOCATION]
    ends = np.bincount(lines.triangles[at], minlength=mesh.triangle_count)
    np.testing.assert_array_equal(ends, 2 * np.abs(numbers).sum(axis=1))


def test_numbering_and_signs_change_nothing():
    mesh = icosphere(3)
    edge_phases = solved(sphere, 9)
    lines = isolines(edge_phases, 0.5)
    other, vertex, _ = renumbered(mesh)
    old = np.argsort(vertex)
    changes, matched = edge_phases.between(*old[other.edges].T)
    again = isolines(EdgePhases(other, edge_phases.arguments[old], changes, matched), 0.5)
    np.testing.assert_allclose(np.sort(again.lengths), np.sort(lines.lengths), atol=1e-9)
    distances, _ = cKDTree(lines.points).query(again.points)
    assert distances.max() < 1e-9


# Lines beside defects


@pytest.mark.parametrize("width", [0.2, 0.5])
def test_both_edges_of_a_stripe_meet_where_it_begins(width):
    edge_phases = solved(sphere, 9)
    lines = isolines(edge_phases, width)
    at = np.column_stack([lines.starts, lines.starts + lines.sizes - 1])[lines.ends == End.DISLOCATION]
    assert len(at) > 0
    np.testing.assert_allclose(lines.weights[at], 1 / 3, atol=1e-12)


def test_lines_end_in_a_triangle_without_area():
    """As faces with a vertex on one of their sides have: the third corner of the triangle with the dislocation is moved
    onto the side between the others."""
    mesh = square(12)
    centres = mesh.vertices[mesh.triangles].mean(axis=1)
    number = np.linalg.norm(centres - (0.52, 0.51, 0), axis=1).argmin()
    x, y, _ = (mesh.vertices - centres[number]).T
    periods, (i, j) = 4 * x + 0.064, mesh.edges.T
    turns = np.arctan2(y, x) / (2 * np.pi)
    changes = periods[j] - periods[i] + (turns[j] - turns[i] + 0.5) % 1 - 0.5
    a, b, c = mesh.triangles[number]
    vertices = mesh.vertices.copy()
    vertices[c] = (vertices[a] + vertices[b]) / 2
    values = 2 * np.pi * (periods + turns)[:, None]
    phases = EdgePhases(
        TriangleMesh(vertices, mesh.triangles), values, 2 * np.pi * changes[:, None], np.zeros(len(i), int)
    )
    lines = isolines(phases)
    (end,) = np.argwhere(lines.ends == End.DISLOCATION)
    point = lines.starts[end[0]] + end[1] * (lines.sizes[end[0]] - 1)
    assert lines.triangles[point] == number and np.isfinite(lines.points).all()
    assert (lines.weights[point] >= 0).all() and lines.weights[point].sum() == pytest.approx(1)


def test_the_middle_of_a_stripe_ends_straight_beside_the_dislocation():
    lines = isolines(solved(sphere, 9))
    points, mesh = lines.points, lines.mesh
    both = np.column_stack([lines.starts, lines.starts + lines.sizes - 1])
    where = (lines.ends == End.DISLOCATION) & (lines.sizes > 5)[:, None]
    at = both[where]
    inwards = np.where(np.argwhere(where)[:, 1] == 0, 1, -1)
    last, before = points[at] - points[at + inwards], points[at + inwards] - points[at + 4 * inwards]
    long = np.linalg.norm(last, axis=1) > 1e-3
    cosines = np.einsum("ij,ij->i", last, before)[long]
    cosines /= (np.linalg.norm(last, axis=1) * np.linalg.norm(before, axis=1))[long]
    assert long.sum() > 5 and cosines.min() > 0.98
    centres = mesh.vertices[mesh.triangles[lines.triangles[at]]].mean(axis=1)
    assert np.linalg.norm(points[at] - centres, axis=1).max() < mesh.edge_lengths.max() / np.sqrt(3)


# Other points on the same lines


@pytest.mark.parametrize("name", ["solved-sphere", "solved-bent-square"])
@pytest.mark.parametrize("part", [0.05, 0.4, 3.0])
def test_resampled_points_are_evenly_spaced_on_the_lines(name, part):
    lines = isolines(STRIPES[name](), 0.5)
    distance = part * np.median(lines.mesh.edge_lengths)
    again = lines.resampled(distance)
    np.testing.assert_array_equal(again.ends, lines.ends)
    steps = again.sizes - ~again.closed
    np.testing.assert_array_equal(steps, np.maximum(np.rint(lines.lengths / distance), np.where(lines.closed, 3, 1)))
    ends = np.column_stack([again.starts, again.starts + again.sizes - 1])[~again.closed]
    of_lines = np.column_stack([lines.starts, lines.starts + lines.sizes - 1])[~lines.closed]
    np.testing.assert_allclose(again.points[ends], lines.points[of_lines], atol=1e-12)
    assert again.weights.min() > -1e-12
    # Brute force for the longest line: the place at each length along the polyline.
    k = lines.lengths.argmax()
    run = lines.points[lines.numbers == k]
    run = np.vstack([run, run[:1]]) if lines.closed[k] else run
    way = np.append(0, np.cumsum(np.linalg.norm(np.diff(run, axis=0), axis=1)))
    at = np.arange(again.sizes[k]) * way[-1] / steps[k]
    expected = np.column_stack([np.interp(at, way, axis) for axis in run.T])
    np.testing.assert_allclose(again.points[again.numbers == k], expected, atol=1e-9)


def test_normals_and_lengths_of_a_sphere():
    lines = isolines(solved(sphere, 9))
    assert np.abs(np.linalg.norm(lines.normals, axis=1) - 1).max() < 1e-12
    assert np.einsum("ij,ij->i", lines.normals, lines.points).min() > 0.97
    lengths = lines.arc_lengths
    assert (lengths[lines.starts] == 0).all() and (np.diff(lengths) >= 0)[np.diff(lines.numbers) == 0].all()
    # Middles of stripes a spacing apart share the sphere's area out.
    spacing = 2 / 9
    assert lines.lengths.sum() * spacing == pytest.approx(4 * np.pi, rel=0.1)
