# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs read back by a reader of their own: the tip goes where it should, with what it should extrude."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.core.errors import SettingError
from synch_fields.core.printing.gcode import WALL, Course, gcode
from synch_fields.core.printing.machine import Machine, read_machine

MACHINE = Machine(
    start="G21\nG90\nM83", end="M2", pivot_z=40.0, feed=900, retraction=0.8, lift=1.5, filament=2.0, tolerance=0
)


def read(text):
    """States of a printer after each G0 and G1: letters to values, what the line extrudes as "E", its code as "G"."""
    state, states = {}, []
    for line in text.splitlines():
        words = re.findall(r"([A-Z])(-?[\d.]+(?:e-?\d+)?)", line.split(";")[0])
        codes = [value for letter, value in words if letter == "G"]
        state = state | {"E": 0.0} | {letter: float(value) for letter, value in words if letter not in "GM"}
        state["T"] = "G93" in line
        if codes and codes[-1] in ("0", "1"):
            states.append(state | {"G": int(codes[-1])})
    return states


def rotation(axis, degrees):
    """Right-handed turn around an axis of the machine, from Rodrigues' formula."""
    cross = np.cross(np.eye(3), np.eye(3)["XYZ".index(axis)])
    angle = np.radians(degrees)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def on_part(state, machine):
    """Where the tip is on the part, and which way the tool stands there."""
    place, up = np.array([state["X"], state["Y"], state["Z"]]), np.array([0, 0, 1.0])
    if machine.axes == "xyz":
        return place, up
    pivot = np.array([0, 0, machine.pivot_z])
    table = rotation({"a": "X", "b": "Y"}[machine.axes[0]], state[machine.axes[0].upper()]) @ rotation("Z", state["C"])
    return table.T @ (place - pivot) + pivot, table.T @ up


def dome(axes):
    """Rings on a dome, the first one at its top, and an open bead on a layer above."""
    points, normals, runs = [], [], []
    for radius in (0.5, 4.0, 8.0):
        angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
        ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(400 - radius**2 + 0 * angle)])
        runs.append(np.append(np.arange(40), 0) + len(points) * 40)
        points.append(ring)
        normals.append(ring / 20)
    runs.append(np.arange(120, 130))
    line = np.column_stack([np.linspace(-3, 9, 10), np.full(10, 2.0), np.full(10, 21.0)])
    points.append(line)
    normals.append(line / np.linalg.norm(line, axis=1, keepdims=True))
    points, normals = np.concatenate(points), np.concatenate(normals)
    random = np.random.default_rng(1)
    widths, heights = random.uniform(0.4, 0.6, 130), random.uniform(0.1, 0.3, 130)
    tools = normals if axes != "xyz" else np.tile([0.0, 0, 1], (130, 1))
    layers = np.array([0, 0, 0, 1])
    return Course(points, tools, points, widths, heights, runs, layers, 0.5, [WALL] * 4, layers)


@pytest.mark.parametrize("axes", ["xyz", "ac", "bc"])
def test_the_tip_follows_the_beads_with_their_volume(axes):
    course, machine = (
        dome(axes),
        replace(MACHINE, axes=axes, flow=1.1, deviation=100, turn_speed=1e6, turn_acceleration=1e9),
    )
    states = read(gcode(course, machine).text)
    printing = [k for k, state in enumerate(states) if state["E"] > 0 and state["F"] != machine.retraction_feed]
    ends = np.concatenate([run[1:] for run in course.runs])
    begins = np.concatenate([run[:-1] for run in course.runs])
    assert len(printing) == len(ends)
    for k, begin, end in zip(printing, begins, ends, strict=True):
        before, _ = on_part(states[k - 1], machine)
        place, tool = on_part(states[k], machine)
        np.testing.assert_allclose(before, course.points[begin], atol=2e-3)
        np.testing.assert_allclose(place, course.points[end], atol=2e-3)
        np.testing.assert_allclose(tool, course.axes[end], atol=0.01)
        length = np.linalg.norm(course.points[end] - course.points[begin])
        section = (course.widths * course.heights)[[begin, end]].mean()
        assert states[k]["E"] * np.pi == pytest.approx(1.1 * section * length, abs=4e-5)
        minutes = 1 / states[k]["F"] if states[k]["T"] else length / states[k]["F"]
        assert states[k]["T"] == (axes != "xyz") and length / minutes == pytest.approx(900, rel=1e-3)


@pytest.mark.parametrize("axes", ["xyz", "ac", "bc"])
def test_fewer_moves_stay_near_the_bead_with_its_volume(axes):
    """A wave over a dome, of 2001 points: places on the part between the states that a reader finds."""
    x = np.linspace(-8, 8, 2001)
    points = np.column_stack([x, 2 * np.sin(x / 2), np.sqrt(900 - x**2)])
    tools = np.column_stack([x, 0 * x, points[:, 2]]) / 30 if axes != "xyz" else np.tile([0.0, 0, 1], (len(x), 1))
    heights = 0.2 + 0.1 * np.sin(x / 3)
    runs, layers = [np.arange(len(x))], np.array([0])
    course = Course(points, tools, points, np.full(len(x), 0.5), heights, runs, layers, 0.5, [WALL], layers)
    machine = replace(MACHINE, axes=axes, tolerance=0.02)
    states = read(gcode(course, machine).text)
    extruding = [k for k, state in enumerate(states) if state["E"] > 0 and state["F"] != machine.retraction_feed]
    assert 10 < len(extruding) < 200
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    volumes = 0.5 * (heights[1:] + heights[:-1]) / 2 * lengths
    assert sum(states[k]["E"] for k in extruding) * np.pi == pytest.approx(volumes.sum(), abs=1e-4)
    passed = []
    for k in extruding:
        for share in np.linspace(0, 1, 80):
            mixed = {a: (1 - share) * states[k - 1][a] + share * states[k][a] for a in states[k] if a in states[k - 1]
                     and a in "XYZABC"}  # fmt: skip
            passed.append(on_part(mixed, machine)[0])
        # Along each move the height is the bead's to a twentieth.
        begin, end = on_part(states[k - 1], machine)[0], on_part(states[k], machine)[0]
        inside = (x[1:] <= end[0] + 1e-3) & (x[:-1] >= begin[0] - 1e-3)
        section = states[k]["E"] * np.pi / lengths[inside].sum()
        assert np.abs(0.25 * (heights[1:] + heights[:-1])[inside] - section).max() < 0.055 * section
    there, _ = cKDTree(passed).query(points)
    back, _ = cKDTree(points).query(passed)
    # The tolerance, four digits of the program, and half of what samples are apart.
    assert max(there.max(), back.max()) < 0.02 * 0.5 + 1e-3 + lengths.max() / 2
    assert len(read(gcode(course, replace(machine, tolerance=0.1)).text)) < len(states)


@pytest.mark.parametrize("axes", ["xyz", "ac", "bc"])
def test_between_beads_it_lifts_and_draws_back(axes):
    course, machine = dome(axes), replace(MACHINE, axes=axes)
    states = read(gcode(course, machine).text)
    drawn = [state["E"] for state in states if abs(abs(state["E"]) - 0.8) < 1e-9 and state["F"] == 1800]
    assert drawn == [-0.8, 0.8] * 3 + [-0.8]
    back = 0.0
    for before, state in pairwise(states):
        back += state["E"] if abs(abs(state["E"]) - 0.8) < 1e-9 and state["F"] == 1800 else 0
        if state["G"] == 0 and before["G"] == 1:
            assert state["E"] == 0 and back == pytest.approx(-0.8)
    if axes != "xyz":
        turns = np.array([state["C"] for state in states if "C" in state])
        assert np.abs(np.diff(turns)).max() <= 180


def test_a_long_way_goes_above_all_that_is_printed():
    course = dome("xyz")
    states = read(gcode(course, MACHINE).text)
    highest = max(state["Z"] for state in states if state["E"] > 0 and state["Z"] < 20.5)
    # To the bead of the other layer, which is lower than the top of the lift, too.
    arrived = next(state for state in states if state["G"] == 0 and state.get("X") == -3)
    assert arrived["Z"] == pytest.approx(highest + 1.5, abs=1e-4)


def test_a_machine_is_what_its_file_says(tmp_path):
    path = tmp_path / "printer.toml"
    path.write_text('axes = "bc"\nfeed = 600\nlargest_height = 0.35\nstart = """G28\nM104 S210"""\n')
    machine = read_machine(path)
    assert machine == replace(Machine(), axes="bc", feed=600.0, largest_height=0.35, start="G28\nM104 S210")
    assert machine.turns and not Machine().turns


@pytest.mark.parametrize(
    "text, words",
    [
        ('axes = "xyzab"', "use one of xyz, ac, bc"),
        ("feed = 0", "positive"),
        ("feed = nan", "finite"),
        ("speed = 1", "unknown"),
        ("nozzle_angle = 90", "below 90"),
        ("lift = -1", "from 0 on"),
        ("tolerance = -0.1", "from 0 on"),
        ("pivot_z = inf", "finite"),
        ("smallest_height = 0.3\nlargest_height = 0.2", "largest_height"),
        ("feed =", "cannot be read"),
        ("start = 3", "a text"),
    ],
)
def test_what_a_machine_cannot_be_is_said_with_its_file(tmp_path, text, words):
    path = tmp_path / "printer.toml"
    path.write_text(text)
    with pytest.raises(SettingError, match=words) as caught:
        read_machine(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


def test_a_machine_that_is_not_there_is_said(tmp_path):
    for name in ("none.toml", "printer.txt"):
        with pytest.raises(SettingError, match=name):
            read_machine(tmp_path / name)
