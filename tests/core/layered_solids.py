# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids for layers: blocks, spherical shells and bent bars, and what their layers have in common."""

from itertools import permutations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from synch_fields.core.extract.layers.surfaces import layer_surfaces
from synch_fields.core.fields.guidance.solids import extend_directions, gradient_vectors
from synch_fields.core.fields.layers import LayerGroup, SolidTargetOneForm, pose_layers
from synch_fields.core.geometry.tet_mesh import TetMesh, positive
from synch_fields.core.interpolate import EdgePhases

from .meshes import icosphere
from .solids import layered


def block(counts, size=(1.0, 1.0, 1.0), jitter=0.0, seed=0):
    """Cells of a grid cut into six tetrahedra each; inner vertices moved by up to a share of a cell."""
    counts = np.array(counts)
    places = np.stack(np.meshgrid(*[np.arange(n + 1) for n in counts], indexing="ij"), axis=-1).reshape(-1, 3)
    cells = np.stack(np.meshgrid(*[np.arange(n) for n in counts], indexing="ij"), axis=-1).reshape(-1, 3)
    strides = np.array([(counts[1] + 1) * (counts[2] + 1), counts[2] + 1, 1])
    tets = []
    for order in permutations(range(3)):
        walk = np.vstack([np.zeros(3, int), np.cumsum(np.eye(3, dtype=int)[list(order)], axis=0)])
        tets.append((cells[:, None] + walk) @ strides)
    inner = ((places > 0) & (places < counts)).all(axis=1)
    moved = places + inner[:, None] * np.random.default_rng(seed).uniform(-jitter, jitter, places.shape)
    vertices = moved / counts * size
    return TetMesh(vertices, positive(vertices, np.concatenate(tets)))


def shell(radii, subdivisions=2, jitter=0.0):
    """The space between concentric spheres, with vertices at given radii; those between moved at random."""
    sphere = icosphere(subdivisions)
    count, rings = sphere.vertex_count, len(radii)
    random = np.random.default_rng(0)
    vertices, tets = layered(sphere, radii, lambda unit, radius: radius * unit)
    inner = slice(count, (rings - 1) * count)
    vertices[inner] += jitter * random.standard_normal(vertices[inner].shape)
    return TetMesh(vertices, positive(vertices, tets))


def bent_bar(counts, inner, outer, angle, depth):
    """A bar bent around the z axis: counts along the radius, the angle and the depth; and its unit angular field."""
    straight = block(counts)
    radius, turn = inner + (outer - inner) * straight.vertices[:, 0], angle * straight.vertices[:, 1]
    vertices = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), depth * straight.vertices[:, 2]])
    around = np.column_stack([-np.sin(turn), np.cos(turn), 0 * turn])
    return TetMesh(vertices, positive(vertices, straight.tets)), around


def random_phases(mesh, noise, seed=0, resting=()):
    """Random phases that the edges ask nothing in common of; 0 at resting vertices."""
    random = np.random.default_rng(seed)
    angles = random.uniform(-np.pi, np.pi, mesh.vertex_count)
    angles[list(resting)] = 0
    asked = noise * random.standard_normal((len(mesh.edges), 1))
    return EdgePhases.of(mesh, np.exp(1j * angles)[:, None], asked, np.zeros(len(mesh.edges), int))


def phases_of(mesh, angles):
    """Phases that change along edges as given angles do."""
    i, j = mesh.edges.T
    asked = (angles[j] - angles[i])[:, None]
    return EdgePhases.of(mesh, np.exp(1j * angles)[:, None], asked, np.zeros(len(asked), int))


def surfaces_of(pattern):
    return layer_surfaces(pattern.edge_phases, pattern.heights)


def normals(layers):
    """(t, 3) twice the areas, along the triangles' normals."""
    a, b, c = np.moveaxis(layers.vertices[layers.triangles], 1, 0)
    return np.cross(b - a, c - a)


def rims(layers):
    """(k, 2) vertices of the edges with one triangle; every other one has two that run along it both ways."""
    tails, heads = layers.triangles.ravel(), np.roll(layers.triangles, -1, axis=1).ravel()
    ways = list(zip(tails.tolist(), heads.tolist(), strict=True))
    assert len(set(ways)) == len(ways), "two triangles run the same way along an edge"
    met = set(ways)
    return np.array([way for way in ways if way[::-1] not in met], int).reshape(-1, 2)


def is_manifold_at_vertices(layers):
    """Whether the triangles around every vertex are one fan."""
    corners = np.arange(layers.triangles.size).reshape(-1, 3)
    ends = {}
    for tail, head, one, other in zip(
        layers.triangles.ravel(),
        np.roll(layers.triangles, -1, 1).ravel(),
        corners.ravel(),
        np.roll(corners, -1, 1).ravel(),
        strict=True,
    ):
        ends[tail, head] = one, other
    pairs = [
        pair
        for (a, b), (one, other) in ends.items()
        if (b, a) in ends
        for pair in zip((one, other), ends[b, a][::-1], strict=True)
    ]
    graph = coo_matrix((np.ones(len(pairs)), np.array(pairs).T), shape=(corners.size, corners.size))
    return connected_components(graph, directed=False)[0] == len(np.unique(layers.triangles)) == len(layers.vertices)


def lies_on_boundary(mesh, layers, edges):
    """(k,) whether both ends lie on one face of the solid's boundary."""
    faces = {tuple(face) for face in np.sort(mesh.boundary_triangles, axis=1).tolist()}
    used = layers.weights[edges] > 0
    result = []
    for corners, of in zip(layers.corners[edges], used, strict=True):
        support = np.unique(corners[of])
        around = (set(support) <= set(face) for face in faces)
        result.append(any(around))
    return np.array(result, bool)


def is_singular(layers, edges):
    """(k,) whether an edge runs from the centre of a face to that of a tetrahedron."""
    return (np.sort((layers.weights[edges] > 0).sum(axis=2), axis=1) == [3, 4]).all(axis=1)


def vertices_met(layers):
    """(t, 3) vertices of the solid at the triangles' corners, -1 where there is none."""
    at_vertex = layers.weights.max(axis=1) == 1
    vertex = np.where(at_vertex, layers.corners[np.arange(len(layers.corners)), layers.weights.argmax(axis=1)], -1)
    return vertex[layers.triangles]


def faces_carried(layers, triangles):
    """How often each of the solid's triangles is a triangle of a layer."""
    found = [tuple(row) for row in np.sort(vertices_met(layers), axis=1).tolist()]
    return [found.count(tuple(sorted(row))) for row in np.asarray(triangles).tolist()]


def on_faces(layers, vertices):
    """(t,) triangles with corners at these vertices only."""
    return np.isin(vertices_met(layers), vertices).all(axis=1)


def group_of(mesh, chosen, phase=None, name="the group"):
    """The group of (n,) bool vertices: also triangles inside the solid, unless all corners are on its boundary."""
    is_surface = ~mesh.boundary_vertices[mesh.faces].all(axis=1)
    is_surface[mesh.boundary_faces] = True
    return LayerGroup(np.flatnonzero(chosen), mesh.faces[is_surface & chosen[mesh.faces].all(axis=1)], phase, name)


def layer_problem(mesh, directions, spacing, groups=(), branching=1.0):
    """The problem that :func:`solve_layers` solves."""
    return pose_layers(SolidTargetOneForm.of(mesh, directions, spacing), groups, branching)[1]


def gradient_directions(mesh, values):
    """The direction in which a function grows fastest, (n, 3) unit vectors."""
    return extend_directions(mesh, gradient_vectors(mesh, values))
