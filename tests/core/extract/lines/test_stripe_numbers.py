# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers of stripes and coordinates along them, as a shader reads them: closed forms, and from face to face."""

import numpy as np
import pytest

from synch_fields.core.extract.lines.isolines import isolines
from synch_fields.core.extract.lines.stripe_numbers import SLOTS, StripeNumbers, slot_numbers, stripe_table
from synch_fields.core.fields import direction_field, given_directions, stripe_pattern
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.interpolate import TURN, EdgePhases, evaluate, face_phases

from ...meshes import annulus, cylinder, icosphere, quad_torus, square, torus
from ..quads.test_cells import SURFACES, flooded, has_defect, solved
from .test_isolines import plane_stripes


def table_of(edge_phases, spacing):
    """The table, the polygons and the phases that it belongs to, and the lines."""
    polygons = Polygons.of_triangles(edge_phases.mesh)
    (phase,) = face_phases(edge_phases, polygons)
    lines = isolines(edge_phases).resampled(0.1 * spacing)
    return stripe_table(phase, polygons, lines, spacing), polygons, phase, lines


def read(table, polygons, phase, triangles, weights):
    """What the shader finds at places: number, place across from -1/2 to 1/2 and along."""
    periods = evaluate(phase, polygons, triangles, weights) / TURN
    period = np.rint(periods).astype(int)
    numbers = table.numbers[polygons.triangle_faces[triangles], period % SLOTS]
    corners = table.along[polygons.triangle_corners[triangles]]
    along = np.einsum("nk,nks->ns", weights, corners)[np.arange(len(triangles)), period % SLOTS]
    return np.abs(numbers), np.sign(numbers) * (periods - period), along


def random_places(polygons, count, seed=0):
    random = np.random.default_rng(seed)
    return random.integers(0, len(polygons.triangle_faces), count), random.dirichlet(np.ones(3), count)


@pytest.mark.parametrize("degrees", [0, 20, 75])
def test_in_the_plane_stripes_are_straight_and_coordinates_are_lengths(degrees):
    mesh, spacing, origin = square(12), 0.21, np.array([0.03, 0.02, 0])
    table, polygons, phase, lines = table_of(plane_stripes(mesh, degrees, spacing, origin), spacing)
    triangles, weights = random_places(polygons, 4000)
    places = np.einsum("nk,nkx->nx", weights, mesh.vertices[polygons.triangles[triangles]]) - origin
    angle = np.radians(degrees)
    level = (np.cos(angle) * places[:, 1] - np.sin(angle) * places[:, 0]) / spacing
    way = (np.cos(angle) * places[:, 0] + np.sin(angle) * places[:, 1]) / spacing
    number, across, along = read(table, polygons, phase, triangles, weights)
    assert number.min() == 1 and set(range(1, len(lines.sizes) + 1)) <= set(number)
    for one in range(1, len(lines.sizes) + 1):
        mine = number == one
        (stripe,) = np.unique(np.rint(level[mine]))
        # The line may run either way, and the place across turns with it.
        turn = np.sign((across * (level - stripe))[mine].sum())
        np.testing.assert_allclose(turn * across[mine], level[mine] - stripe, atol=1e-9)
        # Beyond the ends of a line there is no more of it to be nearest to.
        line = lines.chosen(np.arange(len(lines.sizes)) == one - 1)
        ends = (line.points - origin) @ [np.cos(angle), np.sin(angle), 0] / spacing
        inside = mine & (way > ends.min() + 1) & (way < ends.max() - 1)
        if inside.any():
            off = along[inside] - turn * way[inside]
            np.testing.assert_allclose(off, off[0], atol=1e-6)


def test_neighbours_run_the_same_way_and_in_step():
    mesh, spacing = square(16), 0.1
    table, polygons, phase, lines = table_of(plane_stripes(mesh, 0, spacing), spacing)
    triangles, weights = random_places(polygons, 3000)
    x = np.einsum("nk,nk->n", weights, mesh.vertices[polygons.triangles[triangles]][:, :, 0])
    number, _, along = read(table, polygons, phase, triangles, weights)
    known = (number <= len(lines.sizes)) & (x > 0.15) & (x < 0.85)
    rise = np.polyfit(x[known], along[known], 1)[0]
    assert abs(rise) == pytest.approx(1 / spacing, rel=1e-6)
    steps = np.exp(1j * TURN * (along[known] - np.sign(rise) * x[known] / spacing))
    np.testing.assert_allclose(steps, steps[0], atol=1e-6)


def test_closed_stripes_hold_whole_lengths_and_go_on_where_they_close():
    mesh, spacing = cylinder(height=2.0, segments=40, rows=20), 0.4
    around = np.cross([0, 0, 1], mesh.vertices * [1, 1, 0])
    pattern = stripe_pattern(mesh, given_directions(mesh, 2, around), spacing)
    table, polygons, phase, lines = table_of(pattern.edge_phases, spacing)
    assert lines.closed.all()
    triangles, weights = random_places(polygons, 4000)
    places = np.einsum("nk,nkx->nx", weights, mesh.vertices[polygons.triangles[triangles]])
    number, _, along = read(table, polygons, phase, triangles, weights)
    turn = np.arctan2(places[:, 1], places[:, 0]) / TURN
    whole = round(2 * np.pi / spacing)
    for one in range(1, len(lines.sizes) + 1):
        mine = number == one
        step = min(
            (np.exp(1j * TURN * (along[mine] - sign * whole * turn[mine])) for sign in (1, -1)),
            key=lambda values: values.std(),
        )
        assert mine.sum() > 100 and np.abs(step - step.mean()).max() < 0.2


@pytest.mark.parametrize("build", [lambda: icosphere(4), torus])
def test_numbers_and_coordinates_go_on_from_face_to_face(build):
    mesh = build()
    spacing = 5 * mesh.edge_lengths.mean()
    pattern = stripe_pattern(mesh, direction_field(mesh, 2), spacing)
    table, polygons, phase, _ = table_of(pattern.edge_phases, spacing)
    sides = {}
    ends = np.stack([mesh.triangles, np.roll(mesh.triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    for half, (tail, head) in enumerate(ends.tolist()):
        sides.setdefault((min(tail, head), max(tail, head)), []).append((half, tail < head))
    pairs = np.array([sorted(both) for both in sides.values() if len(both) == 2])
    seen = []
    for side in (0, 1):
        half, forward = pairs[:, side].T
        values = []
        for share in np.linspace(0.05, 0.95, 10):
            weights = np.zeros((len(half), 3))
            rows, tail = np.arange(len(half)), half % 3
            from_tail = np.where(forward, share, 1 - share)
            weights[rows, tail], weights[rows, (tail + 1) % 3] = 1 - from_tail, from_tail
            values.append(read(table, polygons, phase, half // 3, weights))
        seen.append(np.array(values).transpose(1, 0, 2).reshape(3, -1))
    first, second = seen
    in_middle = (np.abs(first[1]) < 0.45) & (first[0] > 0) & (second[0] > 0)
    assert in_middle.mean() > 0.8
    same = in_middle & (first[0] == second[0])
    assert same.sum() / in_middle.sum() > 0.985  # elsewhere stripes end
    off = np.abs(first[2] - second[2])[same]
    assert np.mean(np.abs(off - np.rint(off)) < 1e-6) > 0.98
    assert np.mean(np.abs(first[1] - second[1])[same] < 1e-6) > 0.95  # not where the two sides are one


STRIPED = SURFACES | {"torus": lambda: (torus(), Polygons.of_triangles(torus())), "quads-torus": quad_torus}


@pytest.mark.parametrize("name", STRIPED)
def test_a_flood_along_the_middles_of_stripes_stays_in_one_and_meets_its_line(name):
    pattern, polygons, phases = solved(STRIPED[name], 2, 9)
    lines = isolines(pattern.edge_phases).resampled(0.02 * pattern.edge_phases.mesh.edge_lengths.mean())
    number = StripeNumbers(phases[0], polygons, slot_numbers(phases[0], polygons, lines))
    triangles, weights, floods = flooded(phases, polygons)
    numbers = number.at(triangles, weights)
    assert number.at(*random_places(polygons, 100_000)).min() > 0
    met = np.unique(np.column_stack([floods, numbers]), axis=0)
    assert len(met) > 5
    assert (np.bincount(met[:, 0]) <= 1).all(), "one region with two numbers"
    at = np.flatnonzero(~has_defect(phases, polygons)[lines.triangles])
    same = (polygons.triangles[lines.triangles[at]] == lines.mesh.triangles[lines.triangles[at]]).all()
    assert same, "lines were traced on other triangles"
    found = number.at(lines.triangles[at], lines.weights[at])
    # A face of many corners, over which the phase bends, may hold two lines in one slot.
    assert np.mean(found == lines.numbers[at] + 1) >= (0.998 if name == "mixed" else 1)


def striped(mesh, growing, turning=0.0):
    """Stripes where ``growing + turning``, in periods at the vertices, is a whole number; ``turning`` wraps around.

    Returns the phase, how many lines and numbers there are, and at the middle of each triangle the number and the
    periods less the nearest whole one.
    """
    i, j = mesh.edges.T
    turning = np.broadcast_to(turning, len(growing))
    changes = growing[j] - growing[i] + (turning[j] - turning[i] + 0.5) % 1 - 0.5
    values = 2 * np.pi * (growing + turning)[:, None]
    edge_phases = EdgePhases(mesh, values, 2 * np.pi * changes[:, None], np.zeros(len(i), int))
    polygons = Polygons.of_triangles(mesh)
    (phase,) = face_phases(edge_phases, polygons)
    lines = isolines(edge_phases).resampled(0.02)
    number = StripeNumbers(phase, polygons, slot_numbers(phase, polygons, lines))
    middle = np.arange(mesh.triangle_count), np.full((mesh.triangle_count, 3), 1 / 3)
    periods = evaluate(phase, polygons, *middle) / TURN
    counts = len(lines.sizes), number.count
    return phase, counts, number.at(*middle), periods - np.rint(periods)


def test_parallel_stripes_have_one_number_each_and_so_have_those_whose_middle_is_beyond_the_boundary():
    mesh = square(12)
    across = 5.2 * (mesh.vertices[:, 0] - 0.5)
    _, counts, numbers, _ = striped(mesh, across)
    # Lines at -2 ... 2 periods from the middle of the square, and a fringe without one at either side.
    assert counts == (5, 7)
    period = np.rint(across[mesh.triangles].mean(axis=1))
    assert {len(np.unique(period[numbers == number])) for number in np.unique(numbers)} == {1}
    assert {len(np.unique(numbers[period == whole])) for whole in np.unique(period)} == {1}


def test_vertices_may_be_so_many_that_three_do_not_fit_into_one_number():
    small, loose = square(6), 2**21
    large = TriangleMesh(np.pad(small.vertices, ((loose, 0), (0, 0))), small.triangles + loose)
    found = [striped(mesh, 5.2 * mesh.vertices[:, 0]) for mesh in (small, large)]
    assert found[0][1] == found[1][1]
    np.testing.assert_array_equal(found[0][2], found[1][2])


def test_rings_are_counted_and_a_spiral_is_one_stripe():
    mesh = annulus(1.0, 2.0, rings=24, segments=96)
    radius = np.linalg.norm(mesh.vertices[:, :2], axis=1)
    _, counts, numbers, _ = striped(mesh, 4 * radius + 0.5)
    assert counts == (4, 4) and set(numbers) == {1, 2, 3, 4}
    turn = np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0]) / (2 * np.pi)
    _, _, numbers, off = striped(mesh, 4 * radius, turn)  # once around, and so one line from rim to rim
    assert len(np.unique(numbers[np.abs(off) < 0.2])) == 1


def test_a_stripe_that_ends_in_a_dislocation_has_a_number_of_its_own():
    mesh = square(24)
    x, y = (mesh.vertices[:, :2] - (0.51, 0.507)).T
    phase, _, numbers, off = striped(mesh, 4 * x + 0.064, np.arctan2(y, x) / (2 * np.pi))
    assert np.abs(phase.index).sum() == 1
    across, height = (values[mesh.triangles].mean(axis=1) for values in (x, y))
    shown = (np.abs(off) < 0.2) & (across < 0.4)  # at the right, another line comes in from the side
    below, above = (set(numbers[shown & side]) for side in (height < -0.47, height > 0.45))
    assert len(below) == 4 and len(above) == 3
    assert above < below
