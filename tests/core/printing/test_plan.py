# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is said of a print is true where the answer is known: heights, order, air below, a staircase's collisions."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.extract.layers.surfaces import layer_surfaces
from synch_fields.core.fields.guidance.solids import axis_directions
from synch_fields.core.fields.layers import solve_layers
from synch_fields.core.geometry.tet_mesh import TetMesh
from synch_fields.core.printing.beads import contour_beads
from synch_fields.core.printing.heights import NOTHING, OUTSIDE, below
from synch_fields.core.printing.machine import Machine
from synch_fields.core.printing.order import layer_order, order_lines
from synch_fields.core.printing.plan import print_plan
from synch_fields.core.printing.reach import collisions, tilts, tool_axes

from ..layered_solids import group_of
from .test_beads import SPACING, planes, spheres

UPRIGHT = Machine(nozzle_radius=0.01, nozzle_angle=45, nozzle_length=10, largest_tilt=30)
TURNED = np.array([[1.0, 0, 0, 5], [0, 0, -1, 6], [0, 1, 0, 7], [0, 0, 0, 1]])  # Z to -Y, Y up


def planned(found, matrix=None, machine=UPRIGHT, step=0.2):
    mesh, surfaces = found
    matrix = np.eye(4) if matrix is None else matrix
    return print_plan(surfaces, mesh, contour_beads(surfaces, step), matrix, machine, step, SPACING)


def test_beads_reach_half_way_to_the_next_layer_and_to_the_ends_of_the_solid():
    """Of layers at 0, 0.3 and 0.6 in a block 0.7 high: all of it belongs to a bead."""
    plan = planned(planes((1, 0.8, 0.7)))
    layers = plan.layers[plan.lines.numbers]
    np.testing.assert_allclose(plan.down, np.array([0, 0.15, 0.15])[layers], atol=1e-3)
    np.testing.assert_allclose(plan.up, np.array([0.15, 0.15, 0.1])[layers], atol=1e-3)
    np.testing.assert_allclose(plan.tips[:, 2], plan.places[:, 2] + plan.up, atol=1e-9)
    assert plan.printed_volume == pytest.approx(plan.volume, rel=0.01) and plan.volume == pytest.approx(0.56)
    # Nothing is printed at the height of the bed.
    assert plan.course.points[:, 2].min() == pytest.approx(0.15, abs=1e-3)
    np.testing.assert_array_equal(plan.below.layers, np.where(layers == 0, OUTSIDE, layers - 1))
    assert not plan.overhangs.any() and not plan.collided.any()
    np.testing.assert_allclose(plan.tilts, 0, atol=1e-4)
    assert plan.shares.sum() == pytest.approx(1)


def test_heights_of_spheres_are_their_distance():
    mesh, surfaces = spheres()
    points = surfaces.vertices[surfaces.triangles].mean(axis=1)
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    found = below(surfaces, mesh, points, normals, surfaces.layers, SPACING)
    np.testing.assert_allclose(found.heights[surfaces.layers > 0], SPACING, atol=0.02)
    np.testing.assert_array_equal(found.layers[surfaces.layers > 0], surfaces.layers[surfaces.layers > 0] - 1)
    # From the outermost one outwards there is the end of the solid, at once.
    out = below(surfaces, mesh, points, -normals, surfaces.layers, SPACING)
    assert (out.layers[surfaces.layers == 2] == OUTSIDE).all() and out.heights[surfaces.layers == 2].max() < 1e-6
    inner = surfaces.layers == 0
    away = below(surfaces, mesh, 5 * points[inner], normals[inner], surfaces.layers[inner], SPACING)
    assert (away.layers == NOTHING).all() and (away.heights == pytest.approx(3 * SPACING))


def test_layers_that_lie_beside_the_bed_are_on_air():
    """A block on its side: the lowest layer stands upright, and is carried on the bed alone."""
    plan = planned(planes((1, 0.8, 0.7)), TURNED)
    layers, heights = plan.layers[plan.lines.numbers], plan.lines.points[:, 1]
    np.testing.assert_array_equal(plan.overhangs, (layers == 0) & (heights >= 0.5 * SPACING))
    np.testing.assert_allclose(plan.tilts, 90, atol=1e-4)
    np.testing.assert_allclose(plan.course.points[:, 2], heights, atol=1e-9)
    runs = plan.runs_of(plan.overhangs)
    np.testing.assert_array_equal(np.sort(np.concatenate(runs)), np.flatnonzero(plan.overhangs))
    assert all((np.diff(run) == 1).all() and len(np.unique(plan.lines.numbers[run])) == 1 for run in runs)


def test_what_carries_comes_first():
    np.testing.assert_array_equal(layer_order(4, [0, 2], [3, 1]), [1, 2, 3, 0])
    np.testing.assert_array_equal(layer_order(3, [], []), [0, 1, 2])
    np.testing.assert_array_equal(layer_order(3, [0, 1], [1, 0]), [2, 0, 1])  # a circle: the lowest number first


def test_arranged_lines_are_the_same_lines():
    _, surfaces = planes((1, 0.8, 0.7))
    beads = contour_beads(surfaces, 0.2)
    made, chosen, points = order_lines(beads.lines, beads.layers, np.arange(surfaces.count)[::-1])
    assert (np.diff(beads.layers[chosen]) <= 0).all()
    np.testing.assert_array_equal(np.sort(points), np.arange(len(points)))
    np.testing.assert_allclose(made.points, beads.lines.points[points])
    np.testing.assert_allclose(made.lengths, beads.lines.lengths[chosen])
    for start, size in zip(made.starts[1:], made.sizes[1:], strict=True):  # each begins at its nearest place
        last = made.numbers[start] - 1
        here = made.points[made.starts[last] if made.closed[last] else start - 1]
        ways = np.linalg.norm(made.points[start : start + size] - here, axis=1)
        assert ways[0] == pytest.approx(ways.min() if made.closed[last + 1] else min(ways[0], ways[-1]))


def test_seams_at_the_back_lie_upon_each_other():
    plan = planned(planes((1, 0.8, 0.7)), machine=replace(UPRIGHT, seam="back"))
    lines = plan.lines
    begins = plan.places[lines.starts][lines.closed & (plan.kinds == 0)]
    assert len(begins) == 3
    np.testing.assert_allclose(begins[:, :2], [[0.1, 0.7]] * 3, atol=0.03)


def staircase(step=0.1, rise=0.5, run=1.0, stairs=3):
    """Places on the treads of stairs, the highest one printed first: (n, 3)."""
    rows = []
    for stair in range(stairs):
        x = run * stair + step * (np.arange(round(run / step)) + 0.5)
        y = step * np.arange(5)
        rows.append(np.array([(a, b, -rise * stair) for a in x for b in y]))
    return np.concatenate(rows)


@pytest.mark.parametrize("angle", [20.0, 45.0, 60.0])
def test_the_tool_meets_the_stairs_above_it(angle):
    """A tread is met from as far as the cone is wide at its height, and those above it from farther away."""
    rise, step = 0.5, 0.1
    machine = Machine(nozzle_radius=0.03, nozzle_angle=angle, nozzle_length=10)
    points = staircase(step, rise)
    met = collisions(points, np.tile([0.0, 0, 1], (len(points), 1)), machine, step, 0.05)
    stair = np.rint(-points[:, 2] / rise).astype(int)
    expected = np.zeros(len(points), bool)
    for above in (1, 2):
        # The last row of the tread above lies half a step before its end.
        gap = points[:, 0] - (stair - above + 1 - step / 2)
        expected |= (stair >= above) & (gap < 0.03 + above * rise * np.tan(np.radians(angle)))
    np.testing.assert_array_equal(met >= 0, expected)
    assert expected.any() and not expected.all()
    where = np.flatnonzero(met >= 0)
    assert (met[where] < where).all() and (stair[met[where]] < stair[where]).all()


def first_met(points, axes, machine, slack):
    """(n,) the first earlier place in each tool's cone, by looking at all of them; -1 for none."""
    met = np.full(len(points), -1)
    for number, (tip, axis) in enumerate(zip(points, axes, strict=True)):
        offsets = points[:number] - tip
        above = offsets @ axis
        aside = np.linalg.norm(np.cross(offsets, axis), axis=1)
        inside = (above > slack) & (np.linalg.norm(offsets, axis=1) <= machine.nozzle_length)
        inside &= aside < machine.nozzle_radius + above * np.tan(np.radians(machine.nozzle_angle))
        met[number] = np.append(np.flatnonzero(inside), -1)[0]
    return met


@pytest.mark.parametrize("turns", [False, True])
@pytest.mark.parametrize("angle", [15.0, 50.0, 80.0])
def test_the_tool_meets_what_a_look_at_every_place_finds(angle, turns):
    """Places at random and tools that lean at random: some meet much, some nothing."""
    random = np.random.default_rng(0)
    points = random.uniform(0, [4, 3, 2], (600, 3))
    machine = Machine(axes="ac" if turns else "xyz", nozzle_radius=0.02, nozzle_angle=angle, nozzle_length=1.5)
    leaning = random.normal(0, 0.4, (600, 3)) * turns + [0, 0, 1]
    axes = leaning / np.linalg.norm(leaning, axis=1, keepdims=True)
    # Steps so large that all places are near, and so small that every place is looked at.
    for step in (0.5, 1e-3):
        met = collisions(points, axes, machine, step, 0.1)
        np.testing.assert_array_equal(met, first_met(points, axes, machine, 0.1))
    assert 0.05 < (met >= 0).mean() < 0.999


def test_printed_upwards_the_stairs_are_in_nobodys_way():
    points = staircase()[::-1]
    axes = np.tile([0.0, 0, 1], (len(points), 1))
    assert (collisions(points, axes, Machine(nozzle_radius=0.03), 0.1, 0.05) < 0).all()
    assert (collisions(points[::-1], axes, Machine(nozzle_radius=0.03, nozzle_length=0.4), 0.1, 0.05) < 0).all()


def test_tools_stand_along_normals_as_far_as_they_tilt():
    normals = np.array([[0, 0, 1], [0.6, 0, 0.8], [0, -1, 0], [0, 0, -1]], float)
    np.testing.assert_allclose(tilts(normals), [0, np.degrees(np.arctan(0.75)), 90, 180])
    np.testing.assert_array_equal(tool_axes(normals, UPRIGHT), np.tile([0, 0, 1], (4, 1)))
    axes = tool_axes(normals, Machine(axes="ac", largest_tilt=60))
    np.testing.assert_allclose(axes[:2], normals[:2], atol=1e-12)
    np.testing.assert_allclose(axes[2], [0, -np.sqrt(0.75), 0.5], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(axes[:3], axis=1), 1)


def test_a_bead_leans_on_a_layer_up_to_45_degrees_aside():
    """A cone on its tip, widening by as much as an angle has it: all layers lean where it is below 45 degrees."""
    for slope, some in ((0.6, False), (1.6, True)):
        mesh, _ = planes((0.4, 0.4, 0.35), (4, 4, 3))
        wide = mesh.vertices.copy()
        wide[:, :2] = (wide[:, :2] - 0.2) * (1 + 5 * slope * wide[:, 2:])
        mesh = TetMesh(wide, mesh.tets)
        floor = group_of(mesh, mesh.vertices[:, 2] == 0, 0.0)
        pattern = solve_layers(mesh, axis_directions(mesh, (0, 0, 1)), 0.1, [floor])
        surfaces = layer_surfaces(pattern.edge_phases, pattern.heights)
        plan = print_plan(surfaces, mesh, contour_beads(surfaces, 0.1), np.eye(4), UPRIGHT, 0.1, 0.1)
        assert plan.overhangs.any() == some
        if some:
            found = np.abs(plan.lines.points[plan.overhangs, :2]).max(axis=1)
            heights = plan.lines.points[plan.overhangs, 2]
            # Only near the rim, which moves out by a quarter from layer to layer.
            assert (found > 0.2 * (1 + 5 * slope * heights) - 0.26).all()


def test_a_print_without_places_meets_nothing():
    assert collisions(np.zeros((0, 3)), np.zeros((0, 3)), Machine(), 0.1, 0.05).shape == (0,)
