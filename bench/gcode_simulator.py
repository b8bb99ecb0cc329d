# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulate a printer from G-code text: tip positions on the part, speeds of the axes, and the volume that beads fill.

It shares no code with the writer of programs: its own reading of words, its own kinematics (Rodrigues' formula), moves
sampled in the machine's axes, beads as what lies below the tip within half their width.
"""

import re
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

_WORD = re.compile(r"([A-Z])\s*(-?\d*\.?\d+(?:[eE][-+]?\d+)?)")


@dataclass(frozen=True)
class Moves:
    """All moves of a program, straight in the machine's axes.

    Attributes
    ----------
    begins, ends : (m, 6) X, Y, Z, A, B, C, millimetres and degrees
    extruded : (m,) length of filament, negative where it is drawn back
    seconds : (m,) that the program asks for
    widths, heights : (m,) of the last comments before
    travels : (m,) bool, moves without a word for the filament; where the table turns about the tip, none is drawn
    kinds : (m,) names of the last ;TYPE: before
    is_tcp : whether coordinates are tip positions on the part (G43.4)
    """

    begins: np.ndarray
    ends: np.ndarray
    extruded: np.ndarray
    seconds: np.ndarray
    widths: np.ndarray
    heights: np.ndarray
    travels: np.ndarray
    kinds: np.ndarray
    is_tcp: bool

    @property
    def printing(self):
        """(m,) bool: moves that extrude on a way."""
        moved = (self.ends != self.begins).any(axis=1)
        return (self.extruded > 0) & moved


def read_moves(text):
    """The :class:`Moves` of a program, up to its last bead."""
    state, total, feed = dict.fromkeys("XYZABC", 0.0), 0.0, 1.0
    is_relative = is_timed = is_tcp = is_moving_on = False
    width = height = np.nan
    kind, rows, kinds = "", [], []
    for line in text.splitlines():
        code, _, comment = line.partition(";")
        if comment.startswith("WIDTH:"):
            width = float(comment[6:])
        if comment.startswith("HEIGHT:"):
            height = float(comment[7:])
        if comment.startswith("TYPE:"):
            kind = comment[5:]
        words = [(letter, float(value)) for letter, value in _WORD.findall(code.upper())]
        values = {letter: value for letter, value in words if letter not in "GM"}
        codes = [f"{letter}{value:g}" for letter, value in words if letter in "GM"]
        for one in codes:
            is_relative = one == "M83" or (is_relative and one != "M82")
            is_timed = one == "G93" or (is_timed and one not in ("G94", "G95"))
            is_tcp = is_tcp or one == "G43.4"
            is_moving_on = one == "G91" or (is_moving_on and one != "G90")
        if "G28" in codes:
            state.update(dict.fromkeys("XYZ", 0.0))
        elif "G92" in codes:
            total = values.get("E", total)
        elif not any(one.startswith("M") or one in ("G4", "G43.4", "G49") for one in codes) and values:
            begin = [state[letter] for letter in "XYZABC"]
            state |= {letter: values[letter] + is_moving_on * state[letter] for letter in state.keys() & values.keys()}
            end = [state[letter] for letter in "XYZABC"]
            given = values.get("E")
            amount = 0.0 if given is None else given if is_relative else given - total
            total += amount
            feed = values.get("F", feed)
            way = np.linalg.norm(np.subtract(end, begin)[:3])
            way = way if way > 0 else np.linalg.norm(np.subtract(end, begin)[3:]) or abs(amount)
            seconds = 60 / feed if is_timed and "G1" in codes else 60 * way / feed
            rows.append([*begin, *end, amount, seconds, width, height, given is None])
            kinds.append(kind)
    table = np.array(rows)
    stop = np.flatnonzero((table[:, 12] > 0) & (table[:, :6] != table[:, 6:12]).any(axis=1))[-1] + 1
    table, kinds = table[:stop], np.array(kinds[:stop])
    return Moves(table[:, :6], table[:, 6:12], *table[:, 12:16].T, table[:, 16] > 0, kinds, is_tcp)


def _rotations(axis, degrees):
    """(n, 3, 3) right-handed turns around X, Y or Z."""
    cross = np.cross(np.eye(3), np.eye(3)["XYZ".index(axis)])
    angles = np.radians(degrees)[:, None, None]
    return np.eye(3) + np.sin(angles) * cross + (1 - np.cos(angles)) * (cross @ cross)


def on_part(states, pivot_z, is_tcp=False):
    """(n, 3) of the tip and (n, 3) along the tool, on the part, from (n, 6) axes."""
    table = _rotations("X", states[:, 3]) @ _rotations("Y", states[:, 4]) @ _rotations("Z", states[:, 5])
    pivot = np.array([0, 0, pivot_z])
    tips = states[:, :3] if is_tcp else np.einsum("nji,nj->ni", table, states[:, :3] - pivot) + pivot
    return tips, table[:, 2, :]


@dataclass(frozen=True)
class Samples:
    """Places along the moves that extrude, or along the others.

    Attributes
    ----------
    tips, tools : (s, 3)
    moves : (s,) number of the move
    spans : (s,) length of the way on the part that each stands for
    """

    tips: np.ndarray
    tools: np.ndarray
    moves: np.ndarray
    spans: np.ndarray


def sampled(moves, chosen, pivot_z, size):
    """:class:`Samples` of (m,) chosen moves, at most a size or a degree apart."""
    numbers = np.flatnonzero(chosen)
    begins, ends = moves.begins[numbers], moves.ends[numbers]
    reach = np.linalg.norm(begins[:, :3] - [0, 0, pivot_z], axis=1)
    turned = np.abs(ends - begins)[:, 3:].max(axis=1)
    ways = np.linalg.norm(ends - begins, axis=1) + np.radians(turned) * reach
    counts = np.maximum(np.ceil(np.maximum(ways / size, turned)).astype(int), 1)
    of = np.repeat(np.arange(len(numbers)), counts)
    place = np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts, counts)
    first, middle, last = (
        on_part(begins[of] + ((place + at) / counts[of])[:, None] * (ends - begins)[of], pivot_z, moves.is_tcp)
        for at in (0, 0.5, 1)
    )
    spans = np.linalg.norm(last[0] - first[0], axis=1)
    return Samples(*middle, numbers[of], spans)


def deviations(samples, polylines, size):
    """(s,) distances of the tips of extruding samples to the ways that they should go, (k, 3) polylines in the
    machine's millimetres on the part; ``size`` is the distance of the places of the ways that are looked for first."""
    begins = np.concatenate([line[:-1] for line in polylines])
    ends = np.concatenate([line[1:] for line in polylines])
    of, shares = _parts(np.maximum(np.ceil(np.linalg.norm(ends - begins, axis=1) / size).astype(int), 1))
    tree = cKDTree(begins[of] + shares[:, None] * (ends - begins)[of])
    found = np.empty(len(samples.tips))
    for part in np.array_split(np.arange(len(found)), len(found) // 50_000 + 1):
        near = of[tree.query(samples.tips[part], k=min(12, len(of)))[1]]
        along = ends[near] - begins[near]
        away = samples.tips[part, None] - begins[near]
        shares = np.einsum("skx,skx->sk", away, along) / np.maximum(np.einsum("skx,skx->sk", along, along), 1e-18)
        offsets = away - np.clip(shares, 0, 1)[..., None] * along
        found[part] = np.linalg.norm(offsets, axis=2).min(axis=1)
    return found


def _parts(counts):
    """(k,) which each of so many parts belongs to, and where its middle is, as a share."""
    of = np.repeat(np.arange(len(counts)), counts)
    return of, (np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts, counts) + 0.5) / counts[of]


class Beads:
    """What has been printed: along each sample a box as wide and high as the comments say, below the tip."""

    def __init__(self, samples, moves):
        self.moves, self._tools = samples.moves, samples.tools
        self.widths, self._heights = moves.widths[samples.moves], moves.heights[samples.moves]
        # Travels before each sample, which is the number of its bead, and the way that the tip has printed.
        self.numbers = np.cumsum(moves.travels)[samples.moves]
        self.arc_lengths = np.cumsum(samples.spans)
        # Length of the bead of each sample where it ends at its beginning, infinite where it does not.
        _, firsts, of, counts = np.unique(self.numbers, return_index=True, return_inverse=True, return_counts=True)
        lasts = firsts + counts - 1
        gaps = np.linalg.norm(samples.tips[lasts] - samples.tips[firsts], axis=1)
        lengths = self.arc_lengths[lasts] - self.arc_lengths[firsts] + gaps
        self.loops = np.where(gaps < self.widths[firsts] / 2, lengths, np.inf)[of]
        self._middles = samples.tips - self._heights[:, None] / 2 * samples.tools
        self._tree = cKDTree(self._middles)
        # A box, and one over and one under it.
        self._reach = float(np.hypot(self.widths / 2, self._heights).max())

    def around(self, points):
        """Beads near (n, 3) points, in parts: yields points, samples, the offset along the tool over half the height,
        and aside over half the width."""
        for part in np.array_split(np.arange(len(points)), len(points) // 2000 + 1):
            found = self._tree.query_ball_point(points[part], self._reach)
            sizes = np.array([len(near) for near in found], int)
            row, near = np.repeat(part, sizes), np.concatenate([*found, []]).astype(int)
            away = points[row] - self._middles[near]
            up = np.einsum("kx,kx->k", away, self._tools[near])
            aside = np.linalg.norm(away - up[:, None] * self._tools[near], axis=1)
            yield row, near, 2 * up / self._heights[near], 2 * aside / self.widths[near]


def filled_shares(beads, points):
    """Share of (n, 3) points in the part that lie in a bead, and share that lie aside of one by no more than half its
    width, over and under it by no more than half its height; with a slack of 4 % for the samples."""
    filled, near = np.zeros((2, len(points)), bool)
    for row, _, up, aside in beads.around(points):
        narrow = aside <= 1.04
        filled[row[narrow & (np.abs(up) <= 1.04)]] = True
        near[row[narrow & (np.abs(up) <= 2)]] = True
    return float(filled.mean()), float(near.mean())


def moves_through(beads, samples):
    """(s,) bool: samples whose tip is inside a bead that was printed before, more than a tenth below its
    top and a tenth inside its sides.

    The last width of the bead that the tip comes from does not count: the tip stands on it, and boxes do not bend. Nor
    does the first width, from where the tip is, of a bead that it closes.
    """
    hit, last = np.zeros(len(samples.tips), bool), np.searchsorted(beads.moves, samples.moves) - 1
    prints = beads.moves[np.minimum(last + 1, len(beads.moves) - 1)] == samples.moves
    ways = np.cumsum(samples.spans)
    since = ways - (ways - samples.spans)[np.searchsorted(samples.moves, samples.moves)]
    for row, near, up, aside in beads.around(samples.tips):
        inside = (beads.moves[near] < samples.moves[row]) & (np.abs(up) < 0.8) & (aside < 0.9)
        own = beads.numbers[near] == beads.numbers[last[row]]
        behind = beads.arc_lengths[last[row]] - beads.arc_lengths[near]
        ahead = np.where(prints[row], beads.loops[near] - behind - since[row], np.inf)
        own &= np.minimum(behind, ahead) < beads.widths[near]
        hit[row[inside & ~own]] = True
    return hit


def tip_speed(moves, samples):
    """Millimetres a second of the tip on the part in the fastest move that extrudes, of its samples."""
    ways = np.bincount(samples.moves, samples.spans, len(moves.seconds))
    return float((ways[moves.printing] / moves.seconds[moves.printing]).max())


def turn_speed(moves):
    """Degrees a second of the fastest turning axis while it prints."""
    chosen = moves.printing
    turned = np.abs(moves.ends - moves.begins)[chosen, 3:].max(axis=1)
    return float((turned / moves.seconds[chosen]).max())
