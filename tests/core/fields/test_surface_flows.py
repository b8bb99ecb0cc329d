# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows on triangle surfaces: known vortices are found, and the sphere is covered as often as there are vortices."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.extract.vortices.filaments import linear_zero, vortices
from synch_fields.core.fields.clebsch import circulations, clebsch_map, edge_integrals, quantum_for, spherical_map
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.grid import Grid
from synch_fields.core.geometry.surface import Surface

from ..flows import rankine_velocity
from ..meshes import icosphere, square, torus


def plane(columns=40, half=2.0):
    mesh = square(columns, width=2 * half, height=2 * half)
    return Surface(TriangleMesh(mesh.vertices - [half, half, 0], mesh.triangles))


def angles_around(places, centre):
    return np.arctan2(places[:, 1] - centre[1], places[:, 0] - centre[0])


def integrals_around(surface, centres, circulations_of):
    """(e,) integrals of the flow around points of a plane: the angles that each edge is seen under."""
    i, j = surface.edges.T
    total = np.zeros(len(surface.edges))
    for centre, circulation in zip(centres, circulations_of, strict=True):
        angles = angles_around(surface.places, centre)
        total += circulation / (2 * np.pi) * ((angles[j] - angles[i] + np.pi) % (2 * np.pi) - np.pi)
    return total


def test_circulations_are_the_vorticity_through_the_triangles():
    flat = plane(9)
    velocity = np.cross([0, 0, 1], flat.places)
    np.testing.assert_allclose(
        circulations(flat, edge_integrals(flat, velocity)), 2 * flat.mesh.areas, rtol=1e-9, atol=1e-12
    )
    sphere = Surface(icosphere(4))
    turning = circulations(sphere, edge_integrals(sphere, np.cross([0, 0, 1], sphere.places)))
    assert turning.sum() == pytest.approx(0, abs=1e-12)
    above = sphere.places[sphere.faces].mean(axis=1)[:, 2] > 0
    assert turning[above].sum() == pytest.approx(2 * np.pi, rel=0.01)
    normals = sphere.mesh.face_normals[:, 2]
    np.testing.assert_allclose(turning, 2 * normals * sphere.mesh.areas, atol=0.05 * np.abs(turning).max())


def test_only_the_tangential_part_of_a_velocity_counts():
    sphere = Surface(icosphere(2))
    velocity = np.cross([0.3, 0, 1], sphere.places)
    lifted = velocity + 5 * sphere.mesh.vertex_normals
    np.testing.assert_allclose(edge_integrals(sphere, lifted), edge_integrals(sphere, velocity), atol=1e-12)


def test_vortices_lie_where_the_flow_has_them():
    surface = plane(24, half=1.2)
    centres, strengths = [(0.42, 0.11), (-0.5, -0.31)], [1.0, -1.0]
    found = clebsch_map(surface, integrals_around(surface, centres, strengths), 1.0)
    _, places, winding = vortices(found)
    assert sorted(winding) == [-1.0, 1.0]
    for centre, strength in zip(centres, strengths, strict=True):
        assert np.linalg.norm(places[winding == strength][0, :2] - centre) < 0.5 * 0.1


@pytest.mark.parametrize("mesh", [icosphere(3), torus()], ids=["sphere", "torus"])
def test_vortices_of_a_closed_surface_cancel(mesh):
    surface = Surface(mesh)
    velocity = np.cross([0.2, 0, 1], surface.places) * (1 + surface.places[:, :1])
    integrals = edge_integrals(surface, velocity)
    found = clebsch_map(surface, integrals, quantum_for(surface, integrals, 4))
    assert found.face_numbers.any() and found.face_numbers.sum() == 0
    assert found.solution.lower_bound <= found.energy
    sphere = spherical_map(found)
    assert abs(sphere.face_areas.sum()) < 1e-9 * max(np.abs(sphere.face_areas).sum(), 1)


def test_a_sphere_is_pierced_on_both_sides():
    """Rigid rotation has vorticity of one sign on either half."""
    surface = Surface(icosphere(4))
    integrals = edge_integrals(surface, np.cross([0, 0, 1], surface.places))
    found = clebsch_map(surface, integrals, quantum_for(surface, integrals, 5))
    _, places, strengths = vortices(found)
    assert len(places) and (np.sign(places[:, 2]) == np.sign(strengths)).all()


@pytest.mark.parametrize("count", [3, 6])
def test_figure_7(count):
    """Curl 1 in the unit disk: each singular map has as many vortices as the sphere is covered."""
    surface = plane(50, half=1.6)
    found = clebsch_map(surface, edge_integrals(surface, rankine_velocity(surface.places)), np.pi / count)
    sphere = spherical_map(found)
    covered = sphere.face_areas.sum()
    assert np.abs(sphere.face_areas).sum() == pytest.approx(covered, rel=1e-3)  # nowhere folded over
    assert count - 1.2 < covered < count
    directions = np.random.default_rng(0).standard_normal((300, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    numbers = np.array([sphere.seen_from(direction).face_numbers for direction in directions])
    # A sliver that is folded over is met by hardly any direction.
    plain = (numbers >= 0).all(axis=1)
    assert plain.mean() > 0.98 and numbers.max() == 1
    met = numbers.sum(axis=1)
    np.testing.assert_allclose(met.mean(), covered, atol=4 * met.std() / np.sqrt(len(met)) + 0.03)
    # One by one: the triangles on the sphere that hold the antipode; over the boundary's image vortices leave.
    triangles = sphere.sphere[surface.faces]
    sides = np.cross(triangles, np.roll(triangles, -1, axis=1)) @ -directions.T
    facing = triangles.mean(axis=1) @ -directions.T > 0
    held = ((sides > 0).all(axis=1) & facing).sum(axis=0)
    border = sphere.sphere[surface.mesh.boundary_vertices]
    clear = plain & ((border @ -directions.T).max(axis=0) < np.cos(0.15))
    assert clear.mean() > 0.8
    np.testing.assert_array_equal(met[clear], held[clear])
    radii = np.linalg.norm(surface.places[surface.faces].mean(axis=1), axis=1)
    assert np.quantile(np.broadcast_to(radii, numbers.shape)[numbers > 0], 0.9) < 1.1  # where the vorticity is


def test_a_square_mesh_agrees_with_the_grid():
    """The diagonals of right-angled triangles have no weight: energies and vortices are those of the grid."""
    grid = Grid((25, 25), spacing=4 / 24, origin=-2)
    velocity = rankine_velocity(np.column_stack([grid.places, np.zeros(grid.node_count)]))
    maps = [
        clebsch_map(domain, edge_integrals(domain, velocity[:, : domain.places.shape[1]]), np.pi / 3)
        for domain in (grid, plane(24))
    ]
    assert maps[0].energy == pytest.approx(maps[1].energy, rel=0.02)
    assert maps[0].face_numbers.sum() == maps[1].face_numbers.sum()


def test_zeros_of_linear_functions():
    random = np.random.default_rng(0)
    shares = random.dirichlet([1, 1, 1], 200)
    values = random.standard_normal((200, 3)) + 1j * random.standard_normal((200, 3))
    values[:, 2] = -(shares[:, :2] * values[:, :2]).sum(axis=1) / shares[:, 2]
    np.testing.assert_allclose(linear_zero(values), shares, atol=1e-8)
    np.testing.assert_array_equal(linear_zero(np.ones((1, 3), complex)), [[1 / 3] * 3])


def test_what_is_no_flow_on_a_surface_is_refused():
    surface = plane(5)
    with pytest.raises(SettingError, match="three numbers a vertex"):
        edge_integrals(surface, np.zeros((36, 2)))
    velocity = np.zeros((36, 3))
    with pytest.raises(SettingError, match="no vorticity"):
        quantum_for(surface, edge_integrals(surface, velocity), 2)
    velocity[[3, 9], 1] = np.nan
    with pytest.raises(SettingError, match="vertices 3, 9 is not a number"):
        edge_integrals(surface, velocity)
