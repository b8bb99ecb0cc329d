# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The intrinsic Delaunay triangulation against SciPy's in the plane, against flips one at a time by lengths alone, and
closed forms."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from synch_fields.core.connection import levi_civita
from synch_fields.core.defects import wrap
from synch_fields.core.fields import direction_field
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.triangle_mesh import intrinsic_delaunay

from ..meshes import EVERY, cube, icosphere, octahedron, slivers, square, torus


def plane(points, stretch=1.0):
    """The Delaunay triangulation of (n, 2) points as they are when x is stretched."""
    triangles = Delaunay(points * [stretch, 1]).simplices
    vertices = np.column_stack([points, np.zeros(len(points))])
    turned = TriangleMesh(vertices, triangles).face_normals[:, 2] < 0
    triangles[turned] = triangles[turned][:, ::-1]
    return TriangleMesh(vertices, triangles)


def badly_joined(seed=0, count=300):
    """Random points of a rectangle in triangles that are Delaunay for another metric, with a row of edges at x = 0."""
    random = np.random.default_rng(seed)
    x, y = random.uniform(0.05, 0.95, count), random.uniform(0.05, 0.95, count)
    middle = np.column_stack([np.zeros(6), np.linspace(0, 1, 6)])
    rim = [(x, y) for x in np.linspace(-1, 1, 21) for y in (0, 1) if abs(x) > 0.01]
    rim += [(x, y) for x in (-1, 1) for y in np.linspace(0, 1, 11)[1:-1]]
    points = np.concatenate([np.column_stack([np.where(np.arange(count) % 2, x, -x), y]), middle, rim])
    return points, plane(points, 30.0)


def by_ends(mesh):
    """Sorted pairs of vertices of all edges."""
    pairs = np.sort(mesh.edges, axis=1)
    return pairs[np.lexsort(pairs.T[::-1])]


def laplacian(mesh):
    total = np.zeros((mesh.vertex_count, mesh.vertex_count))
    for (i, j), weight in zip(mesh.edges, mesh.weights, strict=True):
        total[[i, j], [i, j]] += weight
        total[[i, j], [j, i]] -= weight
    return total


def test_in_the_plane_it_is_the_delaunay_triangulation():
    points, mesh = badly_joined()
    expected = plane(points)
    assert len(np.setdiff1d(mesh.edges @ [1000, 1], expected.edges @ [1000, 1])) > 300
    np.testing.assert_array_equal(by_ends(intrinsic_delaunay(mesh)), by_ends(expected))
    np.testing.assert_allclose(laplacian(intrinsic_delaunay(mesh)), laplacian(expected), atol=1e-9)
    np.testing.assert_allclose(intrinsic_delaunay(mesh).vertex_masses, expected.vertex_masses, rtol=1e-9)


def test_edges_lie_where_they_do_in_the_plane():
    """A constant direction is parallel along each, and each is as long as its ends are apart."""
    points, mesh = badly_joined()
    posed = intrinsic_delaunay(mesh)
    i, j = posed.edges.T
    np.testing.assert_allclose(posed.edge_lengths, np.linalg.norm(points[j] - points[i], axis=1), rtol=1e-12)
    angles = np.angle(mesh.tangent_numbers(np.tile([0.6, 0.8, 0], (len(points), 1))))
    np.testing.assert_allclose(wrap(angles[j] - angles[i] - levi_civita(posed, 1)), 0, atol=1e-12)


def test_edges_cross_a_fold():
    """The plane folded along a row of edges measures as before."""
    _, flat = badly_joined()
    x, y, _ = flat.vertices.T
    bent = np.column_stack([np.where(x < 0, x, x * np.cos(1)), y, np.maximum(x, 0) * np.sin(1)])
    one, other = intrinsic_delaunay(flat), intrinsic_delaunay(TriangleMesh(bent, flat.triangles))
    crossing = [(x[mesh.edges] * [1, -1]).prod(axis=1) > 0 for mesh in (flat, one)]
    assert crossing[0].sum() == 0 and crossing[1].sum() > 2
    np.testing.assert_array_equal(by_ends(one), by_ends(other))
    np.testing.assert_allclose(one.edge_lengths, other.edge_lengths, rtol=1e-9)
    np.testing.assert_allclose(wrap(levi_civita(one, 1) - levi_civita(other, 1)), 0, atol=1e-9)


class ByLengths:
    """Triangles as three sides each, glued side to side; one flip at a time."""

    def __init__(self, mesh):
        lengths = mesh.edge_lengths[mesh.triangle_edges]
        rows = zip(mesh.triangles.tolist(), lengths.tolist(), strict=True)
        self.triangles = [list(zip(corners, sides, strict=True)) for corners, sides in rows]
        self.glued = {}
        for half, twin in enumerate(mesh.twins.tolist()):
            self.glued[divmod(half, 3)] = divmod(twin, 3) if twin >= 0 else None

    def side(self, place, ahead=0):
        triangle, k = place
        return self.triangles[triangle][(k + ahead) % 3]

    def cosine(self, place):
        """Of the angle opposite a side."""
        (_, a), (_, b), (_, c) = (self.side(place, k) for k in range(3))
        return (b * b + c * c - a * a) / (2 * b * c)

    def cotangent(self, place):
        cosine = self.cosine(place)
        return cosine / np.sqrt(1 - cosine**2)

    def inner(self):
        return [(place, other) for place, other in self.glued.items() if other is not None and place < other]

    def flip(self, place, other):
        (i, a), (j, jk), (k, ki) = (self.side(place, n) for n in range(3))
        (_, _), (_, im), (m, mj) = (self.side(other, n) for n in range(3))
        turn = np.arccos((a * a + jk * jk - ki * ki) / (2 * a * jk))
        turn += np.arccos((a * a + mj * mj - im * im) / (2 * a * mj))
        diagonal = float(np.sqrt(jk * jk + mj * mj - 2 * jk * mj * np.cos(turn)))
        (t, first), (s, second) = place, other
        outer = {
            (t, (first + 1) % 3): (t, 2),
            (t, (first + 2) % 3): (s, 1),
            (s, (second + 1) % 3): (s, 2),
            (s, (second + 2) % 3): (t, 1),
        }
        glued = {old: self.glued[old] for old in outer}
        self.triangles[t], self.triangles[s] = [(k, diagonal), (m, mj), (j, jk)], [(m, diagonal), (k, ki), (i, im)]
        for old, new in outer.items():
            far = glued[old]
            far = outer.get(far, far)
            self.glued[new] = far
            if far is not None:
                self.glued[far] = new
        self.glued[t, 0], self.glued[s, 0] = (s, 0), (t, 0)

    def settle(self):
        """Flip the first edge with a negative weight until there is none."""
        while True:
            bad = [pair for pair in self.inner() if pair[0][0] != pair[1][0] and sum(map(self.cosine, pair)) < -1e-9]
            if not bad:
                return self
            self.flip(*bad[0])

    def laplacian(self, count):
        total = np.zeros((count, count))
        for place, other in self.glued.items():
            if other is None or place < other:
                i, j = self.side(place)[0], self.side(place, 1)[0]
                weight = sum(self.cotangent(p) for p in (place, other) if p is not None) / 2
                weight = np.clip(weight, 1e-4, 1e4)
                total[[i, j], [i, j]] += weight * (i != j)
                total[[i, j], [j, i]] -= weight * (i != j)
        return total


def tetrahedron(seed):
    """Random corners, some of them far out."""
    random = np.random.default_rng(seed)
    return TriangleMesh(random.standard_normal((4, 3)) * [1, 0.3, 3], [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])


def leaning(mesh):
    return TriangleMesh(mesh.vertices @ np.array([[1, 0, 0], [2, 1, 0], [0, 3, 1]]), mesh.triangles)


TINY = [
    *(pytest.param(lambda s=seed: tetrahedron(s), id=f"tetrahedron-{seed}") for seed in range(12)),
    pytest.param(lambda: leaning(octahedron()), id="octahedron"),
    pytest.param(lambda: leaning(cube(2)), id="box"),
    pytest.param(lambda: badly_joined(count=12)[1], id="plane"),
]


@pytest.mark.parametrize("build", TINY)
def test_the_laplacian_is_that_of_flips_one_at_a_time(build):
    mesh = build()
    posed = intrinsic_delaunay(mesh)
    assert posed is not mesh
    expected = ByLengths(mesh).settle().laplacian(mesh.vertex_count)
    i, j = posed.edges.T
    own = np.zeros_like(expected)
    np.add.at(own, (i, j), -posed.weights * (i != j))
    own += own.T
    np.testing.assert_allclose(own - np.diag(own.sum(axis=1)), expected, rtol=1e-6, atol=2e-4)
    assert posed.areas.sum() == pytest.approx(mesh.areas.sum(), rel=1e-9)


def test_some_of_these_join_a_vertex_to_itself_and_two_vertices_twice():
    """And are solved all the same."""
    joined = [intrinsic_delaunay(tetrahedron(seed)) for seed in range(12)]
    assert any((m.edges[:, 0] == m.edges[:, 1]).any() for m in joined)
    assert any(len(np.unique(np.sort(m.edges, axis=1), axis=0)) < len(m.edges) for m in joined)
    for seed in range(12):
        field = direction_field(tetrahedron(seed), 4)
        assert field.solution.lower_bound <= field.energy * (1 + 1e-9)
        assert sum(d.index for d in field.disclinations) == 2


@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_angles_areas_and_curvature_are_those_of_the_mesh(build, characteristic):
    mesh = build()
    posed = intrinsic_delaunay(mesh)
    assert posed.areas.sum() == pytest.approx(mesh.areas.sum(), rel=1e-9)
    np.testing.assert_allclose(posed.corner_angles.sum(axis=1), np.pi, rtol=1e-9)
    around = [np.bincount(m.triangles.ravel(), m.corner_angles.ravel(), mesh.vertex_count) for m in (posed, mesh)]
    np.testing.assert_allclose(*around, atol=1e-7)
    if not mesh.boundary_vertices.any():
        assert posed.face_curvatures.sum() == pytest.approx(2 * np.pi * characteristic, abs=1e-9)
    turns = (posed.triangle_edge_signs * levi_civita(posed, 1)[posed.triangle_edges]).sum(axis=1)
    np.testing.assert_allclose(wrap(turns - posed.face_curvatures), 0, atol=1e-7)


@pytest.mark.parametrize("build", [slivers, lambda: badly_joined()[1], lambda: leaning(cube(4))])
def test_no_weight_inside_is_clipped_and_the_sides_weigh_twice_the_area(build):
    """sum of cot a |e|^2 = 4 area in each triangle."""
    mesh = build()
    posed = intrinsic_delaunay(mesh)
    assert posed is not mesh
    cotangents = 1 / np.tan(np.roll(posed.corner_angles, 1, axis=1)).ravel()
    edges = posed.triangle_edges.ravel()
    sums = np.bincount(edges, cotangents / 2)
    inner = np.bincount(edges) == 2
    assert sums[inner].min() > -1e-7
    assert sums @ posed.edge_lengths**2 == pytest.approx(2 * mesh.areas.sum(), rel=1e-7)


@pytest.mark.parametrize("build", [icosphere, square, lambda: torus(split="AC"), cube])
def test_a_mesh_without_flat_triangles_is_its_own(build):
    mesh = build()
    assert intrinsic_delaunay(mesh) is mesh


@pytest.mark.parametrize("height", [1e-9, 1e-4, 1e-2])
def test_flat_triangles_at_the_boundary_do_not_tie_its_vertices(height):
    """The energy of a linear function is its slope squared times the area, but for that of the flat triangle."""
    even = square(6)
    edge = even.boundary_edges[0]
    half = np.flatnonzero(even.triangle_edges.ravel() == edge)[0]
    a, b, c = np.roll(even.triangles[half // 3], -(half % 3))
    middle = even.vertices[[a, b]].mean(axis=0)
    places = np.vstack([even.vertices, middle + height * (even.vertices[c] - middle)])
    new = [(a, b, len(places) - 1), (b, c, len(places) - 1), (c, a, len(places) - 1)]
    posed = intrinsic_delaunay(TriangleMesh(places, np.vstack([np.delete(even.triangles, half // 3, axis=0), new])))
    values = places @ [3, -2, 0]
    i, j = posed.edges.T
    assert posed.weights @ (values[i] - values[j]) ** 2 == pytest.approx(13, rel=1e-3)
    assert posed.weights.max() < 4
