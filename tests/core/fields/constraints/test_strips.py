# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Strips between lines that are narrower than a quad."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.fields import given_directions
from synch_fields.core.fields.constraints.features import feature_edges, feature_row
from synch_fields.core.fields.constraints.strips import ACROSS, find_strips, strip_stretch
from synch_fields.core.fields.target_one_form import TargetOneForm

from ...meshes import cylinder, square
from ...sharp_shapes import ANGLE, chamfered_cube


@pytest.mark.parametrize("share", [0.02, 0.1, 0.4, 0.8])
def test_chamfers_are_strips_and_nothing_else_is(share):
    """Widths, and the directions across, of strips between parallel straight lines."""
    side = 0.1
    cut = share * side / np.sqrt(2)
    mesh = chamfered_cube(16, cut)
    edges = feature_edges(mesh, ANGLE, 1e-3)
    across, factors = find_strips(mesh, edges, np.full(mesh.vertex_count, side))
    normals = np.abs(mesh.face_normals)
    chamfer = (np.sort(normals, axis=1)[:, 0] < 1e-9) & (normals.max(axis=1) < 0.9)
    middle = mesh.vertices[mesh.triangles].mean(axis=1)
    # Where other chamfers are farther away than this one is wide.
    inner = chamfer & (np.sort(np.abs(middle), axis=1)[:, 0] < 0.5 - cut - ACROSS * side)
    np.testing.assert_allclose(factors[inner], ACROSS / share, rtol=1e-6)
    np.testing.assert_allclose(np.abs(np.einsum("mx,mx->m", across[inner], mesh.face_normals[inner])), 0, atol=1e-9)
    along = np.argmin(normals[inner], axis=1)
    assert np.abs(across[inner][np.arange(len(along)), along]).max() < 1e-9
    assert (factors[~chamfer & (normals.max(axis=1) > 0.9)] == 1).all()


def test_what_is_wider_than_the_quads_that_are_asked_for_is_no_strip():
    mesh = cylinder(1.0, 0.5, 48, 6)
    edges = mesh.boundary_edges
    assert (find_strips(mesh, edges, np.full(mesh.vertex_count, 0.5 / ACROSS - 1e-3))[1] == 1).all()
    assert (find_strips(mesh, edges, np.full(mesh.vertex_count, 0.5))[1] > 1.2).all()


def test_phases_grow_as_much_across_a_strip_as_quads_are_asked_for_and_as_before_along_it():
    """Between the ends of a flat strip; sums of changes along straight ways."""
    width, side = 0.3, 0.5
    mesh = square(40, 6, 4.0, width)
    field = given_directions(mesh, 4, np.tile([1.0, 0, 0], (mesh.vertex_count, 1)))
    growth = TargetOneForm.of(mesh, field, 2 * side)
    rows = (feature_row(mesh, mesh.boundary_edges),)
    wide = replace(growth, stretch=strip_stretch(growth, rows))
    steps = mesh.edge_vectors
    inside = (np.abs(mesh.vertices[mesh.edges, 0] - 2).max(axis=1) < 1) & (np.abs(steps[:, 2]) < 1e-12)
    rise = np.abs(wide.changes[inside] / np.pi)
    steps = np.abs(steps[inside])
    for phase in range(2):
        along = np.isclose(rise[:, phase], steps[:, 0] / side, atol=1e-9)
        across = np.isclose(rise[:, phase], ACROSS * steps[:, 1] / width, atol=1e-9)
        assert (along | across).all() and not (along & across)[steps.min(axis=1) > 0].any()
    assert not np.allclose(wide.changes, growth.changes)
    assert strip_stretch(growth, ()) == 1
