# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows that draw by a weight."""

import numpy as np
import pytest

from synch_fields.synch_addon import api

from ..constrained_sheet import line_upright, sheet
from ..scenes import (
    add_group,
    attribute,
    directions,
    places,
)


def balance(weight, wanted, length, area):
    """Turn of a field, held at 0, that is drawn to `wanted` at a distance: turn / length = weight / sqrt(area) sin."""
    low, high = 0.0, wanted
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (
            (middle, high) if middle / length < weight / np.sqrt(area) * np.sin(wanted - middle) else (low, middle)
        )
    return low


WEIGHTS = (0.0, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 1000.0)


@pytest.mark.parametrize("place", ["seams", "curve"])
def test_a_soft_angle_goes_from_free_to_fixed(place):
    """Held upright on the left, drawn by 50 degrees at a line a unit away: in one dimension a closed form."""
    obj = sheet()
    x = places(obj)[:, 0]
    hold, _, _ = line_upright(obj, "boundary")
    drawn, at, _ = line_upright(obj, place)
    angles = []
    for weight in WEIGHTS:
        soft = drawn | {"what": "angle", "degrees": 50, "weight": weight}
        api.directions(obj, target_gap=1e-4, constraints=[hold | {"what": "along"}, soft])
        there = directions(obj)[np.abs(x) < 1e-6]
        angle = (np.degrees(np.arctan2(-there[:, 0], there[:, 1])) + 90) % 180 - 90
        assert np.ptp(angle) < 1
        angles.append(angle.mean())
        expected = np.degrees(balance(weight, np.radians(100), 1.0 + at, 2 * 1.2)) / 2
        assert angles[-1] == pytest.approx(expected, abs=2.0 if place == "curve" else 0.5)
    assert angles[0] < 1e-3 and (np.diff(angles) > 0).all()
    if place == "seams":
        assert angles[-1] == pytest.approx(50, abs=0.1)


def test_a_soft_phase_goes_from_free_to_fixed():
    obj = sheet()
    x = places(obj)[:, 0]
    hold, _, _ = line_upright(obj, "boundary")
    add_group(obj, "right", np.flatnonzero(x > 0.99))
    free = 2 * np.pi * 2.0 / 0.4  # five periods
    turns = []
    for weight in WEIGHTS:
        # The right side runs up with the sheet on its left, where the phase falls from its value on.
        soft = {"where": "boundary", "what": "phase", "name": "right", "degrees": -110, "weight": weight}
        api.stripes(obj, spacing=0.4, target_gap=1e-4, constraints=[hold | {"what": "phase"}, soft])
        vertices = np.array([loop.vertex_index for loop in obj.data.loops])
        phase = attribute(obj, "synch_phase").astype(float)[np.isin(vertices, np.flatnonzero(x > 0.99))]
        turn = np.degrees(np.arccos(np.clip(np.cos(phase - free), -1, 1)))
        assert np.ptp(turn) < 0.1
        turns.append(turn.mean())
        assert turns[-1] == pytest.approx(np.degrees(balance(weight, np.radians(110), 2.0, 2 * 1.2)), abs=1.0)
    assert turns[0] < 0.01 and (np.diff(turns) > 0).all()
    assert turns[-1] == pytest.approx(110, abs=0.2)
