# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Groups of meshes that every routine must pass: closed, bounded, in pieces, with handles, n-gons and slivers."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest

from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.polygons import Polygons

SHARED = Path(__file__).resolve().parents[3] / "shared" / "meshes"


def icosphere(subdivisions=2):
    """A unit sphere."""
    golden = (1 + np.sqrt(5)) / 2
    corners = [(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0)]
    vertices = np.array([np.roll(c, shift) for shift in range(3) for c in corners]) / np.sqrt(2 + golden)
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2)]
    faces += [(10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5)]
    faces += [(2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    mesh = TriangleMesh(vertices, faces)
    for _ in range(subdivisions):
        mesh = subdivided(mesh)
        mesh = TriangleMesh(mesh.vertices / np.linalg.norm(mesh.vertices, axis=1)[:, None], mesh.triangles)
    return mesh


def subdivided(mesh):
    """Each triangle cut into four at the midpoints of its edges."""
    middles = mesh.vertices[mesh.edges].mean(axis=1)
    a, b, c = mesh.triangles.T
    ab, bc, ca = mesh.vertex_count + mesh.triangle_edges.T
    triangles = np.concatenate([np.column_stack(t) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return TriangleMesh(np.concatenate([mesh.vertices, middles]), triangles)


def grid_quads(columns, rows, wrap_columns=False, wrap_rows=False):
    """(f, 4) vertices of a grid of quads, numbered along the rows first."""
    across = rows if wrap_rows else rows + 1
    i, j = (a.ravel() for a in np.mgrid[:columns, :rows])
    right = (i + 1) % columns if wrap_columns else i + 1
    up = (j + 1) % rows if wrap_rows else j + 1
    return np.column_stack([i * across + j, right * across + j, right * across + up, i * across + up])


def square_points(columns, rows=None, width=1.0, height=1.0):
    rows = columns if rows is None else rows
    x, y = np.meshgrid(np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1), indexing="ij")
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])


def square(columns=8, rows=None, width=1.0, height=1.0, split="alternate"):
    quads = grid_quads(columns, rows or columns)
    return TriangleMesh(square_points(columns, rows, width, height), split_quads(quads, split))


def split_quads(quads, split="alternate"):
    """Two triangles a quad, along AC, BD or alternating."""
    quads = np.asarray(quads)
    turn = {"AC": np.zeros(len(quads), int), "BD": np.ones(len(quads), int), "alternate": np.arange(len(quads)) % 2}
    turned = np.take_along_axis(quads, (turn[split][:, None] + np.arange(4)) % 4, axis=1)
    return np.stack([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]], axis=1).reshape(-1, 3)


def bent_square(columns=9):
    """A bounded surface with curvature of both signs."""
    mesh = square(columns)
    x, y, _ = mesh.vertices.T
    return TriangleMesh(np.column_stack([x, y, 0.3 * np.sin(4 * x) * np.cos(5 * y)]), mesh.triangles)


def annulus(inner=1.0, outer=2.0, rings=6, segments=48):
    angle, radius = np.meshgrid(
        np.arange(segments) * 2 * np.pi / segments, np.linspace(inner, outer, rings + 1), indexing="ij"
    )
    points = np.column_stack([(radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel(), np.zeros(angle.size)])
    # Angles first would turn the faces upside down: outwards is to the right of counterclockwise.
    return TriangleMesh(points, split_quads(grid_quads(segments, rings, wrap_columns=True))[:, ::-1])


def disk(rings=6, segments=24):
    """A unit disk: an annulus closed by a fan in the middle."""
    ring = annulus(1 / rings, 1.0, rings - 1, segments)
    first = np.arange(segments) * rings
    fan = np.column_stack([np.full(segments, ring.vertex_count), first, np.roll(first, -1)])
    return TriangleMesh(np.vstack([ring.vertices, np.zeros(3)]), np.vstack([ring.triangles, fan]))


def cylinder(radius=1.0, height=2.0, segments=24, rows=8, split="alternate"):
    """An open tube around the z axis, normals outwards."""
    angle, z = np.meshgrid(np.arange(segments) * 2 * np.pi / segments, np.linspace(0, height, rows + 1), indexing="ij")
    points = np.column_stack([(radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel(), z.ravel()])
    return TriangleMesh(points, split_quads(grid_quads(segments, rows, wrap_columns=True), split))


def torus_points(large, small, around, across):
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    reach = large + small * np.cos(v)
    return np.column_stack([(reach * np.cos(u)).ravel(), (reach * np.sin(u)).ravel(), small * np.sin(v).ravel()])


def torus(large=1.0, small=0.4, around=24, across=12, split="alternate"):
    quads = grid_quads(around, across, wrap_columns=True, wrap_rows=True)
    return TriangleMesh(torus_points(large, small, around, across), split_quads(quads, split))


def bumpy_torus(across):
    """A torus whose tube swells and shrinks: the same surface at any fineness, 3 across^2 vertices."""
    around = 3 * across
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    small = 0.4 * (1 + 0.25 * np.sin(3 * u) * np.cos(2 * v))
    reach = 1 + small * np.cos(v)
    points = np.stack([reach * np.cos(u), reach * np.sin(u), small * np.sin(v)], axis=-1)
    return TriangleMesh(
        points.reshape(-1, 3), split_quads(grid_quads(around, across, wrap_columns=True, wrap_rows=True))
    )


def voxel_quads(cells):
    """Vertices and outward quads of the surface of a set of unit cubes."""
    cells = {tuple(c) for c in cells}
    corners, quads = {}, []
    for cell in sorted(cells):
        for axis, side in product(range(3), (0, 1)):
            if tuple(np.add(cell, (2 * side - 1) * np.eye(3, dtype=int)[axis])) in cells:
                continue
            ring = np.zeros((4, 3), int)
            ring[:, axis] = side
            ring[:, (axis + 1) % 3], ring[:, (axis + 2) % 3] = (0, 1, 1, 0), (0, 0, 1, 1)
            ring = ring if side else ring[::-1]
            quads.append([corners.setdefault(tuple(p), len(corners)) for p in (ring + cell).tolist()])
    return np.array(list(corners), float), np.array(quads)


def cube(cuts=6):
    """The surface of a cube of edge 1 with ``cuts`` squares along every edge."""
    points, quads = voxel_quads(product(range(cuts), repeat=3))
    return TriangleMesh(points / cuts, split_quads(quads))


DOUBLE_TORUS = [(x, y, 0) for x, y in product(range(5), range(3)) if (x, y) not in ((1, 1), (3, 1))]


def double_torus(subdivisions=1):
    """A slab with two holes: genus 2."""
    points, quads = voxel_quads(DOUBLE_TORUS)
    mesh = TriangleMesh(points, split_quads(quads))
    for _ in range(subdivisions):
        mesh = subdivided(mesh)
    return mesh


def together(*meshes, loose=0):
    """Several meshes as one, side by side, and loose vertices after them."""
    vertices, triangles, count = [], [], 0
    for k, mesh in enumerate(meshes):
        vertices.append(mesh.vertices + [5.0 * k, 0, 0])
        triangles.append(mesh.triangles + count)
        count += mesh.vertex_count
    return TriangleMesh(np.vstack([*vertices, np.full((loose, 3), 9.0)]), np.vstack(triangles))


def slivers(count=6, share=1e-13):
    """A sphere in which some triangles have only ``share`` of its area: needles along one of their edges."""
    mesh = icosphere(2)
    vertices, triangles = list(mesh.vertices), list(mesh.triangles)
    for t in range(0, 40 * count, 40):
        i, j, k = triangles[t]
        middle = (vertices[i] + vertices[j]) / 2
        inwards = vertices[k] - middle
        depth = 2 * share * mesh.areas.sum() / np.linalg.norm(vertices[j] - vertices[i])
        vertices.append(middle + inwards * depth / np.linalg.norm(inwards))
        new = len(vertices) - 1
        triangles[t] = (i, j, new)
        triangles += [(j, k, new), (k, i, new)]
    return TriangleMesh(vertices, triangles)


def polygon_mesh(vertices, faces):
    """Faces with any number of corners, split into fans: the triangle mesh and its :class:`Polygons`.

    A face given as ``(corners, first)`` is fanned from its corner number ``first``.
    """
    faces = [f if isinstance(f, tuple) else (f, 0) for f in faces]
    sizes = np.array([len(corners) for corners, _ in faces])
    starts = np.cumsum(sizes) - sizes
    triangle_corners, triangle_faces = [], []
    for face, (corners, first) in enumerate(faces):
        for k in range(1, len(corners) - 1):
            triangle_corners.append([starts[face] + (first + c) % len(corners) for c in (0, k, k + 1)])
            triangle_faces.append(face)
    polygons = Polygons(
        np.concatenate([corners for corners, _ in faces]),
        starts,
        sizes,
        np.array(triangle_corners),
        np.array(triangle_faces),
    )
    return TriangleMesh(vertices, polygons.triangles), polygons


def with_split(polygons, faces):
    """The same triangles where some faces are no more than their own, as the program has those that are unfit."""
    parts, triangle_corners, triangle_faces, start = [], [], [], 0
    for face, corners in enumerate(np.split(polygons.corner_vertices, polygons.starts[1:])):
        inside = polygons.triangle_corners[polygons.triangle_faces == face] - polygons.starts[face]
        pieces = [(corners[row], [[0, 1, 2]]) for row in inside] if face in faces else [(corners, inside)]
        for own, triangles in pieces:
            triangle_corners.append(start + np.array(triangles))
            triangle_faces += [len(parts)] * len(triangles)
            parts.append(own)
            start += len(own)
    sizes = np.array([len(own) for own in parts])
    numbers = np.array(triangle_faces)
    return Polygons(np.concatenate(parts), np.cumsum(sizes) - sizes, sizes, np.vstack(triangle_corners), numbers)


def quad_torus(diagonal=0, around=24, across=12):
    """A torus of quads, all split at the given corner (0: AC, 1: BD), or at random ones with None."""
    quads = grid_quads(around, across, wrap_columns=True, wrap_rows=True)
    random = np.random.default_rng(5)
    firsts = random.integers(0, 4, len(quads)) if diagonal is None else np.full(len(quads), diagonal)
    faces = [(list(q), int(first)) for q, first in zip(quads, firsts, strict=True)]
    return polygon_mesh(torus_points(1.0, 0.4, around, across), faces)


def slanted_torus(around=24, across=12, share=1e-4):
    """A torus of quads, every second ring of which is narrow and slanted: its triangles are obtuse."""
    i, j = np.mgrid[: 2 * around, :across]
    u = 2 * np.pi * (i // 2 + i % 2 * share) / around
    v = 2 * np.pi * (j + 0.5 * (i % 2)) / across
    reach = 1 + 0.4 * np.cos(v)
    points = np.stack([reach * np.cos(u), reach * np.sin(u), 0.4 * np.sin(v)], axis=-1).reshape(-1, 3)
    return polygon_mesh(points, grid_quads(2 * around, across, wrap_columns=True, wrap_rows=True).tolist())


def twisted_sphere(cuts=6, turns=3.0):
    """A unit sphere of quads, wrung around its axis."""
    points, quads = voxel_quads(product(range(cuts), repeat=3))
    points = 2 * points / cuts - 1
    x, y, z = (points / np.linalg.norm(points, axis=1)[:, None]).T
    turned = (x + 1j * y) * np.exp(1j * turns * z)
    return polygon_mesh(np.column_stack([turned.real, turned.imag, z]), quads.tolist())


def quad_cube(cuts=5):
    points, quads = voxel_quads(product(range(cuts), repeat=3))
    return polygon_mesh(points / cuts, [(list(q), k % 4) for k, q in enumerate(quads)])


def mixed_torus(around=24, across=12):
    """Triangles, quads split either way and hexagons (two cells in one) side by side."""
    quads = grid_quads(around, across, wrap_columns=True, wrap_rows=True).reshape(around, across, 4)
    faces = []
    for i, j in product(range(0, around, 2), range(across)):
        a, b, c, d = quads[i, j]
        _, e, f, _ = quads[i + 1, j]
        kind = (i // 2 + 2 * j) % 4
        if kind == 0:
            faces.append([a, b, e, f, c, d])
        elif kind == 1:
            faces += [([a, b, c, d], 0), ([b, e, f, c], 1)]
        elif kind == 2:
            faces += [[a, b, c], [a, c, d], ([b, e, f, c], 3)]
        else:
            faces += [([a, b, c, d], 1), [b, e, f], [b, f, c]]
    return polygon_mesh(torus_points(1.0, 0.4, around, across), faces)


def honeycomb_sphere(subdivisions=2):
    """Twelve pentagons and many hexagons: the dual of an icosphere."""
    mesh = icosphere(subdivisions)
    previous = {}
    for t, corners in enumerate(mesh.triangles):
        for k in range(3):
            previous[corners[k], corners[(k + 1) % 3]] = t
    neighbours = [{} for _ in range(mesh.vertex_count)]
    for a, b, c in mesh.triangles.tolist():
        neighbours[a][b], neighbours[b][c], neighbours[c][a] = c, a, b
    faces = []
    for v, following in enumerate(neighbours):
        walk = [next(iter(following))]
        while len(walk) < len(following):
            walk.append(following[walk[-1]])
        faces.append([previous[v, w] for w in walk])
    centres = mesh.vertices[mesh.triangles].mean(axis=1)
    return polygon_mesh(centres / np.linalg.norm(centres, axis=1)[:, None], faces)


def shared_mesh(name):
    """A real mesh beside the repository, fanned into triangles; the test is skipped where it is missing."""
    path = SHARED / f"{name}.obj"
    if not path.exists():
        pytest.skip(f"{path.name} is not here")
    vertices, triangles = [], []
    for line in path.read_text().splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            vertices.append([float(x) for x in rest[:3]])
        elif word == "f":
            corners = [int(entry.split("/")[0]) - 1 for entry in rest]
            triangles += [[corners[0], corners[k], corners[k + 1]] for k in range(1, len(corners) - 1)]
    return TriangleMesh(vertices, triangles)


# Name, builder and Euler characteristic.
CLOSED = [
    pytest.param(icosphere, 2, id="icosphere"),
    pytest.param(cube, 2, id="cube"),
    pytest.param(torus, 0, id="torus"),
    pytest.param(double_torus, -2, id="double-torus"),
    pytest.param(lambda: together(icosphere(1), torus(), cube(3), loose=2), 4, id="pieces"),
    pytest.param(slivers, 2, id="slivers"),
]
BOUNDED = [
    pytest.param(square, 1, id="square"),
    pytest.param(disk, 1, id="disk"),
    pytest.param(annulus, 0, id="annulus"),
    pytest.param(cylinder, 0, id="cylinder"),
    pytest.param(bent_square, 1, id="bent-square"),
    pytest.param(lambda: together(square(4), annulus(rings=2), loose=1), 1, id="pieces"),
]
EVERY = CLOSED + BOUNDED
FLAT = [p for p in BOUNDED if p.id in ("square", "disk", "annulus")]


def renumbered(mesh, seed=0):
    """The mesh with vertices, triangles and the first corners of these in random order; (n,) new name of each vertex
    and (m,) of each triangle."""
    random = np.random.default_rng(seed)
    vertex, triangle = random.permutation(mesh.vertex_count), random.permutation(mesh.triangle_count)
    rolled = (np.arange(3) + random.integers(0, 3, (mesh.triangle_count, 1))) % 3
    vertices, triangles = np.empty_like(mesh.vertices), np.empty_like(mesh.triangles)
    vertices[vertex] = mesh.vertices
    triangles[triangle] = np.take_along_axis(vertex[mesh.triangles], rolled, axis=1)
    return TriangleMesh(vertices, triangles), vertex, triangle


def rounded_cube(cuts=8, share=0.5):
    """A cube of edge 1 around the origin, a share of the way to a sphere."""
    box = cube(cuts)
    points = box.vertices - 0.5
    sphere = 0.6 * points / np.linalg.norm(points, axis=1)[:, None]
    return TriangleMesh((1 - share) * points + share * sphere, box.triangles)


def octahedron(heights=(1.0, 1.0, 1.0)):
    """Six vertices on the axes, the positive and negative ones in turn."""
    points = np.concatenate([np.diag(heights), -np.diag(heights)])
    return TriangleMesh(
        points, [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    )


def flat_torus(width=1.0, height=1.0, columns=16, rows=12):
    """A torus that measures as the rectangle whose opposite sides it joins, and the direction of the rectangle's x axis
    in every vertex's tangent plane.

    Space has no room for it: the points are those of a round torus, lengths and angles of the rectangle.
    """
    chart = square(columns, rows, width, height)
    quads = grid_quads(columns, rows, wrap_columns=True, wrap_rows=True)
    mesh = TriangleMesh(torus_points(width, 0.4 * width, columns, rows), split_quads(quads))
    lengths = np.zeros(len(mesh.edges))
    lengths[mesh.triangle_edges] = chart.edge_lengths[chart.triangle_edges]
    vars(mesh).update(_corner_products=chart._corner_products, edge_lengths=lengths)
    ahead = np.roll(chart.triangles, -1, axis=1)
    x, y, _ = np.moveaxis(chart.vertices[ahead] - chart.vertices[chart.triangles], -1, 0)
    end = (mesh.triangle_edge_signs < 0).astype(int)
    turns = np.exp(1j * (mesh.edge_directions[mesh.triangle_edges, end] - np.arctan2(y, x)))
    axis = np.zeros(mesh.vertex_count, complex)
    axis[mesh.triangles] = turns
    assert np.abs(axis[mesh.triangles] - turns).max() < 1e-9
    return mesh, np.angle(axis)


def as_triangles(mesh):
    """A mesh and its triangles as polygons."""
    return mesh, Polygons.of_triangles(mesh)
