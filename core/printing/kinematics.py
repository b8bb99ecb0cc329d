# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the axes of a machine are for a tip and a tool on the part, and the other way round.

The table of a five-axis machine turns by c around Z, and this one by a around X ("ac") or Y ("bc"), around a pivot P:
a point p of the part is at P + R(a) R_z(c) (p - P). The tool is upright, so that on the part it stands along
R_z(-c) R(-a) e_z: its level part is sin(tilt) d(c), with d(c) = (sin c, cos c) and tilt = a, or d(c) = (cos c, -sin c)
and tilt = -a.
"""

import numpy as np
from scipy.sparse import block_diag, csc_matrix, diags_array
from scipy.sparse.linalg import spsolve

from ..graphs import ragged_arange
from .machine import Machine

# Near upright the table may keep its turn: over a way of this, in millimetres, over the sine of the tilt, turns are
# evened out where the tool then stands nearly as it should.
_EVENED = 0.1
# Below this sine of the tilt the turn is free.
_FREE = 1e-4
# What a move extrudes for its length differs from what its parts ask for by less, as a share.
SECTION = 0.05


def _turned(x: np.ndarray, y: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    cosines, sines = np.cos(angles), np.sin(angles)
    return cosines * x - sines * y, sines * x + cosines * y


def to_machine(points: np.ndarray, angles: np.ndarray, machine: Machine) -> np.ndarray:
    """(n, 3) places of the linear axes for (n, 3) points of the part and (n, 2) angles of the table, degrees."""
    if not machine.turns:
        return points
    pivot = np.array([0, 0, machine.pivot_z])
    first, second = np.radians(angles).T
    x, y, z = (points - pivot).T
    x, y = _turned(x, y, second)
    if machine.axes == "ac":
        y, z = _turned(y, z, first)
    else:
        z, x = _turned(z, x, first)
    return np.column_stack([x, y, z]) + pivot


def to_part(places: np.ndarray, angles: np.ndarray, machine: Machine) -> np.ndarray:
    """(n, 3) points of the part where the tip is: the inverse of :func:`to_machine`."""
    if not machine.turns:
        return places
    pivot = np.array([0, 0, machine.pivot_z])
    first, second = np.radians(angles).T
    x, y, z = (places - pivot).T
    if machine.axes == "ac":
        y, z = _turned(y, z, -first)
    else:
        z, x = _turned(z, x, -first)
    x, y = _turned(x, y, -second)
    return np.column_stack([x, y, z]) + pivot


def tool_directions(angles: np.ndarray, machine: Machine) -> np.ndarray:
    """(n, 3) unit vectors along which the tool stands on the part."""
    up = np.tile([0.0, 0.0, 1.0], (len(angles), 1))
    pivot = np.array([0, 0, machine.pivot_z])
    return to_part(pivot + up, angles, machine) - pivot if machine.turns else up


def table_angles(points: np.ndarray, axes: np.ndarray, sizes: np.ndarray, machine: Machine) -> np.ndarray:
    """(n, 2) angles of the table along beads, in degrees: steady within each, and near those of the bead before.

    A table that is tilted to the other side and turned by half a turn has the tool along the same direction. Within a
    bead the tilt goes through upright to the other side where that keeps the turn steady; between beads the nearer of
    both is taken. Points and unit vectors of the tool are (n, 3), in the order of the moves; ``sizes`` are the numbers
    of points of the beads.
    """
    if not machine.turns:
        return np.zeros((len(points), 0))
    x, y, z = axes.T
    level = np.hypot(x, y)
    turns = np.arctan2(x, y) if machine.axes == "ac" else np.arctan2(-y, x)
    begins = np.cumsum(sizes) - sizes
    turns = _even(points, _unwrapped(turns, level > _FREE, begins, sizes), level, sizes)
    tilts = np.arctan2(_along(x, y, turns, machine), z)
    last = np.zeros(2)
    for begin, size in zip(begins.tolist(), np.asarray(sizes).tolist(), strict=True):
        bead = slice(begin, begin + size)
        nearest = round((last[1] - turns[begin]) / np.pi)
        ways = [(tilts[begin] * (-1) ** half, turns[begin] + half * np.pi) for half in range(nearest - 1, nearest + 2)]
        best = int(np.argmin([np.abs(np.subtract(way, last)).max() for way in ways]))
        half = nearest - 1 + best
        tilts[bead] *= (-1) ** half
        turns[bead] += half * np.pi
        last = np.array([tilts[begin + size - 1], turns[begin + size - 1]])
    return np.degrees(np.column_stack([tilts if machine.axes == "ac" else -tilts, turns]))


def _along(x: np.ndarray, y: np.ndarray, turns: np.ndarray, machine: Machine) -> np.ndarray:
    """Sine of the tilt with a sign: the level part of the tool along the direction of a turn."""
    if machine.axes == "ac":
        return x * np.sin(turns) + y * np.cos(turns)
    return x * np.cos(turns) - y * np.sin(turns)


def _unwrapped(turns: np.ndarray, known: np.ndarray, begins: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """(n,) angles, radians, that are known up to multiples of pi, made continuous within each bead; interpolated where
    not known."""
    result = np.zeros(len(turns))
    for begin, size in zip(begins.tolist(), np.asarray(sizes).tolist(), strict=True):
        at = begin + np.flatnonzero(known[begin : begin + size])
        if len(at):
            result[begin : begin + size] = np.interp(np.arange(begin, begin + size), at, np.unwrap(2 * turns[at]) / 2)
    return result


def _even(points: np.ndarray, turns: np.ndarray, level: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Turns evened out near upright: the least of sum level^4 (new - old)^2 + _EVENED^4 times the squared second
    derivatives along each bead."""
    parts, begin = [], 0
    for size in np.asarray(sizes).tolist():
        if size > 2:
            ways = np.maximum(np.linalg.norm(np.diff(points[begin : begin + size], axis=0), axis=1), 1e-6)
            before, after = ways[:-1], ways[1:]
            scale = np.sqrt((before + after) / 2) * 2 / (before + after)
            rows = diags_array(
                [scale / before, -scale * (1 / before + 1 / after), scale / after], offsets=[0, 1, 2],
                shape=(size - 2, size),
            )  # fmt: skip
            parts.append(rows.T @ rows)
        else:
            parts.append(csc_matrix((size, size)))
        begin += size
    spans = np.append(np.linalg.norm(np.diff(points, axis=0), axis=1), 0.0)
    weights = (level**4 + _FREE**2) * np.maximum(spans, 1e-3)
    matrix = diags_array(weights) + _EVENED**4 * block_diag(parts)
    return spsolve(csc_matrix(matrix), weights * turns)


def divide_moves(
    points: np.ndarray, angles: np.ndarray, first: np.ndarray, machine: Machine
) -> tuple[np.ndarray, np.ndarray]:
    """More points along beads, between which straight moves of the machine's axes keep the tip near its way: less than
    half of the machine's deviation.

    The tip goes straight from point to point on the part, and the table's angles change evenly on the way. (n,) bool
    ``first`` are points that begin a bead. Returns (m,) the point after which each new point comes, and (m,) how far it
    is on the way to the next one.
    """
    count = len(points)
    if not machine.turns or count < 2:
        return np.arange(count), np.zeros(count)
    follows = ~first[1:]
    pieces = np.where(follows, 1, 0)
    for _ in range(4):
        spans = np.repeat(np.arange(count - 1), pieces)
        place = np.arange(len(spans)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        begin, end = place / pieces[spans], (place + 1) / pieces[spans]
        off = _off(points, angles, spans, begin, end, machine)
        worst = np.zeros(count - 1)
        np.maximum.at(worst, spans, off)
        factor = np.sqrt(np.maximum(worst / (0.45 * machine.deviation), 1))
        if (factor == 1).all():
            break
        pieces = np.where(follows, np.ceil(pieces * factor).astype(int), 0)
    # A point that another bead follows stands alone.
    counts = np.append(np.maximum(pieces, 1), 1)
    spans = np.repeat(np.arange(count), counts)
    place = np.arange(len(spans)) - np.repeat(np.cumsum(counts) - counts, counts)
    return spans, place / counts[spans]


def tip_deviation(
    points: np.ndarray, angles: np.ndarray, places: np.ndarray, kept: np.ndarray, bead: np.ndarray, machine: Machine
) -> float:
    """How far the tip is from its way on the part at most, at all points and half way between them."""
    if not machine.turns or len(points) < 2:
        return 0.0
    # Of each point, the moves' ends around it and how far it is between them by the length.
    way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    both = np.append(way, (way[1:] + way[:-1])[bead[1:] == bead[:-1]] / 2)
    ends = way[kept]
    interpolated = [np.interp(both, ends, column) for column in np.column_stack([places[kept], angles[kept]]).T]
    wanted = np.column_stack([np.interp(both, way, column) for column in points.T])
    turned = np.column_stack(interpolated)
    return float(np.linalg.norm(to_part(turned[:, :3], turned[:, 3:], machine) - wanted, axis=1).max())


def _off(
    points: np.ndarray, angles: np.ndarray, spans: np.ndarray, begin: np.ndarray, end: np.ndarray, machine: Machine
) -> np.ndarray:
    """(k,) how far the tip leaves its way during straight moves of the axes, each a part of the way from a point to the
    next."""

    def places(values: np.ndarray, shares: np.ndarray) -> np.ndarray:
        return values[spans] + shares[:, None] * (values[spans + 1] - values[spans])

    first, last = (to_machine(places(points, at), places(angles, at), machine) for at in (begin, end))
    off = np.zeros(len(spans))
    for share in (0.25, 0.5, 0.75):
        at = begin + share * (end - begin)
        tips = to_part(first + share * (last - first), places(angles, at), machine)
        off = np.maximum(off, np.linalg.norm(tips - places(points, at), axis=1))
    return off


def simplify_moves(
    along: np.ndarray, stations: np.ndarray, filled: np.ndarray, begins: np.ndarray, tolerance: float
) -> np.ndarray:
    """(m,) the points of beads, with their ends, between which straight moves stay near them (Ramer, Douglas and
    Peucker, with both ways at the same share of the length).

    Parameters
    ----------
    along : (k,) length of the way up to each point of all beads
    stations : (k, d) the machine's axes there, in which moves are straight, all as lengths
    filled : (k,) volume of the beads up to each point
    begins : (b + 1,) where each bead begins
    tolerance : sum of the distances along the axes below which a point can be left out; 0 keeps all
    """
    ways = np.diff(along)
    sections = np.diff(filled) / np.where(ways > 0, ways, 1)
    along = along - np.repeat(along[begins[:-1]], np.diff(begins))
    ways = np.diff(along)
    volumes = np.concatenate(
        [
            np.append(0.0, np.cumsum(sections[first:last] * ways[first:last]))
            for first, last in zip(begins[:-1].tolist(), (begins[1:] - 1).tolist(), strict=True)
        ]
    )
    kept = np.zeros(len(along), bool)
    first, last = begins[:-1], begins[1:] - 1
    kept[first] = kept[last] = True
    while len(first := first[long := last - first > 1]):
        last = last[long]
        lengths = along[last] - along[first]
        lengths[lengths == 0] = 1.0
        row, inner = ragged_arange(last - first - 1)
        inner += first[row] + 1
        shares = (along[inner] - along[first[row]]) / lengths[row]
        straight = stations[first[row]] + shares[:, None] * (stations[last[row]] - stations[first[row]])
        away = np.abs(stations[inner] - straight).sum(axis=1)
        starts = np.searchsorted(row, np.arange(len(first)))
        worst = np.maximum.reduceat(away, starts)
        # The first of several points that are equally far.
        found = np.flatnonzero(away == worst[row])
        split = inner[found[np.searchsorted(row[found], np.arange(len(first)))]]
        mean = (volumes[last] - volumes[first]) / lengths
        row, piece = ragged_arange(last - first)
        unlike = np.abs(sections[first[row] + piece] - mean[row])
        is_near = worst < tolerance
        is_even = np.maximum.reduceat(unlike, np.searchsorted(row, np.arange(len(first)))) <= SECTION * mean
        split = np.where(is_near, (first + last) // 2, split)[~(is_near & is_even)]
        kept[split] = True
        first, last = first[~(is_near & is_even)], last[~(is_near & is_even)]
        first, last = np.append(first, split), np.append(split, last)
    return np.flatnonzero(kept)
