# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces whose narrow tunnels are replaced by disks at both ends."""

from itertools import product

import numpy as np
import pytest

from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.check import check_mesh
from synch_fields.core.geometry.tunnels import without_narrow_tunnels

from ..meshes import cylinder, split_quads, voxel_quads
from ..sharp_shapes import plate_with_holes

HOLES, SIDE = (2.0, 4.0, 6.0), 0.3


def sharp(mesh):
    return np.flatnonzero((np.abs(mesh.dihedral_angles) > 0.5) | (mesh.edge_face_counts == 1))


def filled(mesh, width):
    return without_narrow_tunnels(mesh, sharp(mesh), width)


def of_cells(cells):
    """The surface of a set of unit cubes."""
    points, quads = voxel_quads(cells)
    return TriangleMesh(points, split_quads(quads))


def block(*corner, size=5):
    """The cells of a cube from its lowest corner on."""
    return {tuple(np.add(corner, cell).tolist()) for cell in product(range(size), repeat=3)}


def test_a_plate_without_its_holes_is_a_box():
    plate = plate_with_holes(HOLES, side=SIDE)
    found = filled(plate, 1.5 * SIDE)
    check_mesh(found.mesh, np.arange(found.mesh.triangle_count))
    assert len(found.mesh.boundary_edges) == 0 and found.mesh.euler_characteristic == 2
    assert plate.euler_characteristic == 2 - 2 * len(HOLES) ** 2 and len(found.sources) == 2 * len(HOLES) ** 2
    # Flat disks have the area that the holes lack, so that a whole box is left.
    assert found.mesh.areas.sum() == pytest.approx(2 * 8 * 8 + 4 * 8 * 0.3)
    # A kept triangle is the same one; one of a disk is beside one of its tunnel.
    count = plate.vertex_count
    same = (found.mesh.triangles < count).all(axis=1)
    assert (found.mesh.triangles[same] == plate.triangles[found.triangles[same]]).all()
    rims = found.mesh.triangles[~same, :2, None] == plate.triangles[found.triangles[~same]][:, None]
    assert rims.any(axis=2).all() and (plate.face_normals[found.triangles[~same], 2] == 0).all()
    centres = np.array([[x, y] for x in HOLES for y in HOLES])
    away = np.linalg.norm(found.mesh.vertices[count:, None, :2] - centres, axis=2)
    assert away.min(axis=1).max() < 1e-9 and (np.bincount(away.argmin(axis=1)) == 2).all()


def test_wider_holes_stay():
    assert filled(plate_with_holes(HOLES, side=SIDE), 0.9 * SIDE) is None


def test_blind_holes_and_pegs_stay():
    cells = block(0, 0, 0) - {(4, 1, 1), (3, 1, 1)} | {(5, 3, 3), (6, 3, 3)}
    assert filled(of_cells(cells), 1.5) is None
    found = filled(of_cells(cells - {(1, 3, z) for z in range(5)}), 1.5)
    assert found.mesh.euler_characteristic == 2 and len(found.sources) == 2
    assert found.mesh.areas.sum() == pytest.approx(6 * 25 + 2 * 8)


def test_a_narrow_bar_between_two_blocks_leaves_two_pieces():
    dumbbell = of_cells(block(0, 0, 0) | block(8, 0, 0) | {(x, 2, 2) for x in range(5, 8)})
    found = filled(dumbbell, 1.5)
    used = found.mesh.used_vertices
    assert len(np.unique(found.mesh.pieces[used])) == 2 and len(found.mesh.boundary_edges) == 0
    assert found.mesh.areas.sum() == pytest.approx(2 * 6 * 25)


def test_tunnels_whose_walls_are_open_stay():
    assert filled(cylinder(radius=0.1, height=2.0), 1.0) is None
    plate = plate_with_holes(HOLES, side=SIDE)
    away = np.linalg.norm(plate.vertices[plate.triangles].mean(axis=1)[:, :2] - HOLES[0], axis=1)
    wall = np.flatnonzero((plate.face_normals[:, 2] == 0) & (away < SIDE))[0]
    found = filled(TriangleMesh(plate.vertices, np.delete(plate.triangles, wall, axis=0)), 1.5 * SIDE)
    assert len(found.sources) == 2 * (len(HOLES) ** 2 - 1) and len(found.mesh.boundary_edges) == 3


def test_triangles_without_area_between_sharp_edges_do_not_matter():
    plate = plate_with_holes(HOLES, side=SIDE)
    a, b, c = plate.triangles[0]
    n, middle = plate.vertex_count, (plate.vertices[a] + plate.vertices[b]) / 2
    mesh = TriangleMesh(
        np.vstack([plate.vertices, middle]), np.vstack([plate.triangles[1:], [[a, n, c], [n, b, c], [a, b, n]]])
    )
    assert mesh.areas[-1] == 0
    found = without_narrow_tunnels(mesh, np.union1d(sharp(mesh), mesh.triangle_edges[-1]), 1.5 * SIDE)
    assert len(found.sources) == 2 * len(HOLES) ** 2
