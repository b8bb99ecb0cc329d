# SPDX-License-Identifier: GPL-3.0-or-later
"""G-code: moves of a printer along beads, with the filament that each of them takes."""

from dataclasses import dataclass

import numpy as np

from ..geometry.polylines import piece_lengths
from .moves import simplify_moves

# Of the tool, in degrees: nearer to upright, the table keeps its turn.
_UPRIGHT = 0.05
# Travels that are shorter, in steps, stay near the layer.
_NEAR = 4.0


@dataclass(frozen=True)
class Course:
    """Where a printer's tip goes while it extrudes, in the part's space and the machine's millimetres.

    Attributes
    ----------
    points, axes : (n, 3) of the tip, and unit vectors of the tool
    widths, heights : (n,) of the bead
    runs : list of (k,) points of each bead, the first one again at the end where it closes
    layers : (l,) layer of each bead
    step : between beads
    """

    points: np.ndarray
    axes: np.ndarray
    widths: np.ndarray
    heights: np.ndarray
    runs: list
    layers: np.ndarray
    step: float


def gcode(course, machine):
    """Text of a program.

    Five axes move in inverse time (G93): the feed is that of the tip over the part. Extrusion is relative (M83).
    Points that no move needs (``Machine.tolerance``) are left out, what leads to them is extruded by the next move.

    Parameters
    ----------
    course : Course, one bead at least
    machine : Machine
    """
    # In the order of the moves: where a bead closes, the table may have turned once around.
    order = np.concatenate(course.runs)
    places, angles = machine_moves(course.points[order], course.axes[order], machine)
    ends = np.cumsum([len(run) for run in course.runs])
    moves = _Moves(machine)
    rows = [f"; {len(course.runs)} beads on {len(np.unique(course.layers))} layers", machine.start]
    area, before, last, top = np.pi * machine.filament**2 / 4, None, course.points[0], -np.inf
    tops, stations = _tops(places, machine), _stations(places, angles, machine)
    for run, stop, layer in zip(course.runs, ends, course.layers, strict=True):
        first = stop - len(run)
        if layer != before:
            rows.append(f"; layer {layer}")
        is_far = before != layer or np.linalg.norm(course.points[run[0]] - last) > _NEAR * course.step
        if is_far and np.isfinite(top):
            rows.append(moves.rapid(z=top + machine.lift))
            rows.append(moves.rapid(*places[first, :2], angles=angles[first]))
        rows.append(moves.rapid(*(places[first] + [0, 0, machine.lift]), angles=angles[first]))
        rows.append(moves.rapid(*places[first], angles=angles[first]))
        if machine.retraction and before is not None:
            rows.append(moves.filament(machine.retraction))
        lengths = piece_lengths(course.points[run])
        sections = (course.widths * course.heights)[run]
        sections = machine.flow * (sections[:-1] + sections[1:]) / 2
        along, filled = (np.append(0.0, np.cumsum(parts)) for parts in (lengths, sections * lengths))
        points = simplify_moves(along, stations[first:stop], sections, machine.tolerance * course.step)
        for at, length, volume in zip(points[1:], np.diff(along[points]), np.diff(filled[points]), strict=True):
            if length > 0:
                rows.append(moves.bead(places[first + at], angles[first + at], length, volume / area))
        if machine.retraction:
            rows.append(moves.filament(-machine.retraction))
        rows.append(moves.rapid(z=places[stop - 1, 2] + machine.lift))
        before, last, top = layer, course.points[run[-1]], max(top, tops[first:stop].max())
    return "\n".join([*(row for row in rows if row), machine.end]) + "\n"


def machine_moves(points, axes, machine):
    """Where a machine's axes are for tips and tools one after the other.

    Parameters
    ----------
    points, axes : (n, 3)
    machine : Machine

    Returns
    -------
    places : (n, 3) of the linear axes
    angles : (n, 2) of the table, degrees; (n, 0) for three axes
    """
    if not machine.turns:
        return points, np.zeros((len(points), 0))
    x, y, z = axes.T
    tilt = np.degrees(np.arctan2(np.hypot(x, y), z))
    turn = np.degrees(np.arctan2(x, y) if machine.axes == "ac" else np.arctan2(-y, x))
    tilt = tilt if machine.axes == "ac" else -tilt
    angles = np.empty((len(tilt), 2))
    last = 0.0
    # The table may be tilted to either side: the turn that is nearer to the last one.
    for number, (one, other) in enumerate(zip(tilt.tolist(), turn.tolist(), strict=True)):
        if abs(one) >= _UPRIGHT:
            ways = [(other - last + 180) % 360 - 180, (other - last) % 360 - 180]
            flips = abs(ways[1]) < abs(ways[0])
            last, one = last + ways[flips], -one if flips else one
        angles[number] = one, last
    first, second = np.radians(angles).T
    pivot = np.array([0, 0, machine.pivot_z])
    x, y, z = (points - pivot).T
    x, y = np.cos(second) * x - np.sin(second) * y, np.sin(second) * x + np.cos(second) * y
    if machine.axes == "ac":
        y, z = np.cos(first) * y - np.sin(first) * z, np.sin(first) * y + np.cos(first) * z
    else:
        x, z = np.cos(first) * x + np.sin(first) * z, -np.sin(first) * x + np.cos(first) * z
    return np.column_stack([x, y, z]) + pivot, angles


def _tops(places, machine):
    """(n,) heights above which the tool clears places, however the table turns."""
    if not machine.turns:
        return places[:, 2]
    return machine.pivot_z + np.linalg.norm(places - [0, 0, machine.pivot_z], axis=1)


def _stations(places, angles, machine):
    """(n, d) the machine's axes as lengths: those of the table as the ways of the place that is farthest from them."""
    reach = np.linalg.norm(places - [0, 0, machine.pivot_z], axis=1).max(initial=0)
    return np.column_stack([places, np.radians(angles) * reach])


class _Moves:
    """Lines of moves."""

    def __init__(self, machine):
        self._machine, self._letters = machine, machine.axes.upper() if machine.turns else ""
        self._timed = "G93 " if machine.turns else ""
        self._plain = "G94 " if machine.turns else ""

    def rapid(self, x=None, y=None, z=None, *, angles=()):
        words = [f"{letter}{value:.4f}" for letter, value in zip("XYZ", (x, y, z), strict=True) if value is not None]
        return f"{self._plain}G0 {' '.join([*words, *self._turned(angles)])} F{self._machine.travel_feed:g}"

    def bead(self, place, angles, length, filament):
        words = [f"{letter}{value:.4f}" for letter, value in zip("XYZ", place, strict=True)]
        feed = self._machine.feed / length if self._timed else self._machine.feed
        return f"{self._timed}G1 {' '.join([*words, *self._turned(angles)])} E{filament:.6f} F{feed:.6g}"

    def filament(self, length):
        return f"{self._plain}G1 E{length:.5f} F{self._machine.retraction_feed:g}"

    def _turned(self, angles):
        return [f"{letter}{angle:.4f}" for letter, angle in zip(self._letters, angles, strict=bool(len(angles)))]
