# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rescaled tangent planes: angles around vertices, parallel transport and the Gauss-Bonnet theorem."""

import numpy as np
import pytest

from synch_fields.core.connection import levi_civita
from synch_fields.core.defects import wrap
from synch_fields.core.geometry import TriangleMesh

from ..meshes import BOUNDED, CLOSED, EVERY, FLAT, cylinder, icosphere


def rotation(seed):
    """A random proper rotation."""
    q, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    return q * np.sign(np.linalg.det(q))


def directed(mesh):
    """Angle of every half-edge at its tail, from the two angles of its edge."""
    forward = mesh.triangle_edge_signs.ravel() > 0
    return np.where(forward, *mesh.edge_directions[mesh.triangle_edges.ravel()].T).reshape(-1, 3)


@pytest.mark.parametrize(("build", "characteristic"), CLOSED)
def test_curvatures_sum_to_two_pi_chi(build, characteristic):
    mesh = build()
    assert mesh.face_curvatures.sum() == pytest.approx(2 * np.pi * characteristic, abs=1e-9)


@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_angles_around_interior_vertices_make_a_full_turn(build, characteristic):
    mesh = build()
    sums = np.zeros(mesh.vertex_count)
    np.add.at(sums, mesh.triangles, mesh.scaled_angles)
    inside = ~mesh.boundary_vertices
    inside[mesh.loose_vertices] = False
    np.testing.assert_allclose(sums[inside], 2 * np.pi, rtol=1e-12)
    rim = mesh.boundary_vertices[mesh.triangles]
    np.testing.assert_array_equal(mesh.scaled_angles[rim], mesh.corner_angles[rim])


@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_the_next_edge_around_a_vertex_lies_one_corner_further(build, characteristic):
    mesh = build()
    along = directed(mesh)
    # Edge towards the previous corner: the reverse of the half-edge that comes from there.
    forward = mesh.triangle_edge_signs[:, [2, 0, 1]] > 0
    both = mesh.edge_directions[mesh.triangle_edges[:, [2, 0, 1]]]
    back = np.where(forward, both[..., 1], both[..., 0])
    np.testing.assert_allclose(wrap(back - along - mesh.scaled_angles), 0, atol=1e-9)


@pytest.mark.parametrize(("build", "characteristic"), [p for p in EVERY if p.id != "slivers"])
def test_frames_show_the_edges_at_their_angles(build, characteristic):
    """Exactly in the plane; on curved surfaces rescaled angles cannot be those of the projected edges."""
    mesh = build()
    x, y = mesh.tangent_frames
    used = np.setdiff1d(np.arange(mesh.vertex_count), mesh.loose_vertices)
    np.testing.assert_allclose(np.cross(x, y)[used], mesh.vertex_normals[used], atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(x[used], axis=1), 1, rtol=1e-12)
    for end, sign in ((0, 1), (1, -1)):
        vertex = mesh.edges[:, end]
        towards = sign * mesh.edge_vectors
        seen = np.arctan2(np.einsum("ij,ij->i", towards, y[vertex]), np.einsum("ij,ij->i", towards, x[vertex]))
        misses = np.abs(wrap(seen - mesh.edge_directions[:, end]))
        flat = np.ptp(mesh.vertices[used, 2]) < 1e-12
        assert misses.max() < (1e-9 if flat else 1.0) and misses.mean() < 0.12


@pytest.mark.parametrize(("build", "characteristic"), FLAT)
@pytest.mark.parametrize("symmetry", [1, 2, 4])
def test_transport_in_a_plane_leaves_vectors_as_they_are(build, characteristic, symmetry):
    flat = build()
    mesh = TriangleMesh(flat.vertices @ rotation(3).T, flat.triangles)
    vector = (mesh.vertices[1] - mesh.vertices[0]) + 0.3 * (mesh.vertices[5] - mesh.vertices[0])
    x, y = mesh.tangent_frames
    angles = np.arctan2(y @ vector, x @ vector)
    i, j = mesh.edges.T
    moved = symmetry * angles[i] + levi_civita(mesh, symmetry)
    np.testing.assert_allclose(wrap(moved - symmetry * angles[j]), 0, atol=1e-9)


def test_transport_on_a_cylinder_is_that_of_the_unrolled_strip():
    mesh = cylinder(radius=1.3, segments=17, rows=6)
    angle = np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0])
    around = np.column_stack([-np.sin(angle), np.cos(angle), np.zeros_like(angle)])
    x, y = mesh.tangent_frames
    upright = np.arctan2(y[:, 2], x[:, 2])
    level = np.arctan2(np.einsum("ij,ij->i", y, around), np.einsum("ij,ij->i", x, around))
    i, j = mesh.edges.T
    inside = ~mesh.boundary_vertices[i] & ~mesh.boundary_vertices[j]
    for angles in (upright, level):
        # The kinks of the polygonal tube cost a little where frames are projected, nothing on average.
        turn = wrap(angles[i] + levi_civita(mesh, 1) - angles[j])[inside]
        assert np.abs(turn).max() < 0.03 and abs(turn.mean()) < 5e-3


def test_transport_around_a_spherical_triangle_turns_by_its_area():
    mesh = icosphere(3)
    turn = (mesh.triangle_edge_signs * levi_civita(mesh, 1)[mesh.triangle_edges]).sum(axis=1)
    np.testing.assert_allclose(wrap(turn), mesh.areas, rtol=0.15)
    assert wrap(turn).sum() == pytest.approx(4 * np.pi, abs=1e-9)


@pytest.mark.parametrize(("build", "characteristic"), CLOSED + BOUNDED)
def test_holonomy_of_a_triangle_is_its_curvature(build, characteristic):
    mesh = build()
    for symmetry in (1, 2, 4):
        turn = (mesh.triangle_edge_signs * levi_civita(mesh, symmetry)[mesh.triangle_edges]).sum(axis=1)
        np.testing.assert_allclose(wrap(turn - symmetry * mesh.face_curvatures), 0, atol=1e-9)
