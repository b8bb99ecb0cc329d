# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes around the handles of solids: as many as linear algebra finds, without curl, and no function's."""

import numpy as np
import pytest

from synch_fields.core.geometry.handles import handle_changes, triangle_sums
from synch_fields.core.geometry.tet_mesh import TetMesh

from ..solids import block, frame, grid_tets, shell, together

SOLIDS = [
    pytest.param(block, 0, id="block"),
    pytest.param(lambda: shell(subdivisions=0, layers=2), 0, id="shell"),
    pytest.param(frame, 1, id="frame"),
    pytest.param(lambda: TetMesh(*grid_tets((5, 3, 1), lambda i, j, k: (i, j) not in ((1, 1), (3, 1)))), 2, id="two"),
    pytest.param(lambda: together(frame(), block(), frame(), loose=2), 2, id="pieces"),
]


@pytest.mark.parametrize(("build", "count"), SOLIDS)
def test_there_is_one_for_each_handle_and_no_function_has_it(build, count):
    mesh = build()
    found = handle_changes(mesh, np.zeros(len(mesh.edges), bool))
    assert found.shape == (len(mesh.edges), count)
    assert np.abs(triangle_sums(mesh) @ found).max(initial=0) < 1e-12
    assert np.linalg.matrix_rank(np.column_stack([found, differences(mesh)])) == count + np.linalg.matrix_rank(
        differences(mesh)
    )
    # Against linear algebra: all changes without curl, less those of functions.
    closed = len(mesh.edges) - np.linalg.matrix_rank(triangle_sums(mesh).toarray())
    assert closed - np.linalg.matrix_rank(differences(mesh)) == count


@pytest.mark.parametrize(("build", "count"), SOLIDS)
def test_nothing_goes_around_a_handle_whose_surface_rests(build, count):
    mesh = build()
    resting = mesh.boundary_vertices[mesh.edges].all(axis=1)
    found = handle_changes(mesh, resting)
    assert found.shape == (len(mesh.edges), 0)


def test_half_a_ring_that_rests_leaves_the_handle():
    mesh = frame()
    resting = (mesh.vertices[:, 0] < 1.5)[mesh.edges].all(axis=1)
    found = handle_changes(mesh, resting)
    assert found.shape[1] == 1 and not found[resting].any()
    assert np.abs(triangle_sums(mesh) @ found).max() < 1e-12


def differences(mesh):
    """(e, n) dense: the changes of a function."""
    matrix = np.zeros((len(mesh.edges), mesh.vertex_count))
    edges = np.arange(len(mesh.edges))
    matrix[edges, mesh.edges[:, 1]], matrix[edges, mesh.edges[:, 0]] = 1, -1
    return matrix
