# SPDX-License-Identifier: GPL-3.0-or-later
"""G-code: moves of a printer along beads, with the filament that each of them takes."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Self

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from ..errors import SettingError
from ..geometry.polylines import piece_lengths
from ..graphs import pairs_within, ragged_arange
from .kinematics import divide_moves, simplify_moves, table_angles, tip_deviation, to_machine, tool_directions
from .machine import Machine
from .timing import feed_words, move_seconds, overhead_seconds, turn_accelerations
from .writer import ProgramWriter

# Travels that are shorter, in steps, stay near the layer.
_NEAR = 4.0
# What is printed so near to a short travel, in steps, may be in its way.
_AROUND = 1.5
# What beads are, as previews of G-code call it.
SKIRT, WALL, INNER, GAP, SPARSE = "Skirt/Brim", "External perimeter", "Perimeter", "Gap infill", "Internal infill"


@dataclass(frozen=True)
class Course:
    """Where a printer's tip goes while it extrudes, in the part's space and the machine's millimetres.

    Attributes
    ----------
    points, axes : (n, 3) of the tip, and unit vectors of the tool
    places : (n, 3) on the layer, where the bead's length is measured
    widths, heights : (n,) of the bead
    runs : list of (k,) points of each bead, the first one again at the end where it closes
    layers : (l,) layer of each bead
    step : between beads
    kinds : what each bead is
    levels : (l,) how many layers lie below that of each bead, which pieces side by side share
    """

    points: np.ndarray
    axes: np.ndarray
    places: np.ndarray
    widths: np.ndarray
    heights: np.ndarray
    runs: list[np.ndarray]
    layers: np.ndarray
    step: float
    kinds: list[str]
    levels: np.ndarray

    @property
    def ways(self) -> np.ndarray:
        """(k,) length of the tip's way up to each point of all runs; the step to the next run counts as 1."""
        order, first = np.concatenate(self.runs), np.cumsum([len(run) for run in self.runs])[:-1]
        steps = piece_lengths(self.points[order])
        steps[first - 1] = 1
        return np.append(0.0, np.cumsum(steps))

    @property
    def is_first(self) -> np.ndarray:
        """(l,) bool: beads of layers on the bed, as low as the lowest one, of each foot of the part."""
        layers, bead = np.unique(self.layers, return_inverse=True)
        lengths = [len(run) for run in self.runs]
        layer, used = np.repeat(bead, lengths), np.concatenate(self.runs)
        counts = np.maximum(np.bincount(layer, minlength=len(layers)), 1)
        middles = np.bincount(layer, self.points[used, 2], len(layers)) / counts
        thickness = np.bincount(layer, self.heights[used], len(layers)) / counts
        return (middles < middles.min() + thickness / 2)[bead]


@dataclass(frozen=True)
class Program:
    """A program and what is known of it; millimetres, degrees, seconds.

    Attributes
    ----------
    seconds : that it takes, about
    filament, volume : length that is drawn in, and what it is extruded to
    deviation : of the tip from its way on the part, at most; on five axes
    tool_off : of the tool from the way it should stand, at most
    turn_speed, turn_acceleration : of the table at most, inside a bead; the controller starts and stops it
    slowed : share of the length that is slower than the feed, for the flow or the table
    warnings : lines that the user should read
    """

    text: str
    seconds: float
    filament: float
    volume: float
    deviation: float
    tool_off: float
    turn_speed: float
    turn_acceleration: float
    slowed: float
    warnings: tuple[str, ...] = ()


def gcode(course: Course, machine: Machine) -> Program:
    """The :class:`Program` of a course of one bead at least; SettingError where the part is outside of the bed.

    Points that no move needs (``Machine.tolerance``) are left out, what leads to them is extruded by the next move; on
    five axes moves are divided until the tip stays within ``Machine.deviation`` of its way.
    """
    _check_place(course, machine)
    course, warnings = _with_skirt(course, machine)
    moves = _Moves.of(course, machine)
    writer = ProgramWriter(machine)
    rows = [*_header(course, moves), *_begin(machine)]
    tops, clearances = _tops(moves.places, machine), moves.clearances(course, machine)
    before, top, number = None, -np.inf, 0
    fan, is_first = False, course.is_first
    for bead, (level, kind) in enumerate(zip(course.levels.tolist(), course.kinds, strict=True)):
        first, stop = moves.begins[bead], moves.begins[bead + 1]
        target, angles = moves.places[first], moves.angles[first]
        rows += writer.travel(target, angles, top, level == before, moves.reach, clearances[bead])
        if level != before:
            height = course.heights[course.runs[bead]].mean()
            rows += [";LAYER_CHANGE", f";Z:{target[2]:.3f}", f";LAYER:{level}", f";HEIGHT:{height:.3f}"]
            if machine.fan and not fan and number >= machine.fan_from and not (machine.fan_from and is_first[bead]):
                rows.append(f"M106 S{round(255 * machine.fan)}")
                fan = True
            number, before = number + 1, level
        rows += writer.start(kind)
        chosen = slice(first + 1, stop)
        rows += writer.bead(
            moves.places[chosen],
            moves.angles[chosen],
            moves.points[chosen],
            moves.filament[chosen],
            moves.feeds[chosen],
            moves.sizes[chosen],
        )
        top = max(top, tops[first:stop].max())
    rows += writer.finish(top)
    text = "\n".join([*rows, machine.end]) + "\n"
    lines = (*warnings, *_about_axes(moves.places, machine), *_about_start(machine))
    return Program(text, warnings=lines, **moves.facts)


def print_times(course: Course, machine: Machine) -> tuple[np.ndarray, np.ndarray]:
    """(n,) seconds from the first move on at which the points of a course are printed, and (n,) millimetres a second
    there; points of no bead have the time of the one before, and no speed."""
    moves, order = _Moves.of(course, machine), np.concatenate(course.runs)[::-1]
    along = course.ways[::-1]
    seconds, speeds = np.zeros((2, len(course.points)))
    # Of several assignments the last one stays: closed beads come back to their first point.
    seconds[order] = np.interp(along, moves.along, moves.ends)
    speeds[order] = moves.speeds[np.minimum(np.searchsorted(moves.along, along - 1e-9), len(moves.along) - 1)]
    return np.maximum.accumulate(seconds), speeds


def _check_place(course: Course, machine: Machine) -> None:
    """Refuse a part that the tip cannot reach."""
    for axis, places, bed in _beyond_bed(course.points[np.concatenate(course.runs)], machine):
        if axis != "Z" or not machine.turns:
            raise SettingError(
                f"the part reaches from {axis} {places} mm, and the machine from {bed}: "
                "make it smaller, or set scale, bed_x and bed_y in the machine's file"
            )


def _about_axes(places: np.ndarray, machine: Machine) -> Iterator[str]:
    """Warn of a turning table's axes that go farther than the bed, although the part lies on it."""
    for axis, reached, bed in _beyond_bed(places, machine) if machine.turns else ():
        yield (
            f"with the table's tilt the axis {axis} goes from {reached} mm, and the bed from {bed}: "
            "make the part smaller or tilt less"
        )


def _beyond_bed(places: np.ndarray, machine: Machine) -> Iterator[tuple[str, str, str]]:
    """Each axis along which places lie beyond the machine's reach, with the ranges of both as text."""
    for axis, along, low, high in zip("XYZ", places.T, *machine.reach, strict=True):
        if along.min() < low - 1e-6 or along.max() > high + 1e-6:
            yield axis, f"{along.min():.1f} to {along.max():.1f}", f"{low:g} to {high:g}"


def _about_start(machine: Machine) -> Iterator[str]:
    for word, meaning in machine.contradictions.items():
        yield f"the start text ends with {meaning} ({word}): the program sets {machine.modes} after it"


def _with_skirt(course: Course, machine: Machine) -> tuple[Course, list[str]]:
    """The course with lines around its first layer before it, and warnings."""
    first = np.concatenate([run for run, is_first in zip(course.runs, course.is_first, strict=True) if is_first])
    flat = course.points[first, :2]
    if not machine.skirt or len(flat) < 3:
        return course, []
    height, width = float(np.median(course.heights[first])), course.step
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rings = []
    for number in reversed(range(machine.skirt)):
        around = (machine.skirt_distance + (number + 0.5) * width + width / 2) * np.column_stack(
            [np.cos(angle), np.sin(angle)]
        )
        try:
            corners = flat[ConvexHull(flat).vertices]
            spread = (corners[:, None] + around).reshape(-1, 2)
            rings.append(spread[ConvexHull(spread).vertices])
        except QhullError:
            return course, []
    low, high = machine.reach
    outermost = rings[0]
    if (outermost < low[:2]).any() or (outermost > high[:2]).any():
        return course, ["the skirt does not fit on the bed and is left out"]
    points = [np.column_stack([ring, np.full(len(ring), height)]) for ring in rings]
    starts = len(course.points) + np.cumsum([0, *map(len, points)])
    runs = [np.append(np.arange(a, b), a) for a, b in pairwise(starts)]
    count = starts[-1] - len(course.points)
    return replace(
        course,
        points=np.concatenate([course.points, *points]),
        axes=np.concatenate([course.axes, np.tile([0.0, 0.0, 1.0], (count, 1))]),
        places=np.concatenate([course.places, *points]),
        widths=np.append(course.widths, np.full(count, width)),
        heights=np.append(course.heights, np.full(count, height)),
        runs=[*runs, *course.runs],
        layers=np.append(np.full(len(runs), course.layers[0]), course.layers),
        kinds=[*[SKIRT] * len(runs), *course.kinds],
        levels=np.append(np.full(len(runs), course.levels[0]), course.levels),
    ), []


@dataclass(frozen=True)
class _Moves:
    """Moves of a machine along all beads.

    Attributes
    ----------
    places, angles, points : (m, 3), (m, 2) and (m, 3) axes and tips at the ends of moves
    filament : (m,) drawn in on the way there, 0 at the first place of a bead
    feeds : (m,) millimetres a minute of the tip, or as the dialect counts
    sizes : (m, 2) width and height of the bead on the way there
    begins : (l + 1,) where each bead begins
    along : (m,) as :attr:`Course.ways`
    ends, speeds : (m,) seconds since the first move when it ends, and millimetres a second
    reach : how far the place that is farthest from the pivot is from it
    facts : of the :class:`Program`
    """

    places: np.ndarray
    angles: np.ndarray
    points: np.ndarray
    filament: np.ndarray
    feeds: np.ndarray
    sizes: np.ndarray
    begins: np.ndarray
    along: np.ndarray
    ends: np.ndarray
    speeds: np.ndarray
    reach: float
    facts: dict[str, Any]

    @classmethod
    def of(cls, course: Course, machine: Machine) -> Self:
        """Turn the beads of a course into moves: tilt, divide, simplify, and time them."""
        order, sizes = np.concatenate(course.runs), np.array([len(run) for run in course.runs])
        points, axes = course.points[order], course.axes[order]
        first = np.zeros(len(order), bool)
        first[np.cumsum(sizes) - sizes] = True
        angles = table_angles(points, axes, sizes, machine)
        cosines = np.einsum("kx,kx->k", tool_directions(angles, machine), axes)
        sections = machine.flow * (course.widths * course.heights)[order]
        along = course.ways
        lengths = np.where(first[1:], 0, piece_lengths(course.places[order]))
        filled = np.append(0.0, np.cumsum(lengths * (sections[:-1] + sections[1:]) / 2))
        spans, shares = divide_moves(points, angles, first, machine)
        sizes = np.column_stack([course.widths, course.heights])[order]
        points, angles, along, filled, sizes = (
            _between(values, spans, shares) for values in (points, angles, along, filled, sizes)
        )
        bead, first = (np.cumsum(first) - 1)[spans], first[spans] & (shares == 0)
        places = to_machine(points, angles, machine)
        pivot = np.array([0, 0, machine.pivot_z])
        reach = float(np.linalg.norm(places - pivot, axis=1).max())
        stations = np.column_stack([places, np.radians(angles) * reach])
        tolerance = min(machine.tolerance * course.step, 0.4 * machine.deviation)
        begins = np.append(np.flatnonzero(first), len(first))
        kept = simplify_moves(along, stations, filled, begins, tolerance)
        deviation = tip_deviation(points, angles, places, kept, bead, machine)
        points, angles, places, along, filled, sizes = (
            values[kept] for values in (points, angles, places, along, filled, sizes)
        )
        sizes[1:] = (sizes[1:] + sizes[:-1]) / 2
        bead, first = bead[kept], first[kept]
        ways, volumes = (np.where(first, 0, np.diff(values, prepend=0.0)) for values in (along, filled))
        # A bead has no move to its first point, which therefore takes no time.
        seconds, slowed = move_seconds(ways, volumes, places, angles, first, course.is_first[bead], machine)
        turns = np.where(first[:, None], 0, np.diff(angles, axis=0, prepend=angles[:1]))
        turning = np.abs(turns) / np.where(seconds > 0, seconds, 1)[:, None]
        filament = volumes / (np.pi * machine.filament**2 / 4)
        ends = np.cumsum(seconds + overhead_seconds(places, ways, seconds, first, machine))
        facts = {
            "seconds": float(ends[-1]),
            "filament": float(filament.sum()),
            "volume": float(volumes.sum()),
            "deviation": deviation,
            "tool_off": float(np.degrees(np.arccos(np.clip(cosines.min(initial=1), -1, 1)))) if machine.turns else 0.0,
            "turn_speed": float(turning.max(initial=0)),
            "turn_acceleration": float(turn_accelerations(turns, seconds, first).max(initial=0)),
            "slowed": float(ways[slowed].sum() / max(ways.sum(), 1e-12)),
        }
        feeds = feed_words(ways, places, angles, seconds, machine)
        begins = np.append(np.flatnonzero(first), len(first))
        speeds = ways / np.where(seconds > 0, seconds, 1)
        speeds[first] = speeds[np.flatnonzero(first) + 1]
        return cls(places, angles, points, filament, feeds, sizes, begins, along, ends, speeds, reach, facts)

    def clearances(self, course: Course, machine: Machine) -> np.ndarray:
        """(l,) heights, along the tool, by which earlier material near the travel to each bead rises above both ends of
        the travel; infinite for long travels."""
        ends, first = self.begins[1:-1] - 1, self.begins[1:-1]
        along = np.diff(self.points, axis=0)
        counts = np.maximum(np.ceil(np.linalg.norm(along, axis=1) / course.step).astype(int), 1)
        counts[first - 1] = 1
        piece, place = ragged_arange(counts)
        obstacles = self.points[piece] + (place / counts[piece])[:, None] * along[piece]
        begins, targets, tools = self.points[ends], self.points[first], tool_directions(self.angles, machine)
        ways = np.linalg.norm(targets - begins, axis=1)
        near = np.flatnonzero(ways <= _NEAR * course.step)
        row, met = pairs_within(
            cKDTree(obstacles), (begins + targets)[near] / 2, ways[near] / 2 + _AROUND * course.step
        )
        row = near[row]
        over = np.maximum(
            np.einsum("kx,kx->k", obstacles[met] - begins[row], tools[ends[row]]),
            np.einsum("kx,kx->k", obstacles[met] - targets[row], tools[first[row]]),
        )
        is_printed, found = piece[met] < first[row], np.full(len(course.runs), np.inf)
        found[1 + near] = 0
        np.maximum.at(found, 1 + row[is_printed], over[is_printed])
        return found


def _between(values: np.ndarray, spans: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Values at points and part of the way to the next ones."""
    following = np.minimum(spans + 1, len(values) - 1)
    shares = shares.reshape(-1, *[1] * (values.ndim - 1))
    return values[spans] + shares * (values[following] - values[spans])


def _tops(places: np.ndarray, machine: Machine) -> np.ndarray:
    """(n,) heights above which the tool clears places, however the table turns."""
    if not machine.turns:
        return places[:, 2]
    return machine.pivot_z + np.linalg.norm(places - [0, 0, machine.pivot_z], axis=1)


def _header(course: Course, moves: _Moves) -> list[str]:
    """Comments that previews and printers read."""
    facts, whole = moves.facts, round(moves.facts["seconds"])
    hours, minutes, seconds = whole // 3600, whole // 60 % 60, whole % 60
    return [
        "; made by Synch Fields",
        f"; {len(course.runs)} beads on {len(np.unique(course.levels))} layers",
        f"; filament used [mm] = {facts['filament']:.2f}",
        f"; filament used [cm3] = {facts['volume'] / 1000:.3f}",
        f"; estimated printing time (normal mode) = {hours}h {minutes}m {seconds}s",
        f";TIME:{whole}",
    ]


def _begin(machine: Machine) -> list[str]:
    """Heating, the start text, and the state that the moves expect."""
    heated = [("140", "190", machine.bed_temperature), ("104", "109", machine.nozzle_temperature)]
    rows = [f"M{warm} S{degrees:g}" for warm, _, degrees in heated if degrees]
    rows += [machine.start] if machine.start else []
    rows += [f"M{wait} S{degrees:g}" for _, wait, degrees in heated if degrees]
    rows.append(machine.modes + (" G94" if machine.turns else ""))
    if machine.turns and machine.moves == "tcp":
        rows.append("G43.4 H1")
    return [*rows, "G92 E0"]
