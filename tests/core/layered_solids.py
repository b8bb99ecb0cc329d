# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids for layers: blocks, spherical shells and bent bars, and what their layers have in common."""

from itertools import permutations

import numpy as np

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
