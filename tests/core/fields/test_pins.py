# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Disclinations of chosen indices in chosen triangles."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.fields import DirectionWishes, direction_field
from synch_fields.core.fields.mirror import Mirror, mirrored_moves
from synch_fields.core.fields.patterns import PatternWishes, solve_pattern
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.mirror import mirrored_vertices
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.interpolate import dislocation_numbers

from ..meshes import icosphere, mixed_torus


def indices(field):
    return {defect.triangle: defect.index for defect in field.disclinations}


@pytest.mark.parametrize(
    ("build", "euler", "symmetry"),
    [(lambda: icosphere(3), 2, 1), (lambda: mixed_torus()[0], 0, 2), (lambda: icosphere(3), 2, 4)],
)
def test_a_pinned_triangle_has_the_index_and_all_of_them_sum_to_the_topology(build, euler, symmetry):
    mesh = build()
    free = direction_field(mesh, symmetry)
    for turns in (1, -1, 2):
        triangle = int(np.random.default_rng(turns + 7).integers(mesh.triangle_count))
        field = direction_field(mesh, symmetry, DirectionWishes(pins=((triangle, turns / symmetry),)))
        assert indices(field)[triangle] == turns / symmetry
        assert sum(indices(field).values()) == pytest.approx(euler)
        assert free.problem.energy(field.solution.phases) >= free.solution.lower_bound


def test_a_pin_of_zero_sends_a_disclination_away():
    mesh = icosphere(3)
    free = direction_field(mesh, 2)
    there = free.disclinations[0].triangle
    field = direction_field(mesh, 2, DirectionWishes(pins=((there, 0.0),)))
    assert there not in indices(field) and sum(indices(field).values()) == pytest.approx(2)


def test_several_pins_hold_at_once_and_with_fewer_singularities():
    mesh = icosphere(3)
    pins = ((3, 0.5), (400, 0.5), (700, -0.5))
    for share in (1.0, 0.5, 0.0):
        found = indices(direction_field(mesh, 2, DirectionWishes(singularities=share, pins=pins)))
        assert {triangle: found[triangle] for triangle, _ in pins} == dict(pins)
        assert sum(found.values()) == pytest.approx(2)


@pytest.mark.parametrize("turns", [1, -1, 2])
def test_on_a_disc_directions_turn_evenly_around_a_pin(turns):
    """The harmonic map of that degree from a disc with free rim: its angle grows as the polar one."""
    rows = 15
    u, v = np.meshgrid(np.arange(-rows, rows + 1), np.arange(-rows, rows + 1), indexing="ij")
    places = np.stack([u + v / 2 - 0.5, v * np.sqrt(3) / 2 - np.sqrt(3) / 6, 0 * u], axis=-1).reshape(-1, 3)
    number = np.arange(u.size).reshape(u.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    triangles = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, d), (b, c, d))])
    triangles = triangles[np.linalg.norm(places[triangles].mean(axis=1), axis=1) < 9]
    used, triangles = np.unique(triangles, return_inverse=True)
    mesh = TriangleMesh(places[used], triangles.reshape(-1, 3))
    centre = int(np.linalg.norm(mesh.vertices[mesh.triangles].mean(axis=1), axis=1).argmin())
    field = direction_field(mesh, 2, DirectionWishes(pins=((centre, turns / 2),)))
    assert indices(field) == {centre: turns / 2}
    lines = (field.vectors[:, 0] + 1j * field.vectors[:, 1]) ** 2
    polar = (mesh.vertices[:, 0] + 1j * mesh.vertices[:, 1]) ** turns
    off = np.angle(lines * np.conj(polar / np.abs(polar)))
    off = np.angle(np.exp(1j * off) / np.exp(1j * off).mean())
    assert np.abs(off).max() < 0.1


def test_stripes_along_pinned_directions_end_in_the_same_triangle():
    mesh = icosphere(3)
    field = direction_field(mesh, 2, DirectionWishes(pins=((100, 0.5),)))
    pattern = solve_pattern(mesh, field, PatternWishes(0.5))
    torn = dislocation_numbers(pattern.edge_phases, mesh.triangles)[1]
    assert set(np.flatnonzero(torn)) == set(indices(field))


def test_what_is_no_pin_is_refused():
    mesh = icosphere(2)
    for pins, match in ((((9999, 0.5),), "no triangle 9999"), (((0, 0.3),), "multiple of 0.5")):
        with pytest.raises(SettingError, match=match):
            direction_field(mesh, 2, DirectionWishes(pins=pins))


def test_a_move_of_a_face_has_its_mirror_images():
    mesh = icosphere(2)
    polygons = Polygons.of_triangles(mesh)
    mirrors = [Mirror.of(mesh, mirrored_vertices(mesh, polygons, axis), axis) for axis in (0, 2)]
    places = mesh.vertices[mesh.triangles].mean(axis=1)
    start, end = (int(np.linalg.norm(places - place, axis=1).argmin()) for place in ([0.5, 0.5, 0.5], [0.3, 0.2, 0.9]))
    moves = mirrored_moves(mirrors, polygons, start, end)
    assert len(moves) == 4 and moves[start] == end
    for first, second in moves.items():
        signs = np.sign(places[first] * places[start])
        np.testing.assert_allclose(places[first], signs * places[start], atol=1e-9)
        np.testing.assert_allclose(places[second], signs * places[end], atol=1e-9)
    on_plane = int(np.abs(places[:, 0]).argmin())
    if mirrors[0].image_of_face(polygons, on_plane) == on_plane:
        with pytest.raises(SettingError, match="stays there"):
            mirrored_moves(mirrors, polygons, on_plane, end)


def test_pins_on_both_sides_of_a_mirror_hold():
    mesh = icosphere(3)
    mirror = Mirror.of(mesh, mirrored_vertices(mesh, Polygons.of_triangles(mesh), 0), 0)
    places = mesh.vertices[mesh.triangles].mean(axis=1)
    pinned = [int(np.linalg.norm(places - [side, 0.2, 0.5], axis=1).argmin()) for side in (0.6, -0.6)]
    pins = tuple((triangle, 0.5) for triangle in pinned)
    field = direction_field(mesh, 2, DirectionWishes(mirrors=(mirror,), pins=pins))
    assert [indices(field)[triangle] for triangle in pinned] == [0.5, 0.5]
    assert sum(indices(field).values()) == pytest.approx(2)
    with pytest.raises(SettingError, match="one side of a mirror"):
        direction_field(mesh, 2, DirectionWishes(mirrors=(mirror,), pins=pins[:1]))
