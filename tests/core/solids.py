# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Groups of solids that every routine must pass, and signed distances of shapes with known measures."""

from itertools import permutations, product

import numpy as np
import pytest

from synch_fields.core.geometry.tet_mesh import TetMesh, positive

from .meshes import icosphere


def grid_tets(cells, keep=lambda i, j, k: True):
    """Points of a grid of unit cubes, and six tetrahedra of each cube around its diagonal from 0 to 1."""
    shape = np.array(cells) + 1
    points = np.stack(np.meshgrid(*(np.arange(n) for n in shape), indexing="ij"), axis=-1).reshape(-1, 3).astype(float)
    tets = []
    for cube, axes in product(product(*map(range, cells)), permutations(range(3))):
        if keep(*cube):
            steps = np.cumsum(np.vstack([cube, np.eye(3, dtype=int)[list(axes)]]), axis=0)
            tets.append(np.ravel_multi_index(steps.T, shape))
    return points, positive(points, np.array(tets))


def block(cells=(4, 3, 2), lengths=(1.0, 1.0, 1.0)):
    """A box with a corner at the origin, each of its cells six tetrahedra."""
    points, tets = grid_tets(cells)
    return TetMesh(points * lengths / np.array(cells), tets)


def jittered(mesh, share=0.15, seed=0):
    """Inner vertices moved at random by a share of the shortest edge."""
    moves = np.random.default_rng(seed).uniform(-1, 1, mesh.vertices.shape) * share * mesh.edge_lengths.min()
    moves[mesh.boundary_vertices] = 0
    return TetMesh(mesh.vertices + moves, mesh.tets)


def renumbered(mesh, seed=0):
    """The mesh with its vertices and tetrahedra in random order."""
    random = np.random.default_rng(seed)
    name = random.permutation(mesh.vertex_count)
    vertices = np.empty_like(mesh.vertices)
    vertices[name] = mesh.vertices
    return TetMesh(vertices, name[mesh.tets][random.permutation(mesh.tet_count)])


def layered(surface, heights, place):
    """Tetrahedra between copies of a triangle mesh: copy k lies at ``place(vertices, heights[k])``."""
    points = np.concatenate([place(surface.vertices, height) for height in heights])
    n = surface.vertex_count
    tets = []
    for below in n * np.arange(len(heights) - 1):
        # Going up at the higher vertex first, both prisms at a side split it alike.
        a, b, c = np.sort(surface.triangles, axis=1).T + below
        tets += [np.column_stack(t) for t in ((a, b, c, c + n), (a, b, b + n, c + n), (a, a + n, b + n, c + n))]
    return points, np.concatenate(tets)


def shell(inner=0.5, outer=1.0, subdivisions=2, layers=4):
    """The space between two spheres around the origin."""
    radii = np.linspace(inner, outer, layers + 1)
    points, tets = layered(icosphere(subdivisions), radii, lambda unit, radius: radius * unit)
    return TetMesh(points, positive(points, tets))


def ball(subdivisions=2, layers=4):
    """A unit ball: a shell around a star at the origin."""
    core = shell(1 / layers, 1.0, subdivisions, layers - 1)
    surface = icosphere(subdivisions)
    points = np.vstack([core.vertices, np.zeros(3)])
    star = np.column_stack([surface.triangles, np.full(surface.triangle_count, core.vertex_count)])
    return TetMesh(points, positive(points, np.vstack([core.tets, star])))


def bent_bar(angle=np.pi / 2, inner=1.0, outer=2.0, width=1.0, cells=(8, 4, 4)):
    """A bar bent around the z axis: a sector between two radii."""
    mesh = block(cells)
    turn, radius = angle * (1 - mesh.vertices[:, 0]), inner + (outer - inner) * mesh.vertices[:, 1]
    points = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), width * mesh.vertices[:, 2]])
    return TetMesh(points, mesh.tets)


def frame():
    """A slab with a square hole: a solid torus."""
    return TetMesh(*grid_tets((3, 3, 1), lambda i, j, k: (i, j) != (1, 1)))


def notched():
    """A cube whose notches at two opposite corners touch in its middle vertex."""
    points, tets = grid_tets((2, 2, 2), lambda i, j, k: not i == j == k)
    return TetMesh(points, tets)


def together(*meshes, loose=0):
    """Several solids as one, side by side, and loose vertices after them."""
    vertices, tets, count = [], [], 0
    for k, mesh in enumerate(meshes):
        vertices.append(mesh.vertices + [5.0 * k, 0, 0])
        tets.append(mesh.tets + count)
        count += mesh.vertex_count
    return TetMesh(np.vstack([*vertices, np.full((loose, 3), 9.0)]), np.vstack(tets))


def dihedral_angles(mesh):
    """(m, 6) degrees, between the faces that meet in each edge, from the faces' normals."""
    corners = mesh.vertices[mesh.tets]
    normals = []
    for k in range(4):
        a, b, c = (corners[:, i] for i in range(4) if i != k)
        normal = np.cross(b - a, c - a)
        normal *= np.sign(np.einsum("tx,tx->t", normal, a - corners[:, k]))[:, None]
        normals.append(normal / np.linalg.norm(normal, axis=1)[:, None])
    angles = []
    for i, j in ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)):
        k, m = (other for other in range(4) if other not in (i, j))
        angles.append(180 - np.degrees(np.arccos(np.clip((normals[k] * normals[m]).sum(axis=1), -1, 1))))
    return np.column_stack(angles)


def enclosed_volume(surface):
    """Of a closed triangle surface with its faces outwards, by the divergence theorem."""
    a, b, c = np.moveaxis(surface.vertices[surface.triangles], 1, 0)
    return np.einsum("tx,tx->", a, np.cross(b, c)) / 6


# Signed distances, exact everywhere.


def ball_distance(points, radius=1.0):
    return np.linalg.norm(points, axis=1) - radius


def torus_distance(points, large=1.0, small=0.4):
    return np.hypot(np.hypot(points[:, 0], points[:, 1]) - large, points[:, 2]) - small


def box_distance(points, low=(-0.5, -0.5, -0.5), high=(0.5, 0.5, 0.5)):
    beyond = np.maximum(np.array(low) - points, points - np.array(high))
    return np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)


def shell_distance(points, inner=0.5, outer=1.0):
    radius = np.linalg.norm(points, axis=1)
    return np.maximum(radius - outer, inner - radius)


# Name, builder, volume, Euler characteristic.
SOLIDS = [
    pytest.param(block, 1.0, 1, id="block"),
    pytest.param(lambda: renumbered(jittered(block())), 1.0, 1, id="jittered"),
    pytest.param(lambda: jittered(ball(), 0.05), None, 1, id="ball"),
    pytest.param(shell, None, 2, id="shell"),
    pytest.param(bent_bar, None, 1, id="bent-bar"),
    pytest.param(frame, 8.0, 0, id="frame"),
    pytest.param(
        lambda: renumbered(together(block((2, 2, 2)), frame(), shell(subdivisions=1), loose=3)), None, 3, id="pieces"
    ),
]
