# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs as a printer that reads nothing else runs them: the tip between points, the table's turns, refusals."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.bench.gcode_simulator import (
    Beads,
    deviations,
    moves_through,
    on_part,
    read_moves,
    sampled,
    turn_speed,
)
from synch_fields.core.errors import SettingError
from synch_fields.core.printing.gcode import GAP, SKIRT, WALL, Course, gcode
from synch_fields.core.printing.kinematics import table_angles, to_machine, to_part, tool_directions
from synch_fields.core.printing.machine import MACHINES, Machine, read_machine

FIVE = Machine(axes="ac", pivot_z=-35.0, feed=1200, turn_speed=90, turn_acceleration=2000, start="")


def turned(degrees):
    """(n, 3) tools that lean by degrees towards Y."""
    angles = np.radians(degrees)
    return np.column_stack([0 * angles, np.sin(angles), np.cos(angles)])


def course(points, tools, runs=None, layers=None):
    count = len(points)
    runs = [np.arange(count)] if runs is None else runs
    layers = np.zeros(len(runs), int) if layers is None else layers
    kinds = [WALL] * len(runs)
    return Course(points, tools, points, np.full(count, 0.5), np.full(count, 0.2), runs, layers, 0.5, kinds, layers)


def ridge(count=2):
    """One bead of 1.9 mm over a ridge: the tool from 45 degrees on one side to 45 on the other."""
    points = np.column_stack([np.zeros(count), np.linspace(0, 1.9, count), np.full(count, 20.0)]) + [30.0, 0, 0]
    return course(points, turned(np.linspace(-45, 45, count)))


def spiral():
    """A bead that winds out from the top of a dome, the tool along its normal."""
    way = np.linspace(0.2, 30, 120)
    x, y = 0.6 * way * np.cos(way), 0.6 * way * np.sin(way)
    points = np.column_stack([x, y, np.sqrt(1600 - x**2 - y**2)])
    return course(points, points / 40)


SHAPES = {"ridge": ridge(), "sampled ridge": ridge(20), "spiral": spiral()}


def unlimited(machine):
    return replace(machine, turn_speed=1e6, turn_acceleration=1e9, travel_feed=1e9)


@pytest.mark.parametrize("axes", ["ac", "bc"])
@pytest.mark.parametrize("shape", SHAPES)
def test_the_tip_stays_on_its_way_between_points(shape, axes):
    """Sampled between the points of the program by kinematics that are not the writer's."""
    made, machine = SHAPES[shape], replace(FIVE, axes=axes)
    program = gcode(made, machine)
    moves = read_moves(program.text)
    samples = sampled(moves, moves.printing, machine.pivot_z, 0.05)
    worst = deviations(samples, [made.points], 0.05).max()
    assert worst < machine.deviation and program.deviation <= machine.deviation
    assert worst == pytest.approx(program.deviation, abs=0.01)
    # Without divisions the tip of two points leaves the way by millimetres.
    if shape == "ridge":
        coarse = read_moves(gcode(made, replace(unlimited(machine), deviation=1e3)).text)
        assert deviations(sampled(coarse, coarse.printing, machine.pivot_z, 0.05), [made.points], 0.05).max() > 5


def test_a_turn_of_the_table_about_the_tip_is_no_travel():
    """Half way along a bead the tool leans over by 40 degrees, where the tip stays: nothing goes through the bead."""
    along = np.array([0, 1, 2, 2, 3, 4.0])
    points = np.column_stack([along, 0 * along, 20 + 0 * along])
    moves = read_moves(
        gcode(course(points, turned(np.array([0, 0, 0, 40, 40, 40.0]))), replace(FIVE, tolerance=0)).text
    )
    still = moves.printing[1:] & (moves.ends[1:, 3] != moves.begins[1:, 3])
    assert (moves.ends[:, 3] != moves.begins[:, 3])[~moves.travels & (moves.extruded == 0)].any() and not still.all()
    assert not (moves.travels & (moves.extruded != 0)).any()
    beads = Beads(sampled(moves, moves.printing, FIVE.pivot_z, 0.02), moves)
    for chosen in (moves.travels, ~moves.travels & (moves.extruded >= 0)):
        assert not moves_through(beads, sampled(moves, chosen, FIVE.pivot_z, 0.02)).any()
    assert len(np.unique(beads.numbers)) == 1


def test_a_travel_through_a_bead_is_seen():
    """A bead along X, and a way across it at half of its height, without and with filament."""
    text = "G28\nG90 M83\nG0 X0 Y0 Z1 F6000\n;TYPE:x\n;WIDTH:0.5\n;HEIGHT:0.4\nG1 X10 E1 F600\n"
    across = "G0 X10 Y5 Z3\nG0 X5 Y5\nG0 Z0.8\n{} X5 Y-5{}\nG0 X9 Y-5 Z3\nG1 X10 Y-6 E1\n"
    for code, word in (("G0", ""), ("G1", " E1")):
        moves = read_moves(text + across.format(code, word))
        beads = Beads(sampled(moves, moves.printing, 0, 0.05), moves)
        tried = sampled(moves, moves.printing | moves.travels, 0, 0.05)
        hit = moves_through(beads, tried)
        inside = (tried.tips[:, 2] < 0.85) & (np.abs(tried.tips[:, 1]) < 0.2)
        np.testing.assert_array_equal(hit, inside & (tried.moves > beads.moves[0]))
        assert hit.sum() == 8


def test_a_bead_that_ends_at_its_beginning_is_no_bead_through_a_bead():
    """It sinks by a quarter of its height on its way around; where it crosses itself elsewhere, or goes on, it counts.

    The tip is inside of a bead of half width 0.5 less than 0.45 from its middle.
    """
    begin = "G28\nG90 M83\nG0 X0 Y0 Z1 F6000\n;TYPE:x\n;WIDTH:1\n;HEIGHT:0.4\n"

    def through(places, away="G0 Z5", kind="printing"):
        rows = [f"G1 X{x} Y{y} Z{z} E1 F600" for x, y, z in places]
        moves = read_moves("\n".join([begin, *rows, away, "G0 X20 Z5", "G1 X30 E1"]))
        beads = Beads(sampled(moves, moves.printing, 0, 0.02), moves)
        tried = sampled(moves, getattr(moves, kind), 0, 0.02)
        return tried.tips[moves_through(beads, tried)]

    sides = [(3, 0, 1), (3, 3, 1), (0, 3, 1)]
    assert not len(through([*sides, (0, 0.1, 0.9)]))
    for crossing in (
        [*sides, (0, -2, 0.9)],
        [(6, 0, 1), (6, 3, 1), (3, 3, 1), (3, -3, 0.8), (0, -3, 0.8), (0, 0.1, 1)],
    ):
        tips = through(crossing)
        assert 0.8 < np.ptp(tips[:, 1]) < 1.0 and np.abs(tips[:, 1]).max() < 0.5
    # A travel out of the closed bead has no right to go through its beginning.
    assert np.ptp(through([*sides, (0, 0.1, 0.9)], "G0 X2 Y0\nG0 Z5", "travels")[:, 0]) > 1


@pytest.mark.parametrize("axes", ["ac", "bc"])
@pytest.mark.parametrize("moves", ["inverse", "feed", "tcp"])
def test_dialects_lead_the_same_way_at_the_same_speed(moves, axes):
    made, machine = spiral(), replace(FIVE, axes=axes, moves=moves)
    program = gcode(made, machine)
    found = read_moves(program.text)
    tips, tools = on_part(found.ends[found.printing], machine.pivot_z, moves == "tcp")
    samples = sampled(found, found.printing, machine.pivot_z, 0.05)
    assert deviations(samples, [made.points], 0.05).max() < machine.deviation
    assert np.linalg.norm(tips[-1] - made.points[-1]) < 1e-3
    assert (tools[-1] @ made.axes[-1]) > np.cos(np.radians(0.5))
    assert ("G93" in program.text) == (moves == "inverse") and ("G43.4 H1" in program.text) == (moves == "tcp")
    if moves != "tcp":  # where the controller follows the tip, it limits the table itself
        assert turn_speed(found) <= 1.01 * machine.turn_speed
    slow = gcode(made, replace(machine, turn_speed=10))
    assert slow.turn_speed <= 10.01 and slow.seconds > program.seconds and slow.slowed > program.slowed


def test_a_table_speeds_up_as_its_file_allows():
    made = SHAPES["sampled ridge"]
    made = replace(made, axes=turned(45 * np.sin(np.linspace(-np.pi / 2, np.pi / 2, 20))))
    free, limited = gcode(made, unlimited(FIVE)), gcode(made, replace(FIVE, turn_acceleration=300))
    assert free.turn_acceleration > 3000 and limited.turn_acceleration <= 303
    moves = read_moves(limited.text)
    angles = (moves.ends - moves.begins)[moves.printing, 3]
    seconds = moves.seconds[moves.printing]
    found = np.abs(np.diff(angles / seconds)) / ((seconds[1:] + seconds[:-1]) / 2)
    assert found.max() <= 320


@pytest.mark.parametrize("axes", ["ac", "bc"])
def test_angles_lead_to_the_tool_and_back(axes):
    random = np.random.default_rng(2)
    machine = replace(FIVE, axes=axes)
    tools = random.standard_normal((50, 3))
    tools[:, 2] = np.abs(tools[:, 2])
    tools /= np.linalg.norm(tools, axis=1, keepdims=True)
    points = 40 * random.standard_normal((50, 3))
    angles = table_angles(points, tools, [1] * 50, machine)
    np.testing.assert_allclose(tool_directions(angles, machine), tools, atol=1e-9)
    np.testing.assert_allclose(to_part(to_machine(points, angles, machine), angles, machine), points, atol=1e-9)
    states = np.zeros((50, 6))
    states[:, :3] = to_machine(points, angles, machine)
    states[:, 3 if axes == "ac" else 4], states[:, 5] = angles.T
    tips, found = on_part(states, machine.pivot_z)
    np.testing.assert_allclose(tips, points, atol=1e-9)
    np.testing.assert_allclose(found, tools, atol=1e-9)


@pytest.mark.parametrize("axes", ["ac", "bc"])
def test_the_table_goes_through_upright_without_turning(axes):
    """Noise of a tenth of a degree around upright asks for any turn; a way through it tilts to the other side."""
    random = np.random.default_rng(3)
    machine, way = replace(FIVE, axes=axes), np.linspace(0, 20, 81)
    points = np.column_stack([way, 0 * way, 0 * way])
    tools = turned(4 * (way - 10)) + 0.002 * random.standard_normal((81, 3)) * [1, 1, 0]
    tools /= np.linalg.norm(tools, axis=1, keepdims=True)
    angles = table_angles(points, tools, [81], machine)
    assert np.ptp(angles[:, 1]) < 3 and np.ptp(angles[:, 0]) == pytest.approx(80, abs=1)
    off = np.degrees(np.arccos(np.clip((tool_directions(angles, machine) * tools).sum(axis=1), -1, 1)))
    assert off.max() < 0.5


def test_a_flip_is_done_lifted_off():
    """Two beads side by side, the tool 40 degrees one way and then the other: the table turns above the part."""
    line = np.column_stack([np.linspace(0, 5, 6), np.zeros(6), np.full(6, 20.0)])
    points = np.concatenate([line, line + [0, 0.6, 0]])
    tools = np.concatenate([turned(np.full(6, 40.0)), turned(np.full(6, -40.0))])
    moves = read_moves(gcode(course(points, tools, [np.arange(6), np.arange(6, 12)]), FIVE).text)
    travels = ~moves.printing & (moves.ends[:, 3:] != moves.begins[:, 3:]).any(axis=1)
    travels[:3] = False
    samples = sampled(moves, travels, FIVE.pivot_z, 0.1)
    away = np.linalg.norm(samples.tips[:, None] - points, axis=2).min(axis=1)
    assert len(away) and away.min() > 0.45


@pytest.mark.parametrize("name", MACHINES)
def test_machines_that_are_shipped_heat_and_prime(name):
    machine = read_machine(name)
    way = np.linspace(0, 2 * np.pi, 40)
    points = np.column_stack([5 * np.cos(way), 5 * np.sin(way), np.full(40, 0.2)]) + [*machine.middle, 0]
    made = course(points, turned(np.zeros(40)))
    program = gcode(replace(made, widths=np.full(40, machine.bore), step=machine.bore), machine)
    for degrees, word in ((machine.nozzle_temperature, "M109"), (machine.bed_temperature, "M190")):
        assert (f"{word} S{degrees:g}" in program.text) == (degrees > 0)
    lines = program.text.splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith(("G0", "G94 G0")))
    assert "G28" in lines[:first] and any(line.startswith("G21 G90 M83") for line in lines[:first])
    assert f"; filament used [mm] = {program.filament:.2f}" in lines and program.seconds > 0
    assert (f";TYPE:{SKIRT}" in lines) == (machine.skirt > 0) and f";TYPE:{WALL}" in lines
    assert f";WIDTH:{machine.bore:.3f}" in lines and ";HEIGHT:0.200" in lines and ";LAYER_CHANGE" in lines
    assert (read_moves(program.text).ends[:, 2] > 0).all()


def test_all_feet_of_a_part_have_a_first_layer():
    foot = np.array([[0.0, 0, 0.2], [4, 0, 0.2], [4, 4, 0.2]])
    places = np.concatenate([foot, foot + [14, 0, 0], foot + [0, 0, 0.2], foot + [14, 0, 0.2]]) + [90, 90, 0]
    made = course(places, turned(np.zeros(12)), list(np.arange(12).reshape(4, 3)), np.arange(4))
    made = replace(made, heights=np.full(12, 0.2), widths=np.full(12, 0.4), step=0.4)
    assert made.is_first.tolist() == [True, True, False, False]
    machine = replace(read_machine("marlin"), first_feed=600.0, feed=1200.0)
    moves = read_moves(gcode(made, machine).text)
    lowest = moves.printing & (moves.ends[:, 2] < 0.3)
    hull = moves.ends[lowest, 0]
    assert hull.min() < 90 - machine.skirt_distance and hull.max() > 108 + machine.skirt_distance
    assert gcode(made, machine).text.index("M106") > gcode(made, machine).text.index(";Z:0.4")


def test_axes_that_leave_the_bed_with_the_tilt_are_warned_of():
    corners = np.array([[-95.0, -95, 20], [95, -95, 20], [95, 95, 20]])
    machine = replace(read_machine("five_axis_ac"), skirt=0)
    for tilt, count in ((0.0, 0), (-30.0, 1)):
        told = gcode(course(corners, turned(np.full(3, tilt))), machine).warnings
        assert len([line for line in told if "with the table's tilt" in line]) >= count
        assert count or not any("with the table's tilt" in line for line in told)


def test_kinds_of_beads_are_told():
    points = np.column_stack([np.linspace(0, 5, 6), np.zeros(6), np.full(6, 0.2)])
    points = np.concatenate([points, points + [0, 1, 0]])
    made = replace(course(points, turned(np.zeros(12)), [np.arange(6), np.arange(6, 12)]), kinds=[WALL, GAP])
    lines = gcode(made, Machine(start="")).text.splitlines()
    assert lines.index(f";TYPE:{WALL}") < lines.index(f";TYPE:{GAP}")


def test_a_part_outside_of_the_bed_is_refused():
    made = course(np.array([[1.0, 5, 1], [30, 5, 1]]), turned(np.zeros(2)))
    machine = Machine(bed_width=20, bed_depth=20, bed_origin="corner")
    with pytest.raises(SettingError, match=r"from X 1.0 to 30.0 mm, and the machine from 0 to 20"):
        gcode(made, machine)
    with pytest.raises(SettingError, match=r"Z 1\.0"):
        gcode(made, replace(machine, bed_width=40, bed_height=0.5))
    assert machine.middle == (10, 10) and replace(machine, bed_x=3).middle == (3, 10)
    assert replace(machine, bed_origin="centre").middle == (0, 0)
    wide = gcode(made, replace(machine, bed_width=32, skirt=1))
    assert wide.warnings == ()  # a bead is a line: nothing to go around
    square = course(np.array([[1.0, 1, 1], [5, 1, 1], [5, 5, 1]]), turned(np.zeros(3)))
    assert gcode(square, replace(machine, skirt=1)).warnings == ("the skirt does not fit on the bed and is left out",)


def test_a_start_text_cannot_change_what_the_moves_mean():
    made = course(np.array([[0.0, 0, 1], [10, 0, 1], [20, 0, 1]]), turned(np.zeros(3)))
    program = gcode(made, Machine(start="G28\nM82\nG92 E0\nG91\nG1 Z5\nG90", tolerance=0))
    assert program.warnings == (
        "the start text ends with absolute extrusion (M82): the program sets G21 G90 M83 after it",
    )
    relative = read_moves(program.text)
    absolute = read_moves(gcode(made, Machine(start="G28\nM83", extrusion="absolute", tolerance=0)).text)
    amounts = [moves.extruded[moves.printing] for moves in (relative, absolute)]
    np.testing.assert_allclose(*amounts, atol=2e-5)
    assert relative.extruded[relative.printing].sum() * np.pi * 1.75**2 / 4 == pytest.approx(20 * 0.5 * 0.2, rel=1e-4)
    with pytest.raises(SettingError, match=r"volumetric \(M200\): take it out, or write filament = 1.128379"):
        Machine(start="M200 D1.75")
    assert not Machine(start="M200 D0\nG91.1").contradictions
    assert not Machine(start="(M200 D1.75, and G91)\nG28 (in M82) ; M200").contradictions  # comments
    volumes = read_moves(gcode(made, Machine(start="M200 D1.75", filament=1.128379, tolerance=0)).text)
    assert volumes.extruded[volumes.printing].sum() == pytest.approx(20 * 0.5 * 0.2, rel=1e-4)


def test_no_move_asks_for_more_than_the_largest_flow():
    made = course(np.array([[0.0, 0, 1], [10, 0, 1], [20, 0, 1]]), turned(np.zeros(3)))
    program = gcode(made, Machine(start="", feed=6000, largest_flow=2))
    moves = read_moves(program.text)
    flow = (moves.extruded * np.pi * 1.75**2 / 4)[moves.printing] / moves.seconds[moves.printing]
    assert flow.max() == pytest.approx(2, rel=1e-3) and program.slowed == pytest.approx(1)


def test_short_ways_to_the_next_bead_are_not_lifted():
    line = np.column_stack([np.linspace(0, 5, 6), np.zeros(6), np.full(6, 0.2)])
    made = course(
        np.concatenate([line, line[::-1] + [0, 0.5, 0]]), turned(np.zeros(12)), [np.arange(6), np.arange(6, 12)]
    )
    counts = [gcode(made, Machine(start="", hop=hop)).text.count("E-1.0") for hop in (0, 2)]
    assert counts == [2, 1]


def test_short_ways_pass_over_what_stands_between():
    """A wall 1 mm high that is printed first, and lines on both sides of it."""
    line = np.column_stack([np.linspace(0, 5, 6), np.zeros(6), np.full(6, 0.2)])
    points = np.concatenate([line + [0, 0.5, 0.8], line, line[::-1] + [0, 1, 0]])
    made = course(points, turned(np.zeros(18)), [np.arange(6), np.arange(6, 12), np.arange(12, 18)])
    text = gcode(made, Machine(start="", hop=2)).text
    rapid = [line.split() for line in text.splitlines() if line.startswith("G0")]
    state, over = {"X": 0.0, "Y": 0.0, "Z": 0.0}, []
    for words in rapid:
        before = dict(state)
        state |= {word[0]: float(word[1:]) for word in words if word[0] in state}
        if min(before["Y"], state["Y"]) < 0.5 < max(before["Y"], state["Y"]):
            over.append(min(before["Z"], state["Z"]))
    assert len(over) == 1 and over[0] > 1


def test_pieces_side_by_side_are_one_layer():
    line = np.column_stack([np.linspace(0, 5, 6), np.zeros(6), np.full(6, 0.2)])
    points = np.concatenate([line, line + [0, 9, 0], line + [0, 0, 0.2]])
    made = course(points, turned(np.zeros(18)), [np.arange(k, k + 6) for k in (0, 6, 12)], np.arange(3))
    rows = gcode(replace(made, levels=np.array([0, 0, 1])), Machine(start="")).text.splitlines()
    assert [row for row in rows if row.startswith(";LAYER:")] == [";LAYER:0", ";LAYER:1"]
    assert "; 3 beads on 2 layers" in rows


def test_comments_follow_the_size_of_a_bead():
    made = course(np.column_stack([np.linspace(0, 5, 11), np.zeros(11), np.full(11, 0.2)]), turned(np.zeros(11)))
    text = gcode(replace(made, heights=np.linspace(0.1, 0.3, 11)), Machine(start="", tolerance=0)).text
    heights = [float(row[8:]) for row in text.split(";TYPE:")[1].splitlines() if row.startswith(";HEIGHT:")]
    np.testing.assert_allclose(heights, np.arange(0.11, 0.3, 0.02), atol=1e-3)


def test_a_file_may_build_on_a_machine_that_is_shipped(tmp_path):
    path = tmp_path / "mine.toml"
    for encoding in ("utf-8", "utf-8-sig"):  # with the mark that editors on Windows put before a text
        path.write_text('machine = "marlin"\nnozzle_temperature = 230\n', encoding)
        assert read_machine(path) == replace(read_machine("marlin"), nozzle_temperature=230.0)
    path.write_text('machine = "reprap"\n')
    with pytest.raises(SettingError, match="the machine 'reprap' is unknown: use one of clay, five_axis_ac"):
        read_machine(path)
