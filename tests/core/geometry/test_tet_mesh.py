# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids: connectivity, boundary, volumes and weights against closed forms and assembly by hand."""

from collections import defaultdict
from itertools import combinations

import numpy as np
import pytest

from synch_fields.core.errors import MeshError
from synch_fields.core.geometry import check_mesh
from synch_fields.core.geometry.tet_mesh import SHARPEST_ANGLE, TET_EDGES, TetMesh, positive

from ..solids import (
    SOLIDS,
    ball,
    block,
    dihedral_angles,
    enclosed_volume,
    frame,
    jittered,
    notched,
    renumbered,
    shell,
    together,
)

every_solid = pytest.mark.parametrize(("build", "volume", "chi"), SOLIDS)


@every_solid
def test_edges_and_faces_are_those_of_a_dictionary(build, volume, chi):
    mesh = build()
    edges, faces = set(), defaultdict(list)
    for t, tet in enumerate(mesh.tets.tolist()):
        edges |= {tuple(sorted(pair)) for pair in combinations(tet, 2)}
        for face in combinations(tet, 3):
            faces[tuple(sorted(face))].append(t)
    assert [tuple(e) for e in mesh.edges.tolist()] == sorted(edges)
    assert [tuple(f) for f in mesh.faces.tolist()] == sorted(faces)
    assert mesh.face_tets.tolist() == [(faces[f] + [-1])[:2] for f in sorted(faces)]
    assert mesh.boundary_faces.tolist() == [k for k, f in enumerate(sorted(faces)) if len(faces[f]) == 1]


@every_solid
def test_tets_know_their_edges_and_faces(build, volume, chi):
    mesh = build()
    pairs = mesh.tets[:, TET_EDGES]
    np.testing.assert_array_equal(mesh.edges[mesh.tet_edges], np.sort(pairs, axis=2))
    np.testing.assert_array_equal(mesh.edges_between(pairs[..., 1], pairs[..., 0]), mesh.tet_edges)
    for k in range(4):
        opposite = np.sort(np.delete(mesh.tets, k, axis=1), axis=1)
        np.testing.assert_array_equal(mesh.faces[mesh.tet_faces[:, k]], opposite)
        assert (mesh.face_tets[mesh.tet_faces[:, k]] == np.arange(mesh.tet_count)[:, None]).any(axis=1).all()


@every_solid
def test_euler_characteristic_of_solid_and_boundary(build, volume, chi):
    mesh = build()
    vertices = mesh.vertex_count - len(mesh.loose_vertices)
    assert vertices - len(mesh.edges) + len(mesh.faces) - mesh.tet_count == chi
    assert mesh.boundary_surface[0].euler_characteristic == 2 * chi


@every_solid
def test_boundary_is_a_closed_surface_with_its_faces_outwards(build, volume, chi):
    mesh = build()
    surface, source = mesh.boundary_surface
    check_mesh(surface)
    assert len(surface.boundary_edges) == 0
    assert enclosed_volume(surface) == pytest.approx(mesh.volumes.sum(), rel=1e-12)
    np.testing.assert_array_equal(surface.vertices, mesh.vertices[source])
    np.testing.assert_array_equal(source[surface.triangles], mesh.boundary_triangles)
    np.testing.assert_array_equal(np.sort(mesh.boundary_triangles, axis=1), mesh.faces[mesh.boundary_faces])
    np.testing.assert_array_equal(np.unique(source), np.flatnonzero(mesh.boundary_vertices))


@every_solid
def test_volumes_and_masses_add_up(build, volume, chi):
    mesh = build()
    if volume is not None:
        assert mesh.volumes.sum() == pytest.approx(volume, rel=1e-12)
    there = np.setdiff1d(np.arange(mesh.vertex_count), mesh.loose_vertices)
    assert mesh.vertex_masses[there].sum() == pytest.approx(mesh.volumes.sum(), rel=1e-12)
    assert mesh.vertex_masses.min() > 0


def test_a_ball_has_nearly_the_volume_of_a_ball():
    exact = 4 / 3 * np.pi
    errors = [1 - ball(k, 2).volumes.sum() / exact for k in (2, 3)]
    assert 0 < errors[1] < 0.02
    assert errors[0] / errors[1] == pytest.approx(4, abs=0.2)


def test_inner_vertices_of_a_block_have_the_mass_of_a_cell():
    mesh = block((4, 5, 6), lengths=(2.0, 1.0, 3.0))
    np.testing.assert_allclose(mesh.vertex_masses[~mesh.boundary_vertices], 6 / (4 * 5 * 6))
    corner = np.flatnonzero((mesh.vertices == 0).all(axis=1))
    # All six tetrahedra of the first cell meet in its corner.
    np.testing.assert_allclose(mesh.vertex_masses[corner], 6 / (4 * 5 * 6) / 4)


@every_solid
def test_hat_functions_are_one_at_their_corner(build, volume, chi):
    mesh = build()
    corners = mesh.vertices[mesh.tets]
    for k in range(4):
        rise = np.einsum("tkx,tx->tk", corners - corners[:, k, None], mesh.hat_gradients[:, k])
        np.testing.assert_allclose(rise, np.eye(4)[k] - 1 + np.zeros_like(rise), atol=1e-10)


def laplacian(mesh, weights):
    i, j = mesh.edges.T
    matrix = np.zeros((mesh.vertex_count, mesh.vertex_count))
    matrix[i, j] = matrix[j, i] = -weights
    return matrix - np.diag(matrix.sum(axis=1))


@every_solid
def test_cotangent_weights_are_the_stiffness_of_linear_elements(build, volume, chi):
    mesh = build()
    stiffness = np.zeros((mesh.vertex_count, mesh.vertex_count))
    for tet in mesh.tets:
        # Rows: the coefficients of 1, x, y, z of each hat function.
        values = np.column_stack([np.ones(4), mesh.vertices[tet]])
        gradients = np.linalg.inv(values)[1:].T
        stiffness[np.ix_(tet, tet)] += abs(np.linalg.det(values)) / 6 * gradients @ gradients.T
    np.testing.assert_allclose(laplacian(mesh, mesh.cotangent_weights), stiffness, atol=1e-10)


@every_solid
def test_weights_are_positive_and_change_no_edge_without_need(build, volume, chi):
    mesh = build()
    assert (mesh.weights > 0).all()
    assert dihedral_angles(mesh).min() > np.degrees(SHARPEST_ANGLE)
    kept = mesh.cotangent_weights > 1e-3 * mesh.weights.max()
    assert kept.sum() > 0.3 * len(mesh.edges)
    np.testing.assert_allclose(mesh.weights[kept], mesh.cotangent_weights[kept], rtol=1e-12)
    assert mesh.weights[~kept].max() < 2e-3 * mesh.weights.max()


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e5])
def test_weights_grow_with_the_size_of_the_solid(scale):
    mesh = jittered(ball())
    np.testing.assert_allclose(
        TetMesh(scale * mesh.vertices, mesh.tets).weights, scale * mesh.weights, rtol=1e-6, atol=0
    )


def test_a_sliver_does_not_outweigh_the_mesh():
    """Four corners of a square, one of them lifted a little: large weights of either sign."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 1e-6], [0, 1, 0]], float)
    mesh = TetMesh(square, positive(square, [[0, 1, 2, 3]]))
    assert np.abs(mesh.cotangent_weights).max() > 1e4
    limit = 1 / np.tan(SHARPEST_ANGLE) * np.sqrt(2) / 6
    assert 0 < mesh.weights.min() < mesh.weights.max() <= limit * (1 + 1e-9)


def test_pieces_and_loose_vertices():
    mesh = together(block((2, 2, 2)), frame(), shell(subdivisions=1), loose=2)
    labels = mesh.pieces
    expected = np.repeat([0, 1, 2], [27, frame().vertex_count, shell(subdivisions=1).vertex_count])
    assert len(np.unique(labels)) == 5
    assert len(np.unique(np.column_stack([labels[:-2], expected]), axis=0)) == 3
    assert mesh.loose_vertices.tolist() == [mesh.vertex_count - 2, mesh.vertex_count - 1]


def test_numbering_does_not_matter():
    mesh = jittered(block())
    other = renumbered(mesh)
    for name in ("volumes", "weights", "vertex_masses", "edge_lengths"):
        np.testing.assert_allclose(np.sort(getattr(other, name)), np.sort(getattr(mesh, name)), rtol=1e-9)


def test_a_vertex_that_the_outside_reaches_twice_stands_twice_in_the_surface():
    mesh = notched()
    surface, source = mesh.boundary_surface
    middle = np.flatnonzero((mesh.vertices == 1).all(axis=1))[0]
    assert (source == middle).sum() == 2
    assert len(source) == mesh.boundary_vertices.sum() + 1
    check_mesh(surface)
    assert surface.euler_characteristic == 2
    assert enclosed_volume(surface) == pytest.approx(6)


CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [0, 0, -1]], float)


@pytest.mark.parametrize(
    ("tets", "words", "vertices"),
    [
        ([[0, 1, 2, 3], [0, 1, 2, 5]], "tetrahedron 1 has its corners in the wrong order: swap two", [0, 1, 2, 5]),
        ([[0, 1, 2, 3], [0, 3, 5, 3], [0, 5, 3, 3]], "tetrahedra 1, 2 have no volume", [0, 3, 5]),
        ([[0, 1, 2, 6]], r"tetrahedron 0 has the vertices \[0, 1, 2, 6\] and there are 6: count them from 0", []),
        ([[0, 1, -1, 3]], "tetrahedron 0 has the vertices", []),
        ([[0, 1, 2]], r"shape \(1, 3\) where \(n, 4\)", []),
        ([], "no tetrahedra", []),
    ],
)
def test_broken_tetrahedra_are_refused_by_name(tets, words, vertices):
    with pytest.raises(MeshError, match=words) as caught:
        TetMesh(CORNERS, tets)
    assert "\n" not in str(caught.value)
    assert caught.value.vertices.tolist() == vertices


def test_a_vertex_at_no_place_is_refused_by_name():
    vertices = CORNERS.copy()
    vertices[2, 1] = np.nan
    with pytest.raises(MeshError, match="vertex 2 has no finite position") as caught:
        TetMesh(vertices, [[0, 1, 3, 4]])
    assert caught.value.vertices.tolist() == [2]


@pytest.mark.parametrize(
    ("tets", "words"),
    [
        ([[0, 1, 2, 3], [0, 1, 2, 4]], "vertices 0, 1, 2 has two on the same side tetrahedra"),
        ([[0, 1, 2, 3], [0, 2, 1, 5], [0, 1, 2, 4]], "vertices 0, 1, 2 has more than two tetrahedra"),
    ],
)
def test_overlapping_tetrahedra_are_refused_by_name(tets, words):
    mesh = TetMesh(CORNERS, tets)
    with pytest.raises(MeshError, match=words) as caught:
        mesh.faces  # noqa: B018
    assert caught.value.vertices.tolist() == [0, 1, 2]


def test_positive_turns_the_inverted_ones_only():
    mesh = jittered(block())
    mixed = mesh.tets.copy()
    mixed[::3] = mixed[::3][:, [1, 0, 2, 3]]
    turned = TetMesh(mesh.vertices, positive(mesh.vertices, mixed))
    np.testing.assert_allclose(turned.volumes, mesh.volumes)
    untouched = np.arange(mesh.tet_count) % 3 != 0
    np.testing.assert_array_equal(turned.tets[untouched], mesh.tets[untouched])
