# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs for each shipped machine, as a parser from PyPI reads them."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.bench.gcode_simulator import read_moves
from synch_fields.core.printing.gcode import SKIRT, WALL, gcode
from synch_fields.core.printing.machine import MACHINES, read_machine

from .test_programs import course, spiral, turned

gcodeparser = pytest.importorskip("gcodeparser")
WAVE = np.column_stack([np.linspace(0, 9, 20), np.sin(np.arange(20)), np.full(20, 0.2)])
COURSES = {"flat": course(WAVE, turned(np.zeros(20))), "dome": spiral()}


def run(text):
    """(m, 6) X, Y, Z, A, B, C after each move, (m,) filament of each, and the numbers of lines that are read."""
    state, rows, total, is_relative, read = dict.fromkeys("XYZABC", 0.0), [], 0.0, False, set()
    for line in gcodeparser.parse_gcode_lines(text, include_comments=True):
        read.add(line.line_index)
        given = line.params
        is_relative = line.command_str == "M83" or (is_relative and line.command_str != "M82")
        if line.command_str == "G28":
            state |= dict.fromkeys("XYZ", 0.0)
        elif line.command_str == "G92":
            total = given.get("E", total)
        elif line.type is gcodeparser.Commands.MOVE:
            state |= {letter: float(given[letter]) for letter in state.keys() & given.keys()}
            amount = given.get("E", 0.0 if is_relative else total)
            rows.append([*state.values(), amount if is_relative else amount - total])
            total = total + amount if is_relative else amount
    table = np.array(rows)
    return table[:, :6], table[:, 6], read


@pytest.mark.parametrize("extrusion", ["relative", "absolute"])
@pytest.mark.parametrize("shape", COURSES)
@pytest.mark.parametrize("name", MACHINES)
def test_a_parser_of_others_reads_every_line_and_the_same_moves(name, shape, extrusion):
    machine = replace(read_machine(name), extrusion=extrusion, end="M84", bed_width=0, bed_depth=0)
    program = gcode(COURSES[shape], machine)
    places, filament, read = run(program.text)
    lines = program.text.splitlines()
    assert not [line for number, line in enumerate(lines) if line.strip() and number not in read]
    moves = read_moves(program.text)
    count = len(moves.ends)
    np.testing.assert_allclose(places[:count], moves.ends, atol=1e-9)
    np.testing.assert_allclose(filament[:count], moves.extruded, atol=1e-9)
    # What is drawn back is pushed again, but for the last time; a skirt takes filament too.
    printing = (filament > 0) & (np.diff(places, axis=0, prepend=places[:1]) != 0).any(axis=1)
    assert filament[printing].sum() == pytest.approx(program.filament, rel=1e-4)
    kinds = {line.comment for line in gcodeparser.parse_gcode_lines(program.text, include_comments=True)}
    assert f"TYPE:{WALL}" in kinds and (f"TYPE:{SKIRT}" in kinds) == (machine.skirt > 0)
