# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces cut open along edges: counts in closed form, and nothing carried across."""

import numpy as np
import pytest

from synch_fields.core.fields import DirectionWishes, Row, direction_field, line_of_edges
from synch_fields.core.geometry import check_mesh
from synch_fields.core.geometry.cut import cut_open, edges_after_cut

from ..meshes import annulus, cube, icosphere, slivers, square, torus


def edges_between(mesh, vertices):
    """Edges with both ends in a mask."""
    return np.flatnonzero(vertices[mesh.edges].all(axis=1))


def test_a_square_cut_across_falls_into_two():
    mesh = square(8)
    middle = edges_between(mesh, mesh.vertices[:, 0] == 0.5)
    cut, source = cut_open(mesh, middle)
    assert cut.vertex_count == mesh.vertex_count + 9
    assert len(np.unique(cut.pieces)) == 2
    np.testing.assert_array_equal(source[cut.triangles], mesh.triangles)
    np.testing.assert_array_equal(source[: mesh.vertex_count], np.arange(mesh.vertex_count))
    assert len(edges_after_cut(mesh, cut, middle)) == 2 * len(middle)
    check_mesh(cut, np.arange(cut.triangle_count))


def test_a_slit_inside_opens_all_but_its_ends():
    mesh = square(8)
    x, y, _ = mesh.vertices.T
    slit = edges_between(mesh, (x == 0.5) & (y > 0.2) & (y < 0.8))
    cut, _ = cut_open(mesh, slit)
    assert cut.vertex_count == mesh.vertex_count + len(slit) - 1
    assert cut.euler_characteristic == mesh.euler_characteristic - 1  # a slit is a hole
    assert len(cut.boundary_edges) == len(mesh.boundary_edges) + 2 * len(slit)


@pytest.mark.parametrize(
    "mesh", [icosphere(2), torus(), cube(), annulus(), slivers()], ids=lambda m: str(m.vertex_count)
)
def test_all_edges_cut_leave_single_triangles(mesh):
    cut, source = cut_open(mesh, np.arange(len(mesh.edges)))
    used = np.unique(cut.triangles)
    assert len(used) == 3 * mesh.triangle_count
    np.testing.assert_array_equal(source[cut.triangles], mesh.triangles)


@pytest.mark.parametrize("mesh", [icosphere(2), torus(), annulus()], ids=lambda m: str(m.vertex_count))
def test_nothing_cut_changes_nothing(mesh):
    cut, source = cut_open(mesh, mesh.boundary_edges)
    np.testing.assert_array_equal(cut.triangles, mesh.triangles)
    np.testing.assert_array_equal(source, np.arange(mesh.vertex_count))


def test_directions_differ_across_a_cut():
    mesh = square(8)
    x = mesh.vertices[:, 0]
    cut, _ = cut_open(mesh, edges_between(mesh, x == 0.5))
    left = np.flatnonzero(cut.vertices[cut.edges][:, :, 0].max(axis=1) == 0)
    top = np.flatnonzero(
        (cut.vertices[cut.edges][:, :, 1].min(axis=1) == 1) & (cut.vertices[cut.edges][:, :, 0].max(axis=1) > 0.5)
    )
    rows = (Row(line_of_edges(cut, left), "along"), Row(line_of_edges(cut, top), "along"))
    field = direction_field(cut, 2, DirectionWishes(rows=rows))
    assert field.solution.energy < 1e-12
    on_left = cut.pieces == cut.pieces[cut.edges[left[0], 0]]
    np.testing.assert_allclose(np.abs(field.vectors[on_left, 1]), 1, atol=1e-9)
    np.testing.assert_allclose(np.abs(field.vectors[~on_left, 0]), 1, atol=1e-9)
