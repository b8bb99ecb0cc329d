# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tetrahedra are divided in thin walls between areas, and nowhere else."""

import numpy as np
import pytest

from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.filling import thin_walls
from synch_fields.core.geometry.filling.closed_surface import Area, ClosedSurface
from synch_fields.core.geometry.filling.surface_distance import SurfaceDistance
from synch_fields.core.geometry.filling.thin_walls import MOST, refine_thin_walls
from synch_fields.core.geometry.mesh_input import MeshInput
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.geometry.tet_mesh import TetMesh

from ...meshes import cube, icosphere
from ...solids import dihedral_angles, grid_tets


def closed(mesh):
    given = MeshInput(mesh, Polygons.of_triangles(mesh), np.eye(3), mesh, np.arange(mesh.vertex_count))
    return ClosedSurface(given, SurfaceDistance(mesh))


def block_with_fin(thickness=0.12):
    """A unit cube with a fin at its floor, a unit long and wide, and the areas that look down and up."""
    points, tets = grid_tets((4, 2, 2), lambda i, j, k: i < 2 or k < 1)
    used, tets = np.unique(tets, return_inverse=True)
    heights = np.array([0, thickness, 1])[points[used, 2].astype(int)]
    mesh = TetMesh(np.column_stack([points[used, :2] / 2, heights]), tets.reshape(-1, 4)).boundary_surface[0]
    up = mesh.face_normals[:, 2]
    return closed(mesh), [Area("down", np.flatnonzero(up < -0.9)), Area("up", np.flatnonzero(up > 0.9))]


def eccentric_shell():
    """The space between a unit sphere and one in it, from a tenth to a half thick; and the two areas."""
    sphere = icosphere(4)
    inner = 0.7 * sphere.vertices + [0.2, 0, 0]
    triangles = [sphere.triangles, sphere.triangles[:, ::-1] + sphere.vertex_count]
    areas = [Area(name, np.arange(sphere.triangle_count) + k * sphere.triangle_count) for k, name in enumerate("oi")]
    return closed(TriangleMesh(np.vstack([sphere.vertices, inner]), np.vstack(triangles))), areas


def across(solid, point, direction):
    """How many vertices of a solid lie strictly inside near a line through a wall."""
    away = solid.vertices - point
    aside = np.linalg.norm(away - np.outer(away @ direction, direction), axis=1)
    return np.count_nonzero((aside < 0.1) & ~solid.boundary_vertices)


def test_a_fin_has_vertices_inside_and_the_block_stays():
    surface, areas = block_with_fin()
    plain, finer = surface.filled(0.1).solid, surface.filled(0.1, areas).solid
    np.testing.assert_allclose(finer.volumes.sum(), 1.12, rtol=1e-3)
    assert plain.tet_count < finer.tet_count <= MOST * plain.tet_count
    assert across(finer, [1.5, 0.5, 0.06], np.array([0, 0, 1.0])) >= 2 * across(
        plain, [1.5, 0.5, 0.06], np.array([0, 0, 1.0])
    )
    in_fin = finer.vertices[finer.tets][:, :, 0].min(axis=1) > 1.15
    lengths = finer.edge_lengths[finer.tet_edges].max(axis=1)
    assert lengths[in_fin].max() < 0.09 < plain.edge_lengths[plain.tet_edges].max(axis=1).mean()
    # Half of the block, away from the fin, has the same tetrahedra.
    halves = [
        solid.vertices[solid.tets[solid.vertices[solid.tets][:, :, 0].max(axis=1) < 0.6]] for solid in (plain, finer)
    ]
    np.testing.assert_array_equal(*halves)
    assert dihedral_angles(finer).min() > 8 and dihedral_angles(finer).max() < 170


def test_a_curved_wall_keeps_its_surface_and_its_volume():
    surface, areas = eccentric_shell()
    plain, (finer, coarse) = surface.filled(0.09).solid, surface.filled(0.09, areas)
    assert plain.tet_count < finer.tet_count <= MOST * plain.tet_count
    exact = surface.distance.volume
    assert exact == pytest.approx(4 / 3 * np.pi * (1 - 0.7**3), rel=0.01)
    assert finer.volumes.sum() == pytest.approx(exact, rel=3e-3)
    off = np.abs(surface.distance(finer.vertices[finer.boundary_vertices]))
    assert np.quantile(off, 0.99) < 1e-6 and finer.boundary_surface[0].euler_characteristic == 4
    # It is divided where it is thin, at x = 1, and not on the other side.
    x = finer.vertices[finer.tets].mean(axis=1)[:, 0]
    lengths = finer.edge_lengths[finer.tet_edges].max(axis=1)
    assert lengths[x > 0.9].mean() < 0.8 * lengths[x < -0.5].mean()
    # Where x > 0.9, the shell is at most this thick, and all tetrahedra are half as long.
    thickest = 1 - (0.2 * 0.9 + np.sqrt(0.7**2 - 0.2**2 * (1 - 0.9**2)))
    within = finer.vertices[finer.tets][:, :, 0].min(axis=1) > 0.9
    assert coarse == 0 and lengths[within].max() <= thickest / 2


def plate(thickness):
    """A plate, two units long and wide, and its two sides."""
    mesh = TriangleMesh(cube(8).vertices * [2, 2, thickness], cube(8).triangles)
    up = mesh.face_normals[:, 2]
    return closed(mesh), [Area("down", np.flatnonzero(up < -0.9)), Area("up", np.flatnonzero(up > 0.9))]


@pytest.mark.parametrize(("thickness", "size"), [(0.05, 0.08), (0.08, 0.08), (0.12, 0.1)])
def test_a_plate_is_divided_as_far_as_the_limit_lets_it(thickness, size):
    """A whole round of bisections would make more tetrahedra than the limit."""
    surface, areas = plate(thickness)
    plain, (finer, coarse) = surface.filled(size).solid, surface.filled(size, areas)
    assert 0.98 * MOST * plain.tet_count < finer.tet_count <= MOST * plain.tet_count
    inner = [np.count_nonzero(~solid.boundary_vertices) for solid in (plain, finer)]
    assert inner[1] > 2 * inner[0]
    np.testing.assert_allclose(finer.volumes.sum(), 4 * thickness, rtol=1e-6)
    assert finer.volumes.min() > 0 and dihedral_angles(finer).min() > 5
    # Every tetrahedron of a plate is in a wall.
    longest = finer.edge_lengths[finer.tet_edges].max(axis=1)
    long = float(finer.volumes[longest > thickness / 2].sum()) / (4 * thickness)
    assert long > 0.5 and coarse == pytest.approx(long, abs=0.02)


def test_thin_walls_make_no_more_tetrahedra_than_any_solid_may_have(monkeypatch):
    surface, areas = plate(0.12)
    plain = surface.filled(0.1).solid
    monkeypatch.setattr(thin_walls, "MOST_TETS", 1.3 * plain.tet_count)
    assert 1.25 < surface.filled(0.1, areas).solid.tet_count / plain.tet_count <= 1.3
    monkeypatch.setattr(thin_walls, "MOST_TETS", plain.tet_count // 2)
    untouched, coarse = surface.filled(0.1, areas)
    np.testing.assert_array_equal(untouched.tets, plain.tets)
    assert coarse > 0.9


def test_the_thinnest_walls_are_divided_first():
    """A wedge from 0.06 to 0.2 thick."""
    mesh = cube(8)
    x, y, z = mesh.vertices.T
    down, up = plate(1.0)[1]
    mesh = TriangleMesh(np.column_stack([2 * x, 2 * y, (0.13 + 0.07 * (2 * x - 1)) * (z - 0.5)]), mesh.triangles)
    surface = closed(mesh)
    plain, (finer, coarse) = surface.filled(0.1).solid, surface.filled(0.1, [down, up])
    shares = []
    for low, high in ((0, 1), (1, 2)):
        counts = []
        for solid in (plain, finer):
            at = solid.vertices[solid.tets].mean(axis=1)[:, 0]
            counts.append(np.count_nonzero((at >= low) & (at < high)))
        shares.append(counts[1] / counts[0])
    assert coarse > 0 and finer.tet_count <= MOST * plain.tet_count
    assert shares[0] > 1.5 * shares[1]


@pytest.mark.parametrize("chosen", ["none", "one side", "thick"])
def test_other_solids_stay_as_they_are(chosen):
    """The same object where nothing is divided: no areas, a wall with one of its sides, a block as thick as long."""
    surface, areas = (closed(cube(2)), None) if chosen == "thick" else block_with_fin()
    mesh = surface.mesh
    marked = np.zeros(mesh.triangle_count, bool)
    if chosen == "thick":
        marked[:] = True
    elif chosen == "one side":
        marked[areas[0].triangles] = True
    solid = surface.filled(0.1).solid
    assert refine_thin_walls(solid, mesh, surface.distance.nearest, marked) == (solid, 0.0)
