# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Phases inside faces: continuous across every edge, linear along it, and turning where they must."""

from functools import cache

import numpy as np
import pytest

from synch_fields.core.fields import direction_field, given_directions
from synch_fields.core.fields.patterns import PatternWishes, solve_pattern
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.interpolate import dislocation_numbers, ell, evaluate, face_phases

from .meshes import (
    as_triangles,
    bent_square,
    cube,
    honeycomb_sphere,
    icosphere,
    mixed_torus,
    quad_cube,
    quad_torus,
    slanted_torus,
    torus,
    twisted_sphere,
    with_split,
)

SURFACES = [
    pytest.param(lambda: as_triangles(icosphere(2)), id="triangles-sphere"),
    pytest.param(lambda: as_triangles(torus()), id="triangles-torus"),
    pytest.param(lambda: as_triangles(bent_square()), id="triangles-bounded"),
    pytest.param(lambda: as_triangles(cube(4)), id="triangles-cube"),
    pytest.param(lambda: quad_torus(0), id="quads-AC"),
    pytest.param(lambda: quad_torus(1), id="quads-BD"),
    pytest.param(lambda: quad_torus(None), id="quads-any-corner-first"),
    pytest.param(quad_cube, id="quads-cube"),
    pytest.param(mixed_torus, id="mixed"),
    pytest.param(honeycomb_sphere, id="hexagons"),
]


@cache
def posed(build, symmetry, phases):
    """A surface, its faces, phases on its edges, and inside its faces."""
    mesh, polygons = build()
    edge_phases = edge_phases_on(mesh, symmetry, phases)
    return mesh, polygons, edge_phases, face_phases(edge_phases, polygons)


def edge_phases_on(mesh, symmetry, phases):
    """Phases of a solved pattern, or random ones, whose faces are full of defects of both kinds."""
    random = np.random.default_rng(2)
    spacing = np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / 8
    if phases == "solved":
        return solve_pattern(mesh, direction_field(mesh, symmetry), PatternWishes(spacing)).edge_phases
    if phases == "random-lines":
        field = given_directions(mesh, symmetry, random.standard_normal((mesh.vertex_count, 3)))
    else:
        field = direction_field(mesh, symmetry)
    growth = TargetOneForm.of(mesh, field, spacing)
    return growth.edge_phases(np.exp(1j * random.uniform(-np.pi, np.pi, len(growth.masses))))


def on_edges(faces, polygons, halves, share):
    """(k, h) phases at a share of the way along half-edges 3 t + k of the triangles."""
    weights = np.zeros((len(halves), 3))
    rows = np.arange(len(halves))
    weights[rows, halves % 3] = 1 - share
    weights[rows, (halves % 3 + 1) % 3] = share
    return np.array([evaluate(phase, polygons, halves // 3, weights) for phase in faces])


def fit_halves(mesh, polygons, faces):
    """Half-edges of faces that can be represented, and whether they lie on the rim of their face."""
    halves = np.arange(3 * mesh.triangle_count)
    halves = halves[~np.isin(polygons.triangle_faces[halves // 3], faces[0].unfit)]
    twins = mesh.twins[halves]
    face = polygons.triangle_faces
    return halves, (twins < 0) | (face[halves // 3] != face[twins // 3])


@pytest.mark.parametrize("phases", ["solved", "random", "random-lines"])
@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize("build", SURFACES)
def test_the_pattern_is_continuous_across_every_edge(build, symmetry, phases):
    mesh, polygons, _, faces = posed(build, symmetry, phases)
    halves, _ = fit_halves(mesh, polygons, faces)
    halves = halves[np.isin(mesh.twins[halves], halves)]
    assert len(halves) > mesh.triangle_count / 2 or polygons.sizes.max() > 4
    for share in np.linspace(0.03, 0.97, 5):
        here = on_edges(faces, polygons, halves, share)
        there = on_edges(faces, polygons, mesh.twins[halves], 1 - share)
        np.testing.assert_allclose(np.sort(np.cos(here), axis=0), np.sort(np.cos(there), axis=0), atol=1e-9)


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize("build", [mixed_torus, slanted_torus, twisted_sphere])
def test_polygons_whose_problem_is_posed_on_other_triangles_are_continuous_once_the_unfit_are_split(build, symmetry):
    mesh, polygons = build()
    assert mesh.solver_mesh is not mesh
    edge_phases = edge_phases_on(mesh, symmetry, "solved")
    unfit = face_phases(edge_phases, polygons)[0].unfit
    assert len(unfit) > 0 or build is not mixed_torus
    polygons = with_split(polygons, unfit)
    np.testing.assert_array_equal(polygons.triangles, mesh.triangles)
    faces = face_phases(edge_phases, polygons)
    halves = np.arange(3 * mesh.triangle_count)
    for share in np.linspace(0.03, 0.97, 5):
        here = on_edges(faces, polygons, halves, share)
        there = on_edges(faces, polygons, mesh.twins, 1 - share)
        np.testing.assert_allclose(np.sort(np.cos(here), axis=0), np.sort(np.cos(there), axis=0), atol=1e-9)


@pytest.mark.parametrize("phases", ["solved", "random", "random-lines"])
@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize("build", SURFACES)
def test_the_phase_changes_evenly_along_the_rim_of_a_face(build, symmetry, phases):
    """What the phase must be on an edge is known without any face: arg phi_i + share of the change to j."""
    mesh, polygons, edge_phases, faces = posed(build, symmetry, phases)
    halves, on_rim = fit_halves(mesh, polygons, faces)
    halves = halves[on_rim]
    tails, heads = mesh.triangles.ravel()[halves], np.roll(mesh.triangles, -1, axis=1).ravel()[halves]
    changes, _ = edge_phases.between(tails, heads)
    for share in (0.0, 0.2, 0.5, 0.9, 1.0):
        theta = on_edges(faces, polygons, halves, share)
        expected = np.cos(edge_phases.arguments[tails] + share * changes).T
        np.testing.assert_allclose(np.sort(np.cos(theta), axis=0), np.sort(expected, axis=0), atol=1e-9)


@pytest.mark.parametrize("build", SURFACES)
def test_random_phases_hold_defects_of_both_kinds_in_fit_faces(build):
    mesh, polygons = build()
    (faces,) = face_phases(edge_phases_on(mesh, 2, "random-lines"), polygons)
    sizes = polygons.sizes
    fit = np.setdiff1d(np.arange(len(sizes)), faces.unfit)
    if sizes.max() > 4:
        assert len(faces.unfit) > 0
    for size in (3, 4):
        sized = fit[sizes[fit] == size]
        if len(sized):
            assert faces.disclination[sized].any() and (faces.index[sized] != 0).any()
            if size == 4:
                assert (faces.index_2[sized] != 0).any() and (faces.disclination[sized, 3] != 0).any()


@pytest.mark.parametrize("build", SURFACES)
def test_unfit_are_the_large_faces_with_a_defect_and_quads_torn_twice(build):
    mesh, polygons = build()
    edge_phases = edge_phases_on(mesh, 2, "random-lines")
    numbers, torn = dislocation_numbers(edge_phases, mesh.triangles)
    expected = []
    for face, size in enumerate(polygons.sizes):
        inside = polygons.triangle_faces == face
        if (size > 4 and (numbers[inside].any() or torn[inside].any())) or torn[inside].sum() > 1:
            expected.append(face)
    assert face_phases(edge_phases, polygons)[0].unfit.tolist() == expected


@pytest.mark.parametrize("build", SURFACES)
def test_phases_turn_around_the_middle_of_a_triangle_by_its_number(build):
    """Unwrapped along a small loop inside, the phase comes back 2 pi N further; without a defect it comes back."""
    mesh, polygons = build()
    edge_phases = edge_phases_on(mesh, 1, "random")
    (faces,) = face_phases(edge_phases, polygons)
    numbers, _ = dislocation_numbers(edge_phases, mesh.triangles)
    fit = np.flatnonzero(~np.isin(polygons.triangle_faces, faces.unfit))
    corners = np.eye(3)
    loop = [
        1 / 3 + 0.1 * ((1 - s) * corners[k] + s * corners[(k + 1) % 3] - 1 / 3)
        for k in range(3)
        for s in np.arange(0, 1, 0.05)
    ]
    theta = np.array([evaluate(faces, polygons, fit, np.tile(w, (len(fit), 1))) for w in (*loop, loop[0])])
    steps = np.diff(theta, axis=0)
    turned = (steps - 2 * np.pi * np.round(steps / (2 * np.pi))).sum(axis=0) / (2 * np.pi)
    np.testing.assert_allclose(turned, numbers[fit, 0], atol=1e-9)
    assert (numbers[fit] == 0).any()
    assert (numbers[fit] != 0).any() or polygons.sizes.min() > 4


def test_ell_grows_evenly_along_the_edges_and_turns_once():
    shares = np.linspace(0, 0.999, 50)
    corners = np.eye(3)
    for k in range(3):
        along = (1 - shares)[:, None] * corners[k] + shares[:, None] * corners[(k + 1) % 3]
        np.testing.assert_allclose(ell(along), 2 * np.pi / 3 * (k + shares), atol=1e-12)
    for size in (0.9, 0.3, 1e-3):
        loop = np.concatenate(
            [(1 - shares)[:, None] * corners[k] + shares[:, None] * corners[(k + 1) % 3] for k in range(3)]
        )
        values = ell(1 / 3 + size * (loop - 1 / 3))
        steps = np.diff(values)
        assert (steps > 0).all() and steps.max() < 0.1
        assert values[-1] - values[0] == pytest.approx(2 * np.pi, abs=0.01)


def test_ell_is_constant_along_rays_from_the_centre():
    random = np.random.default_rng(0)
    rim = np.column_stack([random.random(40), np.zeros(40), np.zeros(40)])
    rim[:, 1] = 1 - rim[:, 0]
    for shift in range(3):
        ends = np.roll(rim, shift, axis=1)
        for size in (0.8, 0.2, 1e-2):
            np.testing.assert_allclose(ell(1 / 3 + size * (ends - 1 / 3)), ell(ends), atol=1e-9)


@pytest.mark.parametrize("build", SURFACES)
def test_first_corners_start_within_one_turn(build):
    mesh, polygons = build()
    (faces,) = face_phases(edge_phases_on(mesh, 2, "random"), polygons)
    first = faces.corner_phase[polygons.starts]
    assert (np.abs(first) <= np.pi + 1e-12).all()


@pytest.mark.parametrize("build", SURFACES)
def test_regular_faces_need_no_place_and_vertices_their_phase(build):
    mesh, polygons = build()
    edge_phases = edge_phases_on(mesh, 2, "random")
    (faces,) = face_phases(edge_phases, polygons)
    numbers, torn = dislocation_numbers(edge_phases, mesh.triangles)
    singular = np.bincount(polygons.triangle_faces, weights=numbers.any(axis=1) | torn) > 0
    corner_face = np.repeat(np.arange(len(polygons.sizes)), polygons.sizes)
    regular = ~singular[corner_face]
    assert regular.any() or polygons.sizes.min() > 4
    assert not faces.corner_place[regular].any()
    arguments = edge_phases.arguments[polygons.corner_vertices, 0]
    np.testing.assert_allclose(np.cos(faces.corner_phase[regular]), np.cos(arguments[regular]), atol=1e-9)
    fit = np.setdiff1d(np.flatnonzero(singular), faces.unfit)
    in_fit = np.isin(corner_face, fit)
    assert faces.corner_place[in_fit].any(axis=1).all()
