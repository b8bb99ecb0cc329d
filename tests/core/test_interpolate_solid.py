# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Phases inside tetrahedra: linear, or singular along one curve, and the same from both sides of every face."""

import numpy as np
import pytest

from synch_fields.core.defects import wrap
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.interpolate import EdgePhases, evaluate, face_phases
from synch_fields.core.interpolate_solid import evaluate_in_tets, face_numbers, outward_numbers, tet_phases

from .layered_solids import block, random_phases, shell

SOLIDS = [lambda: block((3, 3, 3), jitter=0.2), lambda: shell(np.linspace(1, 2, 3), 1), lambda: block((2, 2, 1))]
OUTWARD = ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))
# From faces that nothing punctures to numbers far beyond what an edge can miss.
NOISES = [0.3, 2, 12]


def linear_phases(mesh, rate, start=0.4):
    """Of a plane wave, with rates of several turns per edge."""
    angles = mesh.vertices @ rate + start
    i, j = mesh.edges.T
    asked = (angles[j] - angles[i])[:, None]
    return EdgePhases.of(mesh, np.exp(1j * angles)[:, None], asked, np.zeros(len(mesh.edges), int))


def from_corners(mesh, tets, faces, weights):
    """(k, 4) weights in tetrahedra of points of their faces, given by weights of the faces' vertices."""
    local = (mesh.tets[tets][:, None, :] == mesh.faces[faces][:, :, None]).argmax(axis=2)
    result = np.zeros((len(tets), 4))
    np.put_along_axis(result, local, weights, axis=1)
    return result


@pytest.mark.parametrize("rate", [(0, 0, 9.0), (31, -18, 44)])
def test_plane_waves_are_met_everywhere(rate):
    mesh = block((3, 3, 3), jitter=0.2)
    phases = tet_phases(linear_phases(mesh, np.array(rate)))
    assert not phases.punctured.any()
    random = np.random.default_rng(0)
    tets, weights = random.integers(0, mesh.tet_count, 500), random.dirichlet(np.ones(4), 500)
    points = np.einsum("kc,kcx->kx", weights, mesh.vertices[mesh.tets[tets]])
    np.testing.assert_allclose(wrap(evaluate_in_tets(phases, tets, weights) - points @ rate - 0.4), 0, atol=1e-9)
    np.testing.assert_allclose(phases.gradients(mesh), np.tile(rate, (mesh.tet_count, 1)), atol=1e-9)


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("build", SOLIDS)
def test_numbers_of_faces_are_windings_and_cancel_in_every_tetrahedron(build, noise):
    mesh = build()
    edge_phases = random_phases(mesh, noise)
    numbers = face_numbers(edge_phases)
    changes = {tuple(edge): change for edge, change in zip(mesh.edges.tolist(), edge_phases.changes[:, 0], strict=True)}
    changes |= {(j, i): -change for (i, j), change in changes.items()}
    for (i, j, k), number in zip(mesh.faces.tolist(), numbers, strict=True):
        assert changes[i, j] + changes[j, k] + changes[k, i] == pytest.approx(2 * np.pi * number, abs=1e-9)
    outward = outward_numbers(mesh, numbers)
    for tet, row in zip(mesh.tets, outward, strict=True):
        around = [sum(changes[tet[c[k]], tet[c[k - 2]]] for k in range(3)) for c in OUTWARD]
        np.testing.assert_allclose(around, 2 * np.pi * row, atol=1e-9)
    assert numbers.any()
    np.testing.assert_array_equal(outward.sum(axis=1), 0)


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("build", SOLIDS)
def test_both_sides_of_a_face_have_the_same_phase(build, noise):
    mesh = build()
    edge_phases = random_phases(mesh, noise)
    phases, numbers = tet_phases(edge_phases), face_numbers(edge_phases)
    inner = np.flatnonzero(mesh.face_tets[:, 1] >= 0)
    assert numbers[inner].any()
    faces = np.repeat(inner, 10)
    weights = np.random.default_rng(3).dirichlet(np.ones(3), len(faces))
    sides = [
        evaluate_in_tets(
            phases, mesh.face_tets[faces, side], from_corners(mesh, mesh.face_tets[faces, side], faces, weights)
        )
        for side in range(2)
    ]
    np.testing.assert_allclose(wrap(sides[0] - sides[1]), 0, atol=1e-9)
    assert np.ptp(np.cos(sides[0])) > 1


@pytest.mark.parametrize("noise", NOISES)
def test_on_the_boundary_it_is_the_pattern_of_a_surface(noise):
    mesh = block((2, 3, 2), jitter=0.2)
    edge_phases = random_phases(mesh, noise)
    surface, source = mesh.boundary_surface
    changes = edge_phases.changes[mesh.edges_between(*source[surface.edges].T)]
    of_surface = EdgePhases(surface, edge_phases.arguments[source], changes, np.zeros(len(changes), int))
    polygons = Polygons.of_triangles(TriangleMesh(surface.vertices, surface.triangles))
    triangles = np.repeat(np.arange(surface.triangle_count), 10)
    weights = np.random.default_rng(5).dirichlet(np.ones(3), len(triangles))
    expected = evaluate(face_phases(of_surface, polygons)[0], polygons, triangles, weights)
    faces = mesh.boundary_faces[triangles]
    assert face_numbers(edge_phases)[faces].any()
    tets = mesh.face_tets[faces, 0]
    ascending = np.take_along_axis(weights, np.argsort(source[surface.triangles[triangles]], axis=1), axis=1)
    found = evaluate_in_tets(tet_phases(edge_phases), tets, from_corners(mesh, tets, faces, ascending))
    np.testing.assert_allclose(wrap(found - expected), 0, atol=1e-9)


@pytest.mark.parametrize("noise", NOISES)
def test_the_phase_turns_around_the_curve_as_often_as_around_its_faces(noise):
    """In space: on a small circle around the way from the centre of each tetrahedron to each of its faces."""
    mesh = block((3, 3, 3), jitter=0.2)
    phases = tet_phases(random_phases(mesh, noise))
    steps = np.linspace(0, 2 * np.pi, 2000)
    tets, sides = np.nonzero(phases.punctured[:, None] & np.ones((1, 4), bool))
    met = set()
    for tet, side in zip(tets[:160], sides[:160], strict=True):
        corners = mesh.vertices[mesh.tets[tet]]
        centre, face = corners.mean(axis=0), corners[np.arange(4) != side].mean(axis=0)
        axis = (face - centre) / np.linalg.norm(face - centre)
        first = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
        first /= np.linalg.norm(first)
        circle = np.cos(steps)[:, None] * first + np.sin(steps)[:, None] * np.cross(axis, first)
        radius = 1e-3 * mesh.edge_lengths.min()
        points = centre + 0.5 * (face - centre) + radius * circle
        weights = np.linalg.solve(np.vstack([corners.T, np.ones(4)]), np.vstack([points.T, np.ones(len(points))])).T
        values = evaluate_in_tets(phases, np.full(len(points), tet), weights)
        changes = wrap(np.diff(values))
        assert np.abs(changes).max() < 1
        assert changes.sum() == pytest.approx(2 * np.pi * phases.numbers[tet, side], abs=1e-9)
        met.add(int(phases.numbers[tet, side]))
    assert {-1, 0, 1} <= met


@pytest.mark.parametrize("noise", NOISES)
def test_away_from_the_curve_nothing_jumps(noise):
    """Along straight ways through punctured tetrahedra, between places that are apart from the singular segments."""
    mesh = block((2, 2, 2), jitter=0.2)
    phases = tet_phases(random_phases(mesh, noise))
    random = np.random.default_rng(1)
    punctured = np.flatnonzero(phases.punctured)
    shares = np.linspace(0, 1, 4001)[:, None]
    sharpest = 0
    for tet in random.choice(punctured, 60):
        begin, end = random.dirichlet(np.ones(4), 2)
        weights = begin + shares * (end - begin)
        values = evaluate_in_tets(phases, np.full(len(weights), tet), weights)
        apart = np.min([_from_segment(weights, side) for side in np.flatnonzero(phases.numbers[tet])], axis=0) > 0.03
        jumps = np.abs(wrap(np.diff(values)))[apart[1:] & apart[:-1]]
        sharpest = max(sharpest, jumps.max(initial=0))
    rate = np.abs(phases.numbers).max() * 2 * np.pi / 0.03 + np.ptp(phases.values, axis=1).max()
    assert 0 < sharpest < 2 * rate / len(shares)


def _from_segment(weights, side):
    """Distance, in barycentric coordinates, from the way between the centre and a face's."""
    centre, face = np.full(4, 0.25), np.where(np.arange(4) == side, 0, 1 / 3)
    share = np.clip((weights - centre) @ (face - centre) / ((face - centre) @ (face - centre)), 0, 1)
    return np.linalg.norm(weights - centre - share[:, None] * (face - centre), axis=1)
