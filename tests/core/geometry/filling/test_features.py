# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sharp edges and corners of a surface are those of the solid that fills it, as far as its angles let them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.filling.features import SHARP, sharp_edges, sharpen_edges, within_bounds
from synch_fields.core.geometry.filling.stuffing import DIHEDRAL_BOUNDS, fill_surface
from synch_fields.core.geometry.filling.surface_distance import SurfaceDistance
from synch_fields.core.geometry.nearest import nearest_in_triangles
from synch_fields.core.geometry.tet_mesh import signed_volumes

from ...meshes import cube, icosphere
from ...solids import dihedral_angles, enclosed_volume


def brute_force(mesh):
    """The nearest triangle of each point, by trying all."""

    def nearest(points):
        corners = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)[:, None]
        shares = nearest_in_triangles(points[:, None], corners)
        return np.linalg.norm(
            points[:, None]
            - np.einsum("ptk,kptx->ptx", shares, np.broadcast_to(corners, (3, len(points), mesh.triangle_count, 3))),
            axis=2,
        ).argmin(axis=1)

    return nearest


def turned(mesh):
    return TriangleMesh(mesh.vertices @ Rotation.from_rotvec([0.3, 0.5, 0.2]).as_matrix().T, mesh.triangles)


def filled(mesh, size):
    distance = SurfaceDistance(mesh)
    return fill_surface(distance, distance.bounds, size)


def test_a_cube_has_twelve_edges_eight_corners_and_six_regions():
    mesh = cube(3)
    sharp = sharp_edges(mesh)
    assert len(sharp) == 12 * 3
    corners = mesh.line_corners(sharp, SHARP)
    assert np.isin(mesh.vertices[corners], (0, 1)).all() and len(corners) == 8
    regions = mesh.parts_between(sharp)
    assert len(np.unique(regions)) == 6
    for region in range(6):
        assert np.ptp(mesh.face_normals[regions == region], axis=0).max() < 1e-12


def test_a_cube_along_the_lattice_is_filled_exactly():
    mesh = cube(1)
    before = filled(mesh, 0.075)
    after = sharpen_edges(before, mesh, brute_force(mesh))
    assert before.volumes.sum() < 0.999
    assert after.volumes.sum() == pytest.approx(1, abs=1e-12)
    np.testing.assert_array_equal(after.tets, before.tets)
    np.testing.assert_array_equal(after.boundary_vertices, before.boundary_vertices)


def test_edges_and_corners_of_a_turned_cube_come_back_within_the_bounds_of_angles():
    mesh = turned(cube(1))
    before = filled(mesh, 0.1)
    after = sharpen_edges(before, mesh, brute_force(mesh))
    lost, left = 1 - before.volumes.sum(), 1 - after.volumes.sum()
    assert lost > 0.01 and 0 <= left < lost / 3
    angles = dihedral_angles(after)
    assert angles.min() > DIHEDRAL_BOUNDS[0] and angles.max() < DIHEDRAL_BOUNDS[1]
    for corner in mesh.vertices:
        assert np.linalg.norm(after.vertices - corner, axis=1).min() < 1e-12
    on = after.vertices[after.boundary_vertices]
    assert np.abs(SurfaceDistance(mesh)(on)).max() < 1e-6
    assert enclosed_volume(after.boundary_surface[0]) == pytest.approx(after.volumes.sum())


def test_a_smooth_surface_is_left_as_it_is():
    mesh = icosphere(2)
    solid = filled(mesh, 0.3)
    assert sharpen_edges(solid, mesh, brute_force(mesh)) is solid


def test_the_outline_of_a_part_runs_along_edges_of_the_solid():
    """A square marked on a face of a cube is made of whole triangles but for a few at its rim."""
    mesh = cube(4)
    centres = mesh.vertices[mesh.triangles].mean(axis=1)
    marked = (centres[:, 2] > 1 - 1e-9) & (np.abs(centres[:, :2] - 0.5) < 0.25).all(axis=1)
    before = filled(mesh, 0.09)
    shares = []
    for labels in (None, marked.astype(int)):
        after = sharpen_edges(before, mesh, brute_force(mesh), labels)
        triangles = after.vertices[after.boundary_triangles]
        inside = (triangles[:, :, 2] > 1 - 1e-6) & (np.abs(triangles[:, :, :2] - 0.5) < 0.25 + 1e-6).all(axis=2)
        a, b, c = np.moveaxis(triangles[inside.all(axis=1)], 1, 0)
        shares.append(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 / 0.25)
    assert shares[0] < 0.85 and 0.9 < shares[1] < 1 + 1e-9


def test_a_tetrahedron_with_a_face_without_area_is_out_of_bounds():
    """Three corners on a line to the last bit, and a volume above zero by rounding."""
    on_a_line = [[0.875, 0.25, 0.125], [1.75, 0.375, 0.75], [3.5, 0.625, 2.0]]
    apart = [0.2997118905373848, 0.42268722119765845, 0.028319671145462966]
    vertices, tets = np.array([on_a_line[1], on_a_line[2], apart, on_a_line[0]]), np.array([[0, 1, 2, 3]])
    assert signed_volumes(vertices, tets)[0] > 0
    assert not within_bounds(vertices, tets)
