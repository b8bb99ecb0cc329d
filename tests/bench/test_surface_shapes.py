# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The surfaces that benchmarks make: topology as stated, areas and volumes in closed form."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from synch_fields.bench.meshes import read_obj, write_obj
from synch_fields.bench.surface_shapes import SHAPES
from synch_fields.core.geometry.check import check_mesh

BY_NAME = {shape.name: shape for shape in SHAPES}


def boundary_curves(mesh):
    ends = mesh.edges[mesh.boundary_edges]
    count = mesh.vertex_count
    graph = coo_array((np.ones(len(ends)), ends.T), shape=(count, count))
    return len(np.unique(connected_components(graph, directed=False)[1][ends]))


def volume(mesh):
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    return np.einsum("tx,tx->", a, np.cross(b, c)) / 6


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.name)
def test_a_surface_is_manifold_and_has_the_topology_it_states(shape):
    mesh = shape.make()
    check_mesh(mesh)
    assert len(mesh.loose_vertices) == 0 and len(np.unique(mesh.pieces)) == 1
    assert mesh.euler_characteristic == shape.characteristic
    assert boundary_curves(mesh) == shape.boundaries
    assert 5_000 <= mesh.triangle_count <= 22_000
    assert np.degrees(mesh.corner_angles).min() > 8
    assert mesh.edge_lengths.max() < 4 * np.median(mesh.edge_lengths)
    if not shape.boundaries:
        assert volume(mesh) > 0


def test_the_family_has_open_and_closed_surfaces_of_genus_0_to_3():
    genera = {(2 - shape.characteristic) // 2 for shape in SHAPES if not shape.boundaries}
    assert genera == {0, 1, 2, 3}
    assert sum(shape.boundaries > 0 for shape in SHAPES) >= 4


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("thin-box", 1.5 * 1.0 * 0.03),
        ("bracket", (1.0 * 0.22 + 0.58 * 0.22) * 0.6),
        ("block-with-holes", (1.6 * 0.6 - 3 * 0.26**2) * 0.3),
        # The cube less a prism along each edge, and less what a tetrahedron leaves of a small cube at each corner.
        ("chamfered-cube", 1 - 12 * 0.12**2 / 2 * 0.76 - 8 * (0.12**3 - 0.12**3 / 6)),
        # Two paraboloids, each half of its cylinder.
        ("lens", pytest.approx(np.pi * 0.7**2 * 0.15, rel=2e-3)),
        ("thin-torus", pytest.approx(2 * np.pi**2 * 0.8 * 0.08**2, rel=2e-2)),
    ],
)
def test_a_solid_has_the_volume_of_its_closed_form(name, expected):
    found = volume(BY_NAME[name].make())
    assert found == (expected if not isinstance(expected, float) else pytest.approx(expected, rel=1e-9))


def test_a_sheet_has_the_area_of_its_closed_form():
    """The hole is a regular polygon."""
    sides = round(2 * np.pi * 0.28 / 0.012)
    hole = sides / 2 * 0.28**2 * np.sin(2 * np.pi / sides)
    assert BY_NAME["plate-with-hole"].make().areas.sum() == pytest.approx(1.6 - hole, rel=1e-9)
    cylinder, bowl = (BY_NAME[name].make().areas.sum() for name in ("open-cylinder", "bowl"))
    assert cylinder == pytest.approx(2 * np.pi * 0.4 * 1.2, rel=1e-3)
    assert bowl == pytest.approx(2 * np.pi * 0.7**2, rel=1e-3)


@pytest.mark.parametrize("name", ["link", "cup"])
def test_a_surface_is_the_same_again_and_in_its_file(name, tmp_path):
    mesh, again = BY_NAME[name].make(), BY_NAME[name].make()
    np.testing.assert_array_equal(mesh.vertices, again.vertices)
    np.testing.assert_array_equal(mesh.triangles, again.triangles)
    write_obj(mesh, tmp_path / "mesh.obj")
    read = read_obj(tmp_path / "mesh.obj")
    np.testing.assert_array_equal(read.triangles, mesh.triangles)
    np.testing.assert_allclose(read.vertices * np.sqrt(mesh.areas.sum()), mesh.vertices, atol=1e-7)
