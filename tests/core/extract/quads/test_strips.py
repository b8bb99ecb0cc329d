# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Strips of quads are added to grids and tori and removed from them, where the possible numbers of faces are known."""

import numpy as np
import pytest

from synch_fields.core.extract.quads.finishing import finish_quads
from synch_fields.core.extract.quads.repair.strips import may_meet
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh, quad_mesh
from synch_fields.core.fields.constraints.features import feature_row
from synch_fields.core.geometry.barycentric import barycentric

from ...flat_crosses import plane_edge_phases
from ...meshes import grid_quads, square, torus
from ...topology import edges_of, euler, on_rim, valences

CELLS = 10
PLANE = square(20)
RING = torus(around=96, across=48)


def grid():
    return quad_mesh(plane_edge_phases(PLANE, 0, 2 / CELLS))


def boundary_row(mesh):
    return feature_row(mesh, np.flatnonzero(mesh.edge_face_counts == 1))


def ring(around, across):
    """Quads of a torus."""
    places, triangles = RING.finder.nearest(torus(around=around, across=across).vertices)
    faces = grid_quads(around, across, wrap_columns=True, wrap_rows=True)
    return QuadMesh(places, triangles, barycentric(RING, triangles, places), faces.ravel(), np.full(len(faces), 4))


def signed_areas(quads):
    a, b, c, d = quads.vertices[quads.corner_vertices.reshape(-1, 4)].swapaxes(0, 1)
    return np.cross(c - a, d - b)[:, 2] / 2


@pytest.mark.parametrize("rounds", [0, 20])
@pytest.mark.parametrize(("wanted", "count"), [(98, 100), (104, 100), (110, 110), (109, 110), (92, 90), (91, 90)])
def test_a_grid_gets_the_rows_that_its_number_of_faces_needs(wanted, count, rounds):
    quads = finish_quads(grid(), PLANE, [boundary_row(PLANE)], rounds, only_quads=True, wanted=wanted)
    assert len(quads.sizes) == count and (quads.sizes == 4).all() and euler(quads) == 1
    rim, edges = on_rim(quads), valences(quads)
    assert (edges[~rim] == 4).all() and (edges[rim] == 2).sum() == 4
    # The square is covered once.
    assert signed_areas(quads).min() > 0 and signed_areas(quads).sum() == pytest.approx(1, abs=1e-9)
    assert quads.edge_lengths.min() > 0.3 / CELLS


@pytest.mark.parametrize("wanted", [275, 288, 300, 312, 325])
def test_a_closed_surface_stays_closed_and_regular(wanted):
    quads = finish_quads(ring(25, 12), RING, (), 10, only_quads=True, wanted=wanted)
    assert abs(len(quads.sizes) / wanted - 1) <= 0.03
    _, forward, backward = edges_of(quads)
    assert (forward == 1).all() and (backward == 1).all() and euler(quads) == 0
    assert (valences(quads) == 4).all() and quads.edge_lengths.min() > 0.02
    assert RING.finder.nearest(quads.vertices)[0] == pytest.approx(quads.vertices, abs=1e-9)


def test_strips_that_end_at_other_faces_stay():
    """Of 4 rows around a torus and 30 rings, one quad in two triangles spoils one each."""
    quads = ring(30, 4)
    assert may_meet(quads, 4, 124) and may_meet(quads, -8, 112) and not may_meet(quads, 60, 180)
    corners = quads.corner_vertices.reshape(-1, 4)
    cut = [corners[0, [0, 1, 2]], corners[0, [0, 2, 3]]]
    for number in np.arange(4, len(corners), 4):
        cut += [corners[number, [0, 1, 2]], corners[number, [0, 2, 3]]]
    rest = corners[np.arange(len(corners)) % 4 > 0]
    spoilt = quads.with_faces(np.concatenate([np.ravel(cut), rest.ravel()]), np.repeat([3, 4], [len(cut), len(rest)]))
    assert len(spoilt.sizes) == 150 and not may_meet(spoilt, 10, 160) and not may_meet(spoilt, -14, 136)
