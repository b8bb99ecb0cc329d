# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Direction fields: indices, corners of a cube, flat domains, and directions given by the user."""

import numpy as np
import pytest

from synch_fields.core.defects import disclination_numbers, list_defects, wrap
from synch_fields.core.errors import SettingError
from synch_fields.core.fields import direction_field, given_directions
from synch_fields.core.geometry import TriangleMesh

from ..direction_wishes import on_boundary
from ..meshes import CLOSED, EVERY, FLAT, cube, disk, icosphere, octahedron, shared_mesh, square, together, torus


def total_index(defects, symmetry):
    """Sum of indices, exactly."""
    return sum(round(symmetry * d.index) for d in defects) / symmetry


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize(("build", "characteristic"), CLOSED)
def test_sum_of_indices_is_the_euler_characteristic(build, characteristic, symmetry):
    field = direction_field(build(), symmetry)
    assert total_index(field.disclinations, symmetry) == characteristic


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize(("build", "characteristic"), CLOSED)
def test_even_random_fields_have_that_sum(build, characteristic, symmetry):
    mesh = build()
    powers = np.exp(1j * np.random.default_rng(symmetry).uniform(-np.pi, np.pi, mesh.vertex_count))
    numbers = disclination_numbers(mesh, powers, symmetry)
    assert numbers.any() and numbers.sum() == symmetry * characteristic
    assert total_index(list_defects(mesh, "disclination", numbers, symmetry), symmetry) == characteristic


def test_each_piece_has_the_sum_of_its_own():
    mesh = together(icosphere(2), torus(), cube(4))
    field = direction_field(mesh, 4)
    labels = [mesh.pieces[mesh.triangles[d.triangle, 0]] for d in field.disclinations]
    sums = np.bincount(labels, weights=[d.index for d in field.disclinations], minlength=3)
    np.testing.assert_allclose(sums, [2, 0, 2], atol=1e-12)


@pytest.mark.parametrize("name", ["spot", pytest.param("rocker-arm", marks=pytest.mark.slow)])
def test_real_meshes_have_that_sum(name):
    mesh = shared_mesh(name)
    field = direction_field(mesh, 4)
    assert total_index(field.disclinations, 4) == mesh.euler_characteristic
    assert field.solution.lower_bound > 0


def test_a_cube_has_a_quarter_at_each_of_its_corners():
    cuts = 6
    field = direction_field(cube(cuts), 4)
    defects = field.disclinations
    assert [d.index for d in defects] == [0.25] * 8
    positions = np.array([d.position for d in defects])
    corners = np.rint(positions)
    assert len(np.unique(corners, axis=0)) == 8
    assert np.abs(positions - corners).max() < 1.01 / cuts
    for defect in defects:
        assert np.abs(defect.normal).max() == pytest.approx(1) and defect.kind == "disclination"


@pytest.mark.parametrize("symmetry", [1, 2, 4])
def test_a_sphere_has_as_many_equal_defects_as_it_must(symmetry):
    defects = direction_field(icosphere(3), symmetry).disclinations
    assert [d.index for d in defects] == [1 / symmetry] * (2 * symmetry)


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize("number", [-3, -2, -1, 1, 2, 3])
def test_the_index_is_the_winding_of_the_field(symmetry, number):
    """Angle = number / symmetry times the polar angle around the centre of one triangle of a flat disk."""
    mesh = disk(8, 40)
    home = 200
    x, y, _ = (mesh.vertices - mesh.vertices[mesh.triangles[home]].mean(axis=0)).T
    angles = number / symmetry * np.arctan2(y, x) + 0.3
    field = given_directions(mesh, symmetry, np.column_stack([np.cos(angles), np.sin(angles), 0 * x]))
    # Along one edge the field turns by less than half a turn: larger windings break up around the centre.
    centre = mesh.vertices[mesh.triangles[home]].mean(axis=0)
    assert all(np.linalg.norm(d.position - centre) < 0.3 for d in field.disclinations)
    assert total_index(field.disclinations, symmetry) == pytest.approx(number / symmetry)
    if abs(number) == 1:
        assert [d.triangle for d in field.disclinations] == [home]


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize(("build", "characteristic"), FLAT)
def test_flat_domains_have_constant_fields(build, characteristic, symmetry):
    field = direction_field(build(), symmetry)
    assert field.solution.energy < 1e-12 and field.solution.lower_bound < 1e-12
    powers = (field.vectors[:, 0] + 1j * field.vectors[:, 1]) ** symmetry
    np.testing.assert_allclose(powers, powers[0], atol=1e-6)
    assert field.disclinations == []


def test_crosses_follow_the_sides_of_a_square():
    flat = square(7)
    turn = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))[0]
    mesh = TriangleMesh(flat.vertices @ turn.T, flat.triangles)
    field = direction_field(mesh, 4, on_boundary(mesh))
    assert field.solution.energy < 1e-12
    local = field.vectors @ turn
    np.testing.assert_allclose(((local[:, 0] + 1j * local[:, 1]) ** 4).real, 1, atol=1e-9)


@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_directions_are_unit_and_tangent(build, characteristic):
    mesh = build()
    field = direction_field(mesh, 2)
    used = np.setdiff1d(np.arange(mesh.vertex_count), mesh.loose_vertices)
    np.testing.assert_allclose(np.linalg.norm(field.vectors[used], axis=1), 1, rtol=1e-9)
    np.testing.assert_allclose(np.einsum("ij,ij->i", field.vectors, mesh.vertex_normals), 0, atol=1e-9)
    np.testing.assert_allclose(wrap(2 * field.angles - np.angle(field.solution.phases)), 0, atol=1e-9)


@pytest.mark.parametrize("symmetry", [1, 2, 4])
def test_given_directions_come_back(symmetry):
    mesh = torus()
    random = np.random.default_rng(0)
    vectors = 3 * random.standard_normal((mesh.vertex_count, 3))
    field = given_directions(mesh, symmetry, vectors)
    normals = mesh.vertex_normals
    tangent = vectors - np.einsum("ij,ij->i", vectors, normals)[:, None] * normals
    np.testing.assert_allclose(field.vectors, tangent / np.linalg.norm(tangent, axis=1)[:, None], atol=1e-9)
    assert field.symmetry == symmetry and field.solution is None
    again = given_directions(mesh, symmetry, field.vectors)
    np.testing.assert_allclose(wrap(again.angles - field.angles), 0, atol=1e-9)


def test_turning_a_field_turns_its_vectors_counterclockwise():
    field = direction_field(icosphere(2), 1)
    turned = field.turned(np.pi / 2)
    np.testing.assert_allclose(turned.vectors, np.cross(field.mesh.vertex_normals, field.vectors), atol=1e-9)
    assert [d.triangle for d in turned.disclinations] == [d.triangle for d in field.disclinations]


@pytest.mark.parametrize("bad", [[0, 0, 0], [0, 0, 2.5], [np.nan, 0, 0]])
def test_guidance_without_a_tangential_part_is_refused_by_its_vertex(bad):
    mesh = square(4)
    vectors = np.tile([1.0, 0, 0], (mesh.vertex_count, 1))
    vectors[[7, 11]] = bad
    with pytest.raises(SettingError, match=r"vertex 7 \(2 in all\)") as caught:
        given_directions(mesh, 1, vectors)
    assert "\n" not in str(caught.value) and "give it" in str(caught.value)


def test_loose_vertices_need_no_guidance():
    mesh = together(square(3), loose=2)
    vectors = np.tile([1.0, 0, 0], (mesh.vertex_count, 1))
    vectors[mesh.loose_vertices] = 0
    assert np.isfinite(given_directions(mesh, 1, vectors).angles).all()


@pytest.mark.parametrize("symmetry", [0, 3, 6, "cross"])
def test_unknown_symmetries_are_refused(symmetry):
    with pytest.raises(SettingError, match="symmetry"):
        direction_field(square(2), symmetry)


@pytest.mark.parametrize("symmetry", [1, 2, 4, 6])
def test_triangles_that_bend_much_hold_more_than_one_turn(symmetry):
    """On eight triangles, each with an eighth of the curvature; the sum stays that of topology."""
    mesh, random = octahedron(), np.random.default_rng(symmetry)
    seen = set()
    for _ in range(30):
        powers = np.exp(2j * np.pi * random.random(6))
        numbers = disclination_numbers(mesh, powers, symmetry)
        assert numbers.sum() == 2 * symmetry
        seen |= set(numbers.tolist())
    assert max(seen) >= (2 if symmetry > 2 else 1)
