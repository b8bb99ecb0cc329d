# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fine meshes keep the spacing that their edges carry; coarse ones get one by their area, and short edges for it."""

import numpy as np
import pytest

from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.mesh_input import ObjectMesh
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.refinement import refine
from synch_fields.core.refinement.spacing import (
    EDGE_SHARE,
    QUADS,
    automatic_spacing,
    finer_copy,
    longest_edge,
    wished_spacing,
)
from synch_fields.core.settings.surface import SurfaceSettings

from ..meshes import icosphere


def refined(mesh, longest):
    read = ObjectMesh("mesh", mesh.vertices, Polygons.of_triangles(mesh), np.eye(3))
    bound = refine(read, mesh.edges, longest)
    return TriangleMesh(bound.vertices, bound.corner_vertices.reshape(-1, 3))


@pytest.mark.parametrize("per_period", [1, 2])
def test_fine_meshes_have_four_edges_to_a_period(per_period):
    mesh = icosphere(3)
    median, long = np.quantile(mesh.edge_lengths, [0.5, 0.95])
    assert automatic_spacing(mesh, per_period) == max(per_period * 2 / 40, 4 * median, 2 * long)
    assert longest_edge(mesh, automatic_spacing(mesh, per_period)) is None


@pytest.mark.parametrize("per_period", [1, 2])
def test_coarse_meshes_have_as_many_quads_as_their_area_has_room_for(per_period):
    mesh = icosphere(0)
    spacing = automatic_spacing(mesh, per_period)
    assert mesh.areas.sum() / (spacing / per_period) ** 2 == pytest.approx(QUADS)
    assert spacing == wished_spacing(mesh.areas.sum(), per_period)


def test_a_finer_copy_is_fine_and_has_the_same_wished_spacing():
    mesh = icosphere(0)
    spacing = automatic_spacing(mesh, 2)
    finer = refined(mesh, longest_edge(mesh, spacing))
    assert longest_edge(finer, spacing) is None
    assert finer.edge_lengths.max() < EDGE_SHARE * spacing
    assert wished_spacing(finer.areas.sum(), 2) == pytest.approx(spacing)


def test_a_few_large_faces_among_many_small_ones_are_too_coarse():
    """As of CAD parts with rounded edges: hardly any edge is long, and most of the area has one."""
    fine, far = icosphere(4), [[10, 0, 0], [18, 0, 0], [10, 8, 0]]
    both = TriangleMesh(
        np.concatenate([fine.vertices, far]),
        np.concatenate([fine.triangles, [[fine.vertex_count + k for k in range(3)]]]),
    )
    assert longest_edge(fine, 0.4) is None
    assert longest_edge(both, 0.4) == pytest.approx(0.9 * 0.2)


def test_only_where_the_spacing_is_small_edges_have_to_be_short():
    mesh = icosphere(3)
    spacings = np.where(mesh.vertices[:, 2] > 0.995, 0.01, 1.0)
    assert longest_edge(mesh, spacings) is None
    assert longest_edge(mesh, np.full(mesh.vertex_count, 0.01)) is not None


def test_directions_need_no_short_edges():
    """A spacing makes the finer copy of stripes finer, and leaves that of directions as it is."""
    mesh = icosphere(1)
    read = ObjectMesh("mesh", mesh.vertices, Polygons.of_triangles(mesh), np.eye(3))
    given, settings = read.surface(), SurfaceSettings(spacing=0.4)
    directions, stripes = (
        finer_copy(command, read, mesh.edges, given, settings) for command in ("directions", "stripes")
    )
    assert len(directions.vertices) == mesh.vertex_count < len(stripes.vertices)
