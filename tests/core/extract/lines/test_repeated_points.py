# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Isolines without points that repeat one another."""

import numpy as np
import pytest

from synch_fields.core.extract.lines.isolines import End, Isolines, isolines
from synch_fields.core.geometry import TriangleMesh

from ...meshes import square
from ...plane_stripes import plane_stripes


def test_lines_through_vertices_are_cleared_of_repeated_points():
    lines = isolines(plane_stripes(square(8), 0, 0.25))
    assert lines.steps[lines.next != np.arange(len(lines.triangles))].min() < 1e-6
    clear = lines.without_repeats(1e-4)
    assert clear.steps[clear.next != np.arange(len(clear.triangles))].min() > 0.05
    np.testing.assert_array_equal(clear.ends, lines.ends)
    np.testing.assert_allclose(clear.lengths, lines.lengths, atol=1e-6)


@pytest.mark.parametrize("closed", [True, False])
def test_lines_of_many_short_pieces_keep_their_course(closed):
    """Each piece is shorter than the distance: a point stays at about each distance, as one walk along tells."""
    turn = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    fan = TriangleMesh(
        np.vstack([[[0, 0, 0]], np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])]),
        np.column_stack([np.zeros(400, int), 1 + np.arange(400), 1 + (np.arange(400) + 1) % 400]),
    )
    ends = [End.CLOSED] * 2 if closed else [End.BOUNDARY] * 2
    lines = Isolines(fan, np.arange(400), np.tile([0.5, 0.5, 0], (400, 1)), np.array([400]), np.array([ends]))
    clear = lines.without_repeats(0.1)
    steps = clear.steps[: len(clear.triangles) - (not closed)]
    assert steps.min() > 0.0999 and steps.max() < 0.2
    assert len(clear.triangles) == 30 + (not closed)  # thirteen pieces to the next, of 400
    first = [0] if closed else [0, 399]
    assert np.isin(first, clear.triangles).all()
