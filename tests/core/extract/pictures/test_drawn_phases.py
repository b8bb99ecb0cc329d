# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles for graphics cards: they cover the faces, and their linear phases are those of the formula."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.core.extract.pictures.drawn_phases import PARTS, drawn_phases
from synch_fields.core.fields import direction_field
from synch_fields.core.fields.patterns import PatternWishes, solve_pattern
from synch_fields.core.interpolate import evaluate, face_phases

from ...meshes import as_triangles, icosphere, mixed_torus, quad_torus

BUILDS = {"triangles": lambda: as_triangles(icosphere(3)), "quads": lambda: quad_torus(None), "mixed": mixed_torus}


def weights_in(triangles, places):
    """(k, 3) barycentric weights of places in the planes of (k, 3, 3) triangles."""
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    normal = np.cross(first, second)
    offset = places - triangles[:, 0]
    square = np.einsum("ki,ki->k", normal, normal)
    b = np.einsum("ki,ki->k", np.cross(offset, second), normal) / square
    c = np.einsum("ki,ki->k", np.cross(first, offset), normal) / square
    return np.column_stack([1 - b - c, b, c])


@pytest.mark.parametrize(("name", "symmetry"), [("triangles", 2), ("quads", 4), ("mixed", 4)])
def test_drawn_triangles_cover_the_faces_and_carry_the_phases_of_the_formula(name, symmetry):
    mesh, polygons = BUILDS[name]()
    spacing = np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / 12
    # More than twice as wide at one end as at the other: lines have to end.
    x = mesh.vertices[:, 0]
    widening = spacing * (0.6 + 0.8 * (x - x.min()) / np.ptp(x))
    phases = face_phases(
        solve_pattern(mesh, direction_field(mesh, symmetry), PatternWishes(widening)).edge_phases, polygons
    )
    defects = sum(np.count_nonzero(phase.index) + np.count_nonzero(phase.disclination.any(axis=1)) for phase in phases)
    assert defects > 1
    places, values = drawn_phases(phases, polygons, mesh.vertices)
    drawn, values = places.reshape(-1, 3, 3).astype(float), values.reshape(-1, 3, 2).astype(float)
    areas = np.linalg.norm(np.cross(drawn[:, 1] - drawn[:, 0], drawn[:, 2] - drawn[:, 0]), axis=1) / 2
    assert areas.sum() == pytest.approx(mesh.areas.sum(), rel=1e-5)
    pieces = 6 * PARTS**2
    count = (len(drawn) - mesh.triangle_count) // (pieces - 1)  # singular triangles
    regular = mesh.triangle_count - count
    assert count >= len(phases) and len(drawn) == regular + pieces * count
    # Which triangle of the mesh each lies in: of those near by, the one whose plane and edges hold its middle.
    middles = drawn.mean(axis=1)
    corners = mesh.vertices[mesh.triangles]
    _, near = cKDTree(corners.mean(axis=1)).query(middles, 16)
    there = np.repeat(middles, 16, axis=0)
    weights = weights_in(corners[near.ravel()], there)
    off = np.linalg.norm(np.einsum("ki,kix->kx", weights, corners[near.ravel()]) - there, axis=1)
    fit = np.where(off < 1e-4 * spacing, weights.min(axis=1), -1).reshape(near.shape)
    inside = near[np.arange(len(near)), fit.argmax(axis=1)]
    weights = weights_in(corners[inside], middles)
    assert weights.min() > -1e-4
    for number, phase in enumerate(phases):
        exact = evaluate(phase, polygons, inside, weights)
        off = np.abs(np.cos(exact) - np.cos(values[..., number].mean(axis=1)))
        assert off[:regular].max() < 1e-4
        # Where a defect is, the phase takes every value.
        assert np.quantile(off[regular:], 0.9) < 0.02 and np.quantile(off[regular:], 0.98) < 0.2
