# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls, skins and sparse lines against lengths in closed form, and against distances from the solid's boundary."""

from itertools import pairwise

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.extract.layers.surfaces import layer_surfaces
from synch_fields.core.fields.guidance.solids import axis_directions
from synch_fields.core.fields.layers import solve_layers
from synch_fields.core.printing.beads import contour_beads
from synch_fields.core.printing.infill import sparse_beads
from synch_fields.core.printing.machine import Machine
from synch_fields.core.tasks.layer_outputs import PathSettings

from ..layered_solids import block, group_of, shell

STEP, SPACING, SIZE, HEIGHT = 0.4, 0.4, 12.0, 4.8
WALL, INNER, GAP, SPARSE = range(4)


@pytest.fixture(scope="module")
def cuboid():
    """Layers of a cuboid at 0.2, 0.6, ..., 4.6, and the beads that fill it."""
    solid = block((6, 6, 12), (SIZE, SIZE, HEIGHT))
    floor = group_of(solid, solid.vertices[:, 2] == 0, np.pi)
    pattern = solve_layers(solid, axis_directions(solid, (0, 0, 1)), SPACING, [floor])
    surfaces = layer_surfaces(pattern.edge_phases, pattern.heights)
    assert surfaces.count == 12
    return solid, surfaces, contour_beads(surfaces, STEP)


def lengths(beads, layer, *kinds):
    return beads.lines.lengths[(beads.layers == layer) & np.isin(beads.kinds, kinds)].sum()


@pytest.mark.parametrize("walls, skins, infill", [(2, 3, 0.2), (1, 2, 0.1), (3, 0, 0.4)])
def test_a_cuboid_has_walls_skins_and_its_share_of_lines(cuboid, walls, skins, infill):
    solid, surfaces, full = cuboid
    beads = sparse_beads(surfaces, solid, full, STEP, SPACING, Machine(walls=walls, skins=skins, infill=infill))
    rings = sum(4 * (SIZE - (2 * number + 1) * STEP) for number in range(walls))
    between = SIZE - 2 * walls * STEP
    for layer in range(surfaces.count):
        # The middle of a layer is half a spacing above its floor.
        if min(layer, surfaces.count - 1 - layer) < skins:
            assert lengths(beads, layer, WALL, INNER, GAP) == pytest.approx(lengths(full, layer, WALL, INNER, GAP))
            assert lengths(beads, layer, SPARSE) == 0
        else:
            assert lengths(beads, layer, WALL, INNER) == pytest.approx(rings, rel=1e-2)
            assert lengths(beads, layer, SPARSE) == pytest.approx(between**2 * infill / STEP, rel=0.08)
    assert np.allclose(beads.widths[(beads.kinds == SPARSE)[beads.lines.numbers]], STEP)


def test_lines_of_neighbouring_layers_cross_and_end_in_the_innermost_wall(cuboid):
    solid, surfaces, full = cuboid
    beads = sparse_beads(surfaces, solid, full, STEP, SPACING, Machine(walls=2, skins=3, infill=0.2))
    lines, ways = beads.lines, []
    for layer in range(3, 9):  # at any height, from the floor and from the origin
        number = np.flatnonzero((beads.layers == layer) & (beads.kinds == SPARSE))
        assert len(number) > 5
        starts, ends = lines.points[lines.starts[number]], lines.points[(lines.starts + lines.sizes - 1)[number]]
        ways.append((ends - starts)[0] / np.linalg.norm((ends - starts)[0]))
        # The wall's middle is 0.6 from the rim, its inner side 0.8.
        for places in (starts, ends):
            deep = np.minimum(places, SIZE - places)[:, :2].min(axis=1)
            assert (np.abs(deep - 0.7) < 0.1).all()
    assert np.abs([one @ other for one, other in pairwise(ways)]).max() < 1e-6


def spheres():
    """A thick shell, its layers, which are spheres inside one another, and their beads without infill."""
    solid = shell(np.linspace(0.6, 2, 8), 2)
    radius = np.linalg.norm(solid.vertices, axis=1)
    group = group_of(solid, radius < 0.61, np.pi)
    pattern = solve_layers(solid, solid.vertices / radius[:, None], 0.2, [group])
    surfaces = layer_surfaces(pattern.edge_phases, pattern.heights)
    full = contour_beads(surfaces, 0.2)
    return solid, surfaces, full


def test_lines_cross_in_layers_that_are_closed():
    """The mean height of spheres inside one another is the same: their levels tell which lines are turned."""
    solid, surfaces, full = spheres()
    lines = sparse_beads(surfaces, solid, full, 0.2, 0.2, Machine(walls=0, skins=0, infill=0.2)).lines
    ways, points = lines.points[lines.next] - lines.points, lines.points
    at_pole = np.abs(points[:, 2]) > 0.9 * np.linalg.norm(points, axis=1)
    of = surfaces.layers[lines.triangles]
    turns = [np.sign((ways[at_pole & (of == k)][:, 0] * ways[at_pole & (of == k)][:, 1]).sum()) for k in range(7)]
    np.testing.assert_array_equal(np.abs(np.diff(turns)), 2)


def test_skins_of_curved_layers_follow_their_normals():
    """Spheres inside one another: layers are whole near the inner and the outer side, sparse half way."""
    solid, surfaces, full = spheres()
    beads = sparse_beads(surfaces, solid, full, 0.2, 0.2, Machine(walls=1, skins=2, infill=0.25))
    assert surfaces.count == 7
    for layer in range(surfaces.count):
        whole, of = lengths(full, layer, WALL, INNER, GAP), lengths(beads, layer, WALL, INNER, GAP)
        if layer in (2, 3, 4):
            # Planes a distance apart would cut a sphere in pi / 4 times as much length.
            assert of < 0.1 * whole
            assert lengths(beads, layer, SPARSE) == pytest.approx(0.25 * whole, rel=0.05)
        else:
            assert of == pytest.approx(whole) and lengths(beads, layer, SPARSE) == 0


def test_no_infill_leaves_the_core_empty(cuboid):
    solid, surfaces, full = cuboid
    beads = sparse_beads(surfaces, solid, full, STEP, SPACING, Machine(walls=2, skins=3, infill=0))
    assert (beads.kinds != SPARSE).all() and lengths(beads, 6, WALL, INNER) > 0
    assert (np.diff(beads.layers) >= 0).all()


@pytest.mark.parametrize(
    "settings, reason",
    [
        ({"infill": 1.5}, "the infill is 1.5: give a share from 0 to 1"),
        ({"infill": -0.1}, "the infill is -0.1"),
        ({"walls": -1}, "the walls is -1"),
        ({"skins": -2}, "the skins is -2"),
        ({"walls": 0, "skins": 0, "infill": 0}, "are all 0: give one of them"),
    ],
)
def test_shares_and_numbers_out_of_range_are_refused(settings, reason):
    with pytest.raises(SettingError, match=reason):
        Machine(**settings)


def test_lines_across_an_axis_have_no_walls():
    with pytest.raises(SettingError, match=r"an infill of 0\.2 needs walls: choose the fill contour"):
        PathSettings(fill="across-x", machine=Machine(infill=0.2))
