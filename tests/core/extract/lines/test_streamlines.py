# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Streamlines and marks of direction fields, in closed form."""

import numpy as np
import pytest
from scipy.spatial import Delaunay, cKDTree

from synch_fields.core.extract import direction_glyphs, evenly_traced, trace
from synch_fields.core.geometry import TriangleMesh

SYMMETRIES = (1, 2, 4)


def disk(count=2000, seed=0):
    """A unit disk of scattered triangles, whose rim is a polygon."""
    random = np.random.default_rng(seed)
    places = 0.97 * np.sqrt(random.random(count)) * np.exp(2j * np.pi * random.random(count))
    rim = np.exp(2j * np.pi * np.arange(int(2 * np.sqrt(np.pi * count))) / int(2 * np.sqrt(np.pi * count)))
    return flat(np.concatenate([places, rim]))


def flat(places):
    """The Delaunay triangulation of complex numbers, counterclockwise."""
    points = np.column_stack([places.real, places.imag])
    triangles = Delaunay(points).simplices
    a, b, c = (places[triangles[:, k]] for k in range(3))
    turned = np.imag(np.conj(b - a) * (c - a))
    triangles[turned < 0] = triangles[turned < 0][:, ::-1]
    return TriangleMesh(np.column_stack([points, np.zeros(len(points))]), triangles[np.abs(turned) > 1e-12])


def representatives(directions, symmetry, seed=1):
    """(n, 3) vectors of complex directions, each turned by a random multiple of 2 pi / symmetry."""
    turns = np.random.default_rng(seed).integers(0, symmetry, len(directions))
    turned = directions * np.exp(2j * np.pi * turns / symmetry)
    return np.column_stack([turned.real, turned.imag, np.zeros(len(turned))])


def rotational(mesh, symmetry):
    """The field of circles around the origin."""
    places = mesh.vertices[:, 0] + 1j * mesh.vertices[:, 1]
    return representatives(1j * places / np.maximum(np.abs(places), 1e-12), symmetry)


def seeds_at(mesh, points):
    """Triangles that hold points of a flat mesh, and their barycentric coordinates there."""
    corners = mesh.vertices[mesh.triangles]
    triangles, weights = [], []
    for point in points:
        systems = np.concatenate([np.moveaxis(corners[:, :, :2], 1, 2), np.ones((len(corners), 1, 3))], axis=1)
        b = np.linalg.solve(systems, np.tile([*point, 1.0], (len(corners), 1))[:, :, None])[:, :, 0]
        triangles.append(b.min(axis=1).argmax())
        weights.append(b[triangles[-1]])
    return np.array(triangles), np.array(weights)


def line_lengths(mesh, lines):
    ends = lines.segments(mesh)
    return np.bincount(lines.line, np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))


@pytest.mark.parametrize("symmetry", SYMMETRIES)
def test_constant_field_gives_straight_lines_from_rim_to_rim(symmetry):
    mesh = disk()
    vectors = representatives(np.full(mesh.vertex_count, np.exp(0.3j)), symmetry)
    points = np.array([(0.1, 0.2), (-0.5, 0.3), (0.0, -0.8)])
    lines = trace(mesh, vectors, symmetry, *seeds_at(mesh, points), 10.0)
    ends = lines.segments(mesh)[:, :, :2] @ [1, 1j]
    slopes = set()
    for line in np.unique(lines.line):
        pieces = ends[lines.line == line]
        seed = points[line % 3] @ [1, 1j]
        slope = pieces[-1, 1] - pieces[0, 0]
        slope /= np.abs(slope)
        slopes.add((line % 3, int(np.rint(np.angle(slope * np.exp(-0.3j)) / (np.pi / 2))) % (2 if symmetry > 1 else 4)))
        turned = (pieces - seed) / slope
        np.testing.assert_allclose(turned.imag, 0, atol=1e-9)
        assert (np.diff(turned.real, axis=1) >= 0).all()
        middle, height = (seed * np.conj(slope)).real, (seed * np.conj(slope)).imag
        chord = np.sqrt(1 - height**2)  # of the unit circle, but for the rim's corners
        np.testing.assert_allclose(turned.real[[0, -1], [0, 1]] + middle, [-chord, chord], atol=5e-3)
    assert slopes == {(seed, turn) for seed in range(3) for turn in ((0, 1) if symmetry == 4 else (0,))}


@pytest.mark.parametrize("symmetry", SYMMETRIES)
def test_rotational_field_gives_circles(symmetry):
    """Representatives have random signs and quarter turns, which must not be seen."""
    worst = []
    for count in (1000, 4000):
        mesh = disk(count)
        radii = np.array([0.4, 0.6, 0.8])
        seeds = seeds_at(mesh, [(r, 0.0) for r in radii])
        lines = trace(mesh, rotational(mesh, symmetry), symmetry, *seeds, 2 * np.pi * 0.9)
        # Second lines of crosses are the radii.
        circles = lines[lines.line < 3] if symmetry != 4 else lines[_is_round(mesh, lines)]
        ends = circles.segments(mesh)
        away = np.abs(np.linalg.norm(ends, axis=2) - radii[circles.line % 3][:, None])
        worst.append(away.max())
        if symmetry != 4:
            np.testing.assert_allclose(line_lengths(mesh, lines), 2 * np.pi * 0.9)
    assert worst[0] < 0.02 and worst[1] < 0.006


def _is_round(mesh, lines):
    """Pieces of those lines that begin across the radius."""
    ends = lines.segments(mesh)[lines.step == 0]
    across = np.abs(ends[:, 1, 1] - ends[:, 0, 1]) > np.abs(ends[:, 1, 0] - ends[:, 0, 0])
    return across[lines.line]


def test_pieces_of_a_line_follow_one_another_and_stay_in_their_triangles():
    mesh = disk()
    lines = evenly_traced(mesh, rotational(mesh, 2), 2, 100)
    assert lines.weights.min() >= 0
    np.testing.assert_allclose(lines.weights.sum(axis=2), 1)
    ends = lines.segments(mesh)
    same = np.diff(lines.line) == 0
    assert (np.diff(lines.step)[same] == 1).all()
    np.testing.assert_allclose(ends[1:, 0][same], ends[:-1, 1][same], atol=1e-9)


def cylinder_with_helices(turns, rings, radius, height, slope):
    """A mesh, and vectors on it that climb at an angle."""
    angle, z = np.meshgrid(2 * np.pi * np.arange(turns) / turns, np.linspace(0, height, rings))
    vertices = np.column_stack([radius * np.cos(angle).ravel(), radius * np.sin(angle).ravel(), z.ravel()])
    i, j = (a.ravel() for a in np.meshgrid(np.arange(turns), np.arange(rings - 1)))
    a, b = j * turns + i, j * turns + (i + 1) % turns
    mesh = TriangleMesh(
        vertices, np.concatenate([np.column_stack([a, b, b + turns]), np.column_stack([a, b + turns, a + turns])])
    )
    around = np.column_stack([-vertices[:, 1], vertices[:, 0], 0 * vertices[:, 0]]) / radius
    return mesh, np.cos(slope) * around + np.sin(slope) * np.array([0, 0, 1])


def test_lines_on_a_coarse_cylinder_follow_its_helices():
    """Directions turn with the surface, from vertex to triangle and across edges: the pitch stays."""
    height = 2.0
    mesh, vectors = cylinder_with_helices(8, 20, 1.0, height, 0.5)
    middle = np.flatnonzero(np.abs(mesh.vertices[mesh.triangles].mean(axis=1)[:, 2] - 1) < 0.05)[:5]
    lines = trace(mesh, vectors, 2, middle, np.full((len(middle), 3), 1 / 3), 100.0)
    assert lines.segments(mesh)[:, :, 2].max() == pytest.approx(height)
    np.testing.assert_allclose(line_lengths(mesh, lines), height / np.sin(0.5), rtol=1e-6)


def test_lines_around_a_thin_limb_do_not_lie_beside_themselves():
    """Where a line would wind on and on at less than the distance between lines, it ends."""
    mesh, vectors = cylinder_with_helices(12, 400, 0.006, 2.0, 0.05)
    lines = evenly_traced(mesh, vectors, 2, 100)
    ends = lines.segments(mesh)
    apart = np.sqrt(mesh.areas.sum()) / 32
    along = np.cumsum(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))
    i, j = cKDTree(ends.mean(axis=1)).query_pairs(0.5 * apart, output_type="ndarray").T
    far = (lines.line[i] != lines.line[j]) | (np.abs(along[i] - along[j]) > 3 * apart)
    normals = mesh.face_normals[lines.triangle]
    assert len(np.unique(lines.line)) > 50
    beside = far & (np.einsum("ij,ij->i", normals[i], normals[j]) > 0.5)
    assert beside.sum() < 0.01 * len(lines.line)


def test_lines_lie_at_even_distances():
    """No point is far from a line, and no line lies on another."""
    mesh = disk(4000)
    lines = evenly_traced(mesh, representatives(np.ones(mesh.vertex_count, complex), 2), 2, 100)
    ends = lines.segments(mesh)
    apart = np.sqrt(np.pi) / 32
    assert cKDTree(ends.mean(axis=1)).query(mesh.vertices)[0].max() < 3 * apart
    extents = [
        (pieces[0, 0, 1], *np.sort(pieces[:, :, 0].ravel())[[0, -1]])
        for pieces in (ends[lines.line == line] for line in np.unique(lines.line))
    ]
    assert len(extents) > 30
    for k, (height, low, high) in enumerate(extents):
        for other_height, other_low, other_high in extents[:k]:
            overlap = min(high, other_high) - max(low, other_low)
            assert abs(height - other_height) > 0.3 * apart or overlap < 0.5 * apart


def test_line_that_circles_a_corner_ends():
    """A field that points at a vertex from all sides: lines neither run for ever nor leave the mesh."""
    mesh = disk(300)
    places = mesh.vertices[:, 0] + 1j * mesh.vertices[:, 1]
    spiral = places / np.maximum(np.abs(places), 1e-12) * np.exp(0.5j * np.pi * 0.98)
    lines = trace(mesh, representatives(-spiral, 1), 1, *seeds_at(mesh, [(0.3, 0.1), (0.0, 0.02)]), 50.0)
    assert np.linalg.norm(lines.segments(mesh), axis=2).max() < 1 + 1e-9
    assert len(lines.line) < 1e5


@pytest.mark.parametrize(("symmetry", "segments"), [(1, 3), (2, 1), (4, 2)])
def test_marks_lie_above_the_surface_and_show_the_symmetry(symmetry, segments):
    mesh = disk(500)
    marks = direction_glyphs(mesh, representatives(np.full(mesh.vertex_count, np.exp(0.7j)), 1), symmetry, 10**6)
    count = len(marks) // segments
    assert len(marks) == segments * count and count > 0.5 * mesh.vertex_count
    assert (marks[:, :, 2] > 0).all()
    shafts = (marks[:, 1] - marks[:, 0])[:count]
    np.testing.assert_allclose(np.angle(shafts[:, 0] + 1j * shafts[:, 1]), 0.7)
    centres = marks[:count].mean(axis=1)
    assert cKDTree(mesh.vertices[:, :2]).query(centres[:, :2])[0].max() < 1e-9
    if symmetry == 4:
        bars = (marks[:, 1] - marks[:, 0])[count:]
        np.testing.assert_allclose(np.einsum("ij,ij->i", shafts, bars), 0, atol=1e-9)
    if symmetry == 1:
        np.testing.assert_allclose(marks[count:, 0], np.tile(marks[:count, 1], (2, 1)))


def test_marks_are_thinned_evenly_on_a_dense_mesh():
    mesh = disk(20000)
    marks = direction_glyphs(mesh, representatives(np.ones(mesh.vertex_count, complex), 2), 2, 300)
    assert 150 < len(marks) <= 300
    distances = cKDTree(marks.mean(axis=1)[:, :2]).query(mesh.vertices[:, :2])[0]
    assert distances.max() < 2.5 * np.sqrt(np.pi / len(marks))


def test_vertices_without_a_direction_have_no_mark():
    mesh = disk(100)
    vectors = representatives(np.ones(mesh.vertex_count, complex), 2)
    vectors[5:] = 0
    assert 1 <= len(direction_glyphs(mesh, vectors, 2, 100)) <= 5
    assert direction_glyphs(mesh, 0 * vectors, 2, 100).shape == (0, 2, 3)
