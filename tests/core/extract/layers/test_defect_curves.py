# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Dislocation curves close or end on the boundary, and lie where the phase is known to turn around them."""

import numpy as np
import pytest

from synch_fields.core.extract.layers.defect_curves import defect_curves
from synch_fields.core.interpolate import EdgePhases
from synch_fields.core.interpolate_solid import face_numbers

from ...layered_solids import block, random_phases, shell

SOLIDS = [lambda: block((4, 3, 3), jitter=0.2), lambda: shell(np.linspace(1, 2, 3), 1), lambda: block((1, 1, 1))]


def phases_of(mesh, angles):
    """Phases that change along edges by the shorter way from one to the other."""
    zero = np.zeros(len(mesh.edges))
    return EdgePhases.of(mesh, np.exp(1j * angles)[:, None], zero[:, None], zero.astype(int))


@pytest.mark.parametrize("noise", [0.3, 2, 12])
@pytest.mark.parametrize("build", SOLIDS)
def test_every_curve_closes_or_ends_on_the_boundary(build, noise):
    mesh = build()
    numbers = face_numbers(random_phases(mesh, noise))
    curves = defect_curves(mesh, numbers)
    on_boundary = np.zeros(len(mesh.faces), bool)
    on_boundary[mesh.boundary_faces] = True
    passed = np.zeros(len(numbers), int)
    for curve in curves:
        np.add.at(passed, curve.faces, curve.index)
        following = np.roll(curve.faces, -1) if curve.is_closed else curve.faces[1:]
        sides = mesh.tet_faces[curve.tets]
        assert len(curve.tets) == len(following)
        assert (sides == curve.faces[: len(following), None]).any(axis=1).all()
        assert (sides == following[:, None]).any(axis=1).all()
        np.testing.assert_array_equal(curve.points[0::2], mesh.vertices[mesh.faces[curve.faces]].mean(axis=1))
        np.testing.assert_array_equal(curve.points[1::2], mesh.vertices[mesh.tets[curve.tets]].mean(axis=1))
        if curve.is_closed:
            assert not on_boundary[curve.faces].any()
        else:
            assert np.flatnonzero(on_boundary[curve.faces]).tolist() == [0, len(curve.faces) - 1]
    np.testing.assert_array_equal(passed, np.abs(numbers))
    assert numbers.any()


@pytest.mark.parametrize("noise", [0.3, 12])
def test_curves_run_as_the_right_hand_says(noise):
    """A face's number is counted around its vertices in increasing order: the curve passes it that way."""
    mesh = block((4, 3, 3))
    numbers = face_numbers(random_phases(mesh, noise))
    for curve in defect_curves(mesh, numbers):
        a, b, c = (mesh.vertices[mesh.faces[curve.faces, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        ahead = np.empty_like(normals)
        ahead[: len(curve.tets)] = (
            mesh.vertices[mesh.tets[curve.tets]].mean(axis=1) - curve.points[0 : 2 * len(curve.tets) : 2]
        )
        if not curve.is_closed:
            ahead[-1] = curve.points[-1] - curve.points[-2]
        along = np.einsum("fx,fx->f", normals, ahead)
        np.testing.assert_array_equal(np.sign(along), np.sign(numbers[curve.faces]))


@pytest.mark.parametrize(("turns", "first"), [(1, 0), (-1, 1)])
def test_a_screw_has_one_curve_along_its_axis(turns, first):
    mesh = block((7, 7, 5))
    x, y, z = mesh.vertices.T
    (curve,) = defect_curves(mesh, face_numbers(phases_of(mesh, turns * np.arctan2(y - 0.49, x - 0.52) + 5 * z)))
    assert curve.index == 1 and not curve.is_closed
    assert [curve.points[0, 2], curve.points[-1, 2]] == pytest.approx([first, 1 - first])
    assert np.linalg.norm(curve.points[:, :2] - [0.52, 0.49], axis=1).max() < 1.5 / 7
    # The end is as good a place to begin for the opposite number.
    (other,) = defect_curves(mesh, -face_numbers(phases_of(mesh, turns * np.arctan2(y - 0.49, x - 0.52) + 5 * z)))
    np.testing.assert_array_equal(other.faces, curve.faces[::-1])


def test_a_ring_is_one_closed_curve():
    mesh = block((12, 12, 8))
    x, y, z = (mesh.vertices - [0.51, 0.49, 0.52]).T
    angles = np.arctan2(z, np.hypot(x, y) - 0.3)
    (curve,) = defect_curves(mesh, face_numbers(phases_of(mesh, angles)))
    assert curve.index == 1 and curve.is_closed
    middle = curve.points - [0.51, 0.49, 0.52]
    assert np.abs(np.hypot(middle[:, 0], middle[:, 1]) - 0.3).max() < 1.5 / 12
    around = np.unwrap(np.arctan2(middle[:, 1], middle[:, 0]))
    # Where the angle grows from outside upwards, the curve runs clockwise seen from above.
    assert around[-1] - around[0] == pytest.approx(-2 * np.pi, abs=0.7)


def turning(points, is_closed):
    """Sum of the angles at the points of a line."""
    if is_closed:
        points = np.vstack([points, points[:2]])
    steps = np.diff(points, axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    return np.arccos(np.clip(np.einsum("sx,sx->s", steps[1:], steps[:-1]), -1, 1)).sum()


@pytest.mark.parametrize("cells", [6, 12, 20])
def test_a_smooth_ring_turns_once_and_keeps_its_size(cells):
    mesh = block((cells, cells, cells // 2 + 2))
    x, y, z = (mesh.vertices - [0.51, 0.49, 0.52]).T
    (curve,) = defect_curves(mesh, face_numbers(phases_of(mesh, np.arctan2(z, np.hypot(x, y) - 0.3))))
    assert curve.is_closed and turning(curve.points, True) > 2 * cells * 2 * np.pi
    assert turning(curve.smooth_points, True) < 1.4 * 2 * np.pi
    given, smooth = (np.hypot(*(points[:, :2] - [0.51, 0.49]).T) for points in (curve.points, curve.smooth_points))
    between = np.linalg.norm(np.diff(curve.smooth_points, axis=0), axis=1).mean()
    assert 0 < given.mean() - smooth.mean() < between
    assert np.ptp(smooth) < np.ptp(given)


@pytest.mark.parametrize("cells", [7, 20])
def test_a_smooth_screw_axis_is_straight_and_keeps_its_ends(cells):
    mesh = block((cells, cells, cells - 2))
    x, y, z = mesh.vertices.T
    (curve,) = defect_curves(mesh, face_numbers(phases_of(mesh, np.arctan2(y - 0.49, x - 0.52) + 5 * z)))
    smooth = curve.smooth_points
    np.testing.assert_array_equal(smooth[[0, -1]], curve.points[[0, -1]])
    assert turning(curve.points, False) > 9 * np.pi
    assert turning(smooth, False) < 0.2


def test_curves_of_the_same_course_are_one_of_higher_index():
    """A tetrahedron through which the phase turns twice: no other faces for either turn."""
    mesh = block((1, 1, 1))
    tet = mesh.tet_faces[0]
    numbers = np.zeros(len(mesh.faces), int)
    orders = [[mesh.tets[0, c] for c in corners] for corners in ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))]
    even = [np.linalg.det(np.eye(3)[np.argsort(order)]) > 0 for order in orders]
    rims = np.flatnonzero(np.isin(tet, mesh.boundary_faces))[:2]
    for side, number in zip(rims, (2, -2), strict=True):
        numbers[tet[side]] = number if even[side] else -number
    (curve,) = defect_curves(mesh, numbers)
    assert curve.index == 2 and curve.faces.tolist() == [tet[rims[1]], tet[rims[0]]] and curve.tets.tolist() == [0]
