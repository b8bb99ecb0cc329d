# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ramps around screw dislocations are cut into sheets: no bead is printed before what lies below it."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.core.extract.layers.surfaces import layer_surfaces
from synch_fields.core.extract.lines.isolines import End, Isolines
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.interpolate import EdgePhases
from synch_fields.core.printing.beads import contour_beads
from synch_fields.core.printing.machine import Machine
from synch_fields.core.printing.plan import print_plan
from synch_fields.core.printing.ramps import Sheets, split_lines

from ..layered_solids import block
from .test_beads import SPACING, planes

PITCH, STEP = 0.25, 0.1


@pytest.fixture(scope="module")
def screw():
    """A block whose phase turns once around its middle: its layers are one ramp that rises by a pitch each turn."""
    solid = block((13, 13, 11), (1.3, 1.3, 1.1))
    x, y, z = solid.vertices.T
    phases = 2 * np.pi * z / PITCH + np.arctan2(y - 0.66, x - 0.66)
    asked = 2 * np.pi / PITCH * np.diff(z[solid.edges], axis=1)
    edge_phases = EdgePhases.of(solid, np.exp(1j * phases)[:, None], asked, np.zeros(len(asked), int))
    return solid, layer_surfaces(edge_phases, 2 * np.pi * z / PITCH)


def test_a_ramp_is_printed_upwards(screw):
    solid, surfaces = screw
    assert surfaces.count == 1
    beads = contour_beads(surfaces, STEP)
    plan = print_plan(surfaces, solid, beads, np.eye(4), Machine(), STEP, PITCH)
    assert 4 <= len(np.unique(plan.sheets)) <= 7
    pairs = cKDTree(plan.places[:, :2]).query_pairs(0.4 * STEP, output_type="ndarray")
    rises = np.diff(plan.places[pairs, 2], axis=1)[:, 0]
    # Points are in the order in which they are printed; of each pair the first one comes first.
    upon = np.abs(rises) > 0.6 * PITCH
    assert upon.sum() > 500 and (rises[upon] > 0).mean() > 0.98
    assert plan.lines.lengths.sum() == pytest.approx(beads.lines.lengths.sum(), rel=1e-9)
    assert (np.diff(plan.levels) >= 0).all() and plan.overhangs.mean() < 0.05


def test_layers_that_are_no_ramps_are_not_cut():
    solid, surfaces = planes((1, 0.8, 0.7))
    assert Sheets.find(surfaces, solid, SPACING) is None


def test_lines_are_cut_where_their_sheet_changes():
    """An open and a closed line on a plane; a part of a fifth of a step is not cut off."""
    corners = np.array([[0, 0, 0], [10, 0, 0], [0, 10, 0]], float)
    mesh = TriangleMesh(corners, [[0, 1, 2]])
    row = np.column_stack([np.linspace(0, 3, 31), np.zeros(31)])
    ring = 2 + np.column_stack([np.cos(np.linspace(0, 6, 60)), np.sin(np.linspace(0, 6, 60))])
    x, y = np.concatenate([row, ring]).T / 10
    weights = np.column_stack([1 - x - y, x, y])
    ends = np.array([[End.BOUNDARY] * 2, [End.CLOSED] * 2])
    lines = Isolines(mesh, np.zeros(91, int), weights, np.array([31, 60]), ends)
    sheets = np.concatenate([np.where(row[:, 0] < 1.05, 0, 1), np.where(ring[:, 0] < 2, 0, 1)])
    sheets[20:22] = 0
    made, of, points = split_lines(lines, sheets, 0.4)
    np.testing.assert_array_equal(np.sort(of), [0, 0, 1, 1])
    assert made.lengths.sum() == pytest.approx(lines.lengths.sum()) and not made.closed.any()
    assert made.lengths[:2] == pytest.approx([1.1, 1.9])
    np.testing.assert_allclose(made.points, lines.points[points])
