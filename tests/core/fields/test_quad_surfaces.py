# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes of solved patterns are the surfaces that they were drawn on; those of random phases at least add up."""

from functools import cache

import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.core.extract.quads.measure.quality import quality
from synch_fields.core.extract.quads.trace.quad_mesh import quad_mesh
from synch_fields.core.fields import (
    DirectionWishes,
    Row,
    boundary_line,
    direction_field,
    given_directions,
    quad_pattern,
)

from ..flat_crosses import random_edge_phases
from ..meshes import (
    annulus,
    bent_square,
    bumpy_torus,
    cube,
    cylinder,
    disk,
    double_torus,
    icosphere,
    rounded_cube,
    shared_mesh,
    square,
    torus,
)
from ..topology import edges_of, euler, face_vectors, fans, irregular, is_surface, on_rim, pieces, valences


def size(mesh):
    return np.linalg.norm(np.ptp(mesh.vertices[np.unique(mesh.triangles)], axis=0))


CLOSED = {
    "sphere": lambda: icosphere(3),
    "cube": lambda: cube(8),
    "rounded-cube": rounded_cube,
    "torus": lambda: torus(around=36, across=18),
    "bumpy-torus": lambda: bumpy_torus(16),
    "double-torus": lambda: double_torus(2),
}
BOUNDED = {
    "square": lambda: square(10),
    "bent-square": lambda: bent_square(14),
    "annulus": annulus,
    "cylinder": lambda: cylinder(segments=32, rows=14),
    "disk": lambda: disk(12, 48),
}
MESHES = CLOSED | BOUNDED
CELLS = 7


@cache
def solved(name, cells):
    """The field, the pattern with as many periods in the size of the mesh, and its quads; lines on the boundary."""
    mesh = MESHES[name]()
    rows = [] if name in CLOSED else [Row(boundary_line(mesh), "phase")]
    field = direction_field(mesh, 4, DirectionWishes(rows=tuple(rows)))
    pattern = quad_pattern(mesh, field, size(mesh) / cells, rows)
    return field, pattern, quad_mesh(pattern.edge_phases)


@pytest.mark.parametrize("name", MESHES)
def test_a_solved_pattern_gives_the_surface_that_it_is_on(name):
    field, _, quads = solved(name, CELLS)
    mesh = field.mesh
    assert is_surface(quads)
    assert euler(quads) == mesh.euler_characteristic
    assert on_rim(quads).any() == (name in BOUNDED)
    assert len(np.unique(pieces(quads))) == len(np.unique(mesh.pieces))
    # All faces look outwards and together cover what they should, but for what large flat faces cut off of thin tubes.
    vectors = face_vectors(quads)
    normals = np.zeros((len(quads.sizes), 3))
    np.add.at(normals, quads.corner_faces, mesh.face_normals[quads.triangles[quads.corner_vertices]])
    assert (np.einsum("ij,ij->i", vectors, normals) > 0).mean() > 0.99
    assert np.linalg.norm(vectors, axis=1).sum() == pytest.approx(mesh.areas.sum(), rel=1 / CELLS)


@pytest.mark.parametrize("name", MESHES)
def test_nearly_all_faces_are_quads(name):
    _, pattern, quads = solved(name, CELLS)
    share = (quads.sizes == 4).mean()
    assert share >= (0.9 if name == "double-torus" else 0.95)
    if name not in ("double-torus", "bumpy-torus", "torus", "disk") and pattern.dislocations == []:
        assert share == 1


@pytest.mark.parametrize("name", MESHES)
def test_vertices_and_faces_that_are_irregular_sum_up_to_the_characteristic(name):
    """4 - valence inside, 3 - valence on the rim, 4 - corners of faces: four times the Euler characteristic."""
    field, _, quads = solved(name, CELLS)
    rim = on_rim(quads)
    lacking = np.where(rim, 3, 4) - valences(quads)
    assert lacking.sum() + (4 - quads.sizes).sum() == 4 * field.mesh.euler_characteristic
    figures = quality(quads)
    assert figures["irregular_vertices"] == np.count_nonzero(lacking[~rim])
    assert figures["euler_characteristic"] == field.mesh.euler_characteristic
    assert figures["closed"] == (name in CLOSED)
    assert figures["quad_share"] == pytest.approx((quads.sizes == 4).mean())


@pytest.mark.parametrize("cells", [4, CELLS])
@pytest.mark.parametrize("name", ["sphere", "cube", "rounded-cube"])
def test_every_disclination_is_a_vertex_of_three_edges(name, cells):
    field, pattern, quads = solved(name, cells)
    if pattern.dislocations:
        pytest.skip("dislocations have irregular vertices of their own")
    degrees = valences(quads)
    assert [d.index for d in field.disclinations] == [0.25] * 8
    assert (quads.sizes == 4).all() and np.bincount(degrees).tolist() == [0, 0, 0, 8, len(degrees) - 8]
    # Each near its own, within about a cell.
    irregular_at = quads.vertices[degrees == 3]
    places = np.array([d.position for d in field.disclinations])
    distances = np.linalg.norm(irregular_at[:, None] - places, axis=2)
    assert distances.min(axis=1).max() < 1.5 * size(field.mesh) / cells / 2
    assert len(np.unique(distances.argmin(axis=1))) == 8


@pytest.mark.parametrize("cells", [4, 5])
def test_disclinations_of_both_signs_are_vertices_of_three_and_five_edges(cells):
    field, pattern, quads = solved("torus", cells)
    assert pattern.dislocations == []
    indices = [d.index for d in field.disclinations]
    assert indices.count(0.25) == indices.count(-0.25) == len(indices) // 2 > 0
    of_vertices, of_faces = irregular(quads)
    assert len(of_faces) == 0
    assert sorted(of_vertices) == sorted(4 * np.array(indices))


@pytest.mark.parametrize("name", BOUNDED)
def test_no_slivers_lie_along_a_boundary_that_is_a_line(name):
    field, _, quads = solved(name, CELLS)
    areas = np.linalg.norm(face_vectors(quads), axis=1)
    rim = on_rim(quads)
    touching = np.bincount(quads.corner_faces, rim[quads.corner_vertices]) > 0
    assert areas[touching].min() > 0.4 * np.median(areas)
    if name != "disk":
        assert (quads.sizes == 4).all()
    # Places on the rim are places on the boundary.
    in_mesh = np.sort(quads.weights[rim], axis=1)
    assert in_mesh[:, 0].max() < 1e-12
    edges = field.mesh.triangle_edges[quads.triangles[rim], (quads.weights[rim].argmin(axis=1) + 1) % 3]
    on_vertices = in_mesh[:, 2] > 1 - 1e-6
    assert np.isin(edges, field.mesh.boundary_edges)[~on_vertices].all()


@pytest.mark.parametrize(("name", "cells"), [("spot", 12), pytest.param("fandisk", 12, marks=pytest.mark.slow)])
def test_a_real_mesh_becomes_quads(name, cells):
    mesh = shared_mesh(name)
    pattern = quad_pattern(mesh, direction_field(mesh, 4), np.ptp(mesh.vertices, axis=0).max() / cells)
    quads = quad_mesh(pattern.edge_phases)
    assert is_surface(quads) and euler(quads) == mesh.euler_characteristic
    assert (quads.sizes == 4).mean() > 0.95 and not on_rim(quads).any()


# Random phases


@cache
def smooth_field(name):
    return direction_field(MESHES[name](), 4)


def at_random(name, smooth, seed, cells=10):
    field = smooth_field(name)
    mesh = field.mesh
    if not smooth:
        field = given_directions(mesh, 4, np.random.default_rng(seed).standard_normal((mesh.vertex_count, 3)))
    return mesh, random_edge_phases(mesh, field, size(mesh) / cells, seed)


GENUS = {"torus": 1, "bumpy-torus": 1, "double-torus": 2}


@pytest.mark.parametrize("smooth", [True, False])
@pytest.mark.parametrize("name", CLOSED)
def test_random_phases_on_closed_surfaces_give_closed_meshes(name, smooth):
    """Full of dislocations: what is left of the lines may fall apart, but has no rim and no handle of its own."""
    _, edge_phases = at_random(name, smooth, 0)
    quads = quad_mesh(edge_phases)
    _, forward, backward = edges_of(quads)
    loops = edges_of(quads)[0][:, 0] == edges_of(quads)[0][:, 1]
    np.testing.assert_array_equal(forward[~loops], backward[~loops])
    assert quads.sizes.min(initial=3) >= 3
    handles = 0
    for piece in np.unique(pieces(quads)) if len(quads.vertices) else []:
        nodes = pieces(quads) == piece
        corners = nodes[quads.corner_vertices]
        faces = len(np.unique(quads.corner_faces[corners]))
        lacks = 2 - (nodes.sum() - corners.sum() // 2 + faces)
        assert lacks >= 0 and lacks % 2 == 0
        handles += lacks // 2
    assert handles <= GENUS.get(name, 0)
    if forward.max(initial=0) == 1 and not loops.any():
        assert (fans(quads) == 1).all()


@pytest.mark.parametrize("smooth", [True, False])
@pytest.mark.parametrize("name", BOUNDED)
def test_random_phases_on_bounded_surfaces_keep_to_the_boundary(name, smooth):
    """The rim is made of closed walks with the surface on their left, from place to place on the boundary."""
    mesh, edge_phases = at_random(name, smooth, 0)
    quads = quad_mesh(edge_phases)
    assert len(quads.sizes) > 0 and quads.sizes.min() >= 3
    pairs, forward, backward = edges_of(quads)
    odd = (forward != backward) & (pairs[:, 0] != pairs[:, 1])
    net = np.zeros(len(quads.vertices), int)
    np.add.at(net, pairs[:, 0], forward - backward)
    np.add.at(net, pairs[:, 1], backward - forward)
    assert not net.any() and odd.any()
    rim = on_rim(quads)
    in_mesh = np.sort(quads.weights[rim], axis=1)
    assert in_mesh[:, 0].max() < 1e-12
    edges = mesh.triangle_edges[quads.triangles[rim], (quads.weights[rim].argmin(axis=1) + 1) % 3]
    assert np.isin(edges, mesh.boundary_edges)[in_mesh[:, 2] < 1 - 1e-6].all()


@pytest.mark.parametrize("name", MESHES)
def test_random_phases_that_hardly_leave_a_line_do_no_harm(name):
    """Lines so far apart that hardly any closes: an empty mesh or an error of our own, no crash."""
    for seed in range(2):
        for cells in (0.5, 2):
            _, edge_phases = at_random(name, True, seed, cells)
            try:
                quads = quad_mesh(edge_phases)
            except SynchError:
                continue
            assert len(quads.corner_vertices) == quads.sizes.sum()
            assert len(quads.vertices) == len(np.unique(quads.corner_vertices))
