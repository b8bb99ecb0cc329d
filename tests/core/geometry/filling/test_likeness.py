# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids that are no longer the body that their surface encloses are refused, with a size that fits."""

import re

import numpy as np
import pytest

from synch_fields.core.errors import MeshError, SettingError
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.filling import topology_check
from synch_fields.core.geometry.filling.lengths import AUTOMATIC_CUBES, estimate
from synch_fields.core.geometry.filling.stuffing import estimated_cubes, fill_surface
from synch_fields.core.geometry.filling.surface_distance import SurfaceDistance
from synch_fields.core.geometry.filling.topology_check import fill_with_same_topology, more_holes

from ...meshes import grid_quads, icosphere, split_quads, together, torus, voxel_quads


def turned_box(*size, angle=0.4):
    """A box of these sides, turned about two axes so that no lattice plane lies along it."""
    points, quads = voxel_quads([(0, 0, 0)])
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return TriangleMesh(points * size @ turn.T, split_quads(quads))


def with_fin():
    """A cube beside a wide, thin plate, to which more than half of the surface belongs."""
    return together(turned_box(1, 1, 1), turned_box(2, 2, 0.06))


@pytest.mark.parametrize(
    ("mesh", "size", "flaw"),
    [
        pytest.param(turned_box(2, 2, 0.1), 0.4, "nothing of the solid is left", id="vanished"),
        pytest.param(turned_box(3, 3, 0.1), 0.098, r"the solid has \d+ holes where the surface has none", id="sieve"),
        pytest.param(torus(1, 0.03, 60, 8), 0.05, r"the solid falls apart into \d+ pieces", id="beads"),
        pytest.param(with_fin(), 0.15, r"the solid leaves out 5\d% of the surface", id="lost"),
    ],
)
def test_another_body_is_refused_with_a_size_that_fits(mesh, size, flaw):
    distance = SurfaceDistance(mesh)
    with pytest.raises(SettingError, match=flaw) as caught:
        fill_with_same_topology(distance, size)
    finer = float(re.search("give a size of ([0-9.e-]+)", str(caught.value))[1])
    assert finer < size and "\n" not in str(caught.value)
    solid = fill_with_same_topology(distance, finer)
    assert solid.volumes.sum() == pytest.approx(distance.volume, rel=0.25)
    assert len(np.unique(solid.pieces)) == len(np.unique(mesh.pieces))


def test_what_no_size_fills_is_refused(monkeypatch):
    monkeypatch.setattr(topology_check, "MOST_TRIED_CUBES", 1_000_000)
    with pytest.raises(MeshError, match=r"sizes down to 0.\d+ were tried, too: thicken these parts"):
        fill_with_same_topology(SurfaceDistance(turned_box(4, 4, 0.001)), 0.2)


def test_no_other_size_is_told_where_none_was_tried(monkeypatch):
    monkeypatch.setattr(topology_check, "MOST_TRIED_CUBES", 1)
    with pytest.raises(MeshError, match="; thicken these parts, or give a smaller size"):
        fill_with_same_topology(SurfaceDistance(turned_box(4, 4, 0.001)), 0.2)


def slanting_rod(rings=28, around=4, thickness=1e-3):
    """A square rod along the diagonal of a cube, 112 vertices, that fills a millionth of its box."""
    along = np.linspace(0, 1, rings)[:, None, None] * np.ones(3)
    turns = 2 * np.pi * np.arange(around) / around
    across = np.outer(np.cos(turns), [1, -1, 0]) / np.sqrt(2) + np.outer(np.sin(turns), [1, 1, -2]) / np.sqrt(6)
    places = (along + thickness * across).reshape(-1, 3)
    walls = split_quads(grid_quads(rings - 1, around, wrap_rows=True))
    first = np.array([[0, 1, 2], [0, 2, 3]])
    mesh = TriangleMesh(places, np.concatenate([walls, first, first[:, ::-1] + around * (rings - 1)]))
    signed = np.einsum("ij,ij->", mesh.vertices[mesh.triangles[:, 0]], mesh.face_normals * mesh.areas[:, None])
    return mesh if signed > 0 else TriangleMesh(mesh.vertices, mesh.triangles[:, ::-1])


def test_a_thin_rod_across_its_box_is_given_up_after_a_bounded_search(monkeypatch):
    """Sizes that fill it have more cubes than are tried, however few tetrahedra they make."""
    cubes, fill = [], topology_check.fill_surface

    def count_cubes(signed_distance, bounds, size):
        cubes.append(estimated_cubes(bounds, size))
        return fill(signed_distance, bounds, size)

    monkeypatch.setattr(topology_check, "fill_surface", count_cubes)
    monkeypatch.setattr(topology_check, "MOST_TRIED_CUBES", 1_000_000)
    distance = SurfaceDistance(slanting_rod())
    assert distance.mesh.vertex_count == 112
    with pytest.raises(MeshError, match="were tried, too: thicken these parts"):
        fill_with_same_topology(distance, 0.05)
    assert 2 < len(cubes) < 12 and sum(cubes) < 3 * topology_check.MOST_TRIED_CUBES


def test_the_automatic_size_of_a_thin_rod_makes_a_bounded_number_of_cubes():
    distance = SurfaceDistance(slanting_rod())
    assert estimated_cubes(distance.bounds, estimate(distance).size) <= AUTOMATIC_CUBES


@pytest.mark.parametrize("speck", [0.02, 0.004])
def test_small_losses_change_no_solid(speck):
    """A speck that vanishes, and the tips of twenty spikes."""
    base = icosphere(2)
    spiky = TriangleMesh(base.vertices * np.where(np.arange(base.vertex_count) < 12, 1.5, 1)[:, None], base.triangles)
    distance = SurfaceDistance(together(spiky, TriangleMesh(icosphere(0).vertices * speck, icosphere(0).triangles)))
    found, plain = fill_with_same_topology(distance, 0.2), fill_surface(distance, distance.bounds, 0.2)
    np.testing.assert_array_equal(found.vertices, plain.vertices)
    np.testing.assert_array_equal(found.tets, plain.tets)


def open_ring(gap, around=60, across=12):
    """A ring of unit radius, thick by 0.6, whose two flat ends are about so far apart."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi - gap, around), np.arange(across) * 2 * np.pi / across, indexing="ij")
    reach = 1 + 0.3 * np.cos(v)
    points = np.stack([reach * np.cos(u), reach * np.sin(u), 0.3 * np.sin(v)], axis=-1)
    walls = split_quads(grid_quads(around - 1, across, wrap_rows=True))
    rim, ends = np.arange(across), around * across + np.arange(2)
    first = np.column_stack([rim, np.roll(rim, -1), np.full(across, ends[0])])
    last = np.column_stack([np.roll(rim, -1), rim, np.full(across, ends[1])])
    last[:, :2] += (around - 1) * across
    points = np.vstack([points.reshape(-1, 3), points[[0, -1]].mean(axis=1)])
    return TriangleMesh(points, np.concatenate([walls, first, last]))


@pytest.mark.parametrize(
    ("mesh", "size", "more"),
    [
        pytest.param(open_ring(0.05), 0.2, 1, id="a gap closed"),
        pytest.param(open_ring(0.8), 0.2, 0, id="a gap open"),
        pytest.param(torus(1, 0.93, 60, 60), 0.35, -1, id="a hole closed"),
        pytest.param(torus(1, 0.5, 60, 30), 0.35, 0, id="a hole open"),
    ],
)
def test_holes_that_come_and_go_are_counted(mesh, size, more):
    distance = SurfaceDistance(mesh)
    assert more_holes(fill_with_same_topology(distance, size), distance) == more
