# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields that are free to turn as a whole follow the principal directions, and others stay."""

import numpy as np
import pytest

from synch_fields.core.fields import DirectionWishes, direction_field
from synch_fields.core.fields.directions import along_curvature
from synch_fields.core.solve import Options

from ..direction_wishes import boundary_row
from ..meshes import disk, together, torus


def off_axes(field):
    """(n,) radians from crosses to the direction around each ring's axis, which is a principal one."""
    x, y, _ = (field.mesh.vertices - np.outer(field.mesh.pieces, [5.0, 0, 0])).T  # see together
    around = np.column_stack([-y, x, np.zeros_like(x)]) / np.hypot(x, y)[:, None]
    first, second = field.mesh.tangent_frames
    expected = np.arctan2(np.einsum("nx,nx->n", around, second), np.einsum("nx,nx->n", around, first))
    return np.abs((field.angles - expected + np.pi / 4) % (np.pi / 2) - np.pi / 4)


def calm(mesh, rows=()):
    return direction_field(mesh, 4, DirectionWishes(rows=rows, singularities=0.0))


@pytest.mark.parametrize("turn", [0.0, 0.3, 0.7])
def test_crosses_on_a_ring_follow_its_circles_at_the_same_energy(turn):
    field = calm(torus())
    field = field.with_phases(np.exp(4j * (field.angles + turn)))
    after = along_curvature(field)
    assert off_axes(after).max() < 0.02 and off_axes(after.turned(0.3)).max() > 0.2
    assert after.energy == pytest.approx(field.energy, rel=1e-12)


def test_each_piece_turns_by_itself():
    mesh = together(torus(), torus())
    field = calm(mesh)
    turns = np.where(mesh.pieces == 0, 0.2, 0.5)
    assert off_axes(along_curvature(field.with_phases(np.exp(4j * (field.angles + turns))))).max() < 0.02


def test_directions_that_a_line_holds_stay():
    mesh = disk()
    field = direction_field(mesh, 4, DirectionWishes(rows=(boundary_row(mesh, "along"),)), Options(method="spectral"))
    np.testing.assert_array_equal(along_curvature(field).angles, field.angles)
