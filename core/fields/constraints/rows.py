# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows of the constraint list, and what they ask of a direction field.

Rows of the kinds "along", "across" and "angle" speak of directions, "phase" and "constant" of stripes; a stripe
that lies on a line needs directions along it, so that these two also ask for that. Rows of the kind "grid" are made by
the program: lines on which quads have a grid line where no other row asks for anything.
"""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ...errors import ContradictionError, SettingError
from ...problem import Targets
from ...settings.constraints import WISHES
from .lines import Line, join_stations

KINDS = tuple(wish.name for wish in WISHES if wish.name != "cut")
GRID = "grid"
# A vertex whose stations disagree by more than this (as a mean of unit powers) is left free:
# at a right angle a line cannot run along both sides, though a cross can.
AGREEMENT = 0.5
# Rows that differ by less (as powers) are averaged: tangents of polygons, strokes and fields hardly ever agree in full.
DISAGREEMENT = 0.2
# Beyond this a soft wish is as good as hard, and sums lose their digits.
LARGEST_WEIGHT = 1e9


@dataclass(frozen=True)
class Row:
    """One wish: what is asked along a line, and how strongly.

    Attributes
    ----------
    line : Line
    kind : "along", "across", or "angle" to the line; "phase" for a fixed phase, "constant" for one that is
        free on each connected piece of the line; "grid" for a grid line that gives way to other rows
    value : radians: the angle, counterclockwise from the line, or the phase, where it grows to the line's left;
        one, or (k,) one at each of the line's nodes
    weight : None for a hard wish; otherwise the penalty is weight * integral |x - wish|^2 / sqrt(area)
        along the line, the same at every resolution and scale
    name : for messages
    """

    line: Line
    kind: str
    value: float = 0.0
    weight: float | None = None
    name: str = "the row"

    def __post_init__(self):
        if self.kind not in (*KINDS, GRID):
            raise SettingError(f"{self.name} asks for {self.kind!r}: use one of {', '.join(KINDS)}")
        if not np.isfinite(self.value).all():
            raise SettingError(f"the value of {self.name} is {self.value}: give a finite number")
        if self.weight is not None and not 0 <= self.weight <= LARGEST_WEIGHT:
            raise SettingError(
                f"the weight of {self.name} is {self.weight}: give a number from 0 to {LARGEST_WEIGHT:.0e}, "
                "or none to hold it exactly"
            )
        if self.kind == "constant" and self.weight is not None:
            raise SettingError(f"{self.name} is soft: a phase that is constant along a line can only be hard")

    @property
    def is_hard(self):
        return self.weight is None

    @property
    def is_of_phases(self):
        return self.kind in ("phase", "constant", GRID)

    @property
    def turn(self):
        """Angle from the line to the direction that is asked for."""
        return {"across": np.pi / 2, "angle": self.value}.get(self.kind, 0.0)

    def directions(self, symmetry):
        """Nodes of the line that have a direction, and the (k,) mean of the powers that their stations ask for."""
        line = self.line.directed
        return line.nodes, line.means(np.exp(1j * symmetry * (line.angles + self.turn)))


def penalties(mesh, row):
    """(k,) weights with which a soft row draws its line's nodes."""
    return row.weight * row.line.shares / np.sqrt(mesh.areas.sum())


def direction_targets(mesh, symmetry, rows):
    """Fixed and drawn directions, as unit powers: (Targets, list of Targets), and (k,) bool: fixed ones that are to
    give way where they cannot be had.

    Raises
    ------
    ContradictionError
        when two hard rows ask for different directions on the same edge
    """
    grid = [row for row in rows if row.kind == GRID]
    rows = [row for row in rows if row.kind != GRID]
    hard = [row for row in rows if row.is_hard]
    for first, second in combinations(hard, 2):
        _refuse_contradiction(symmetry, first, second)
    fixed, drawn = Targets.none(), []
    if hard:
        lines = [replace(row.line.directed, angles=row.line.directed.angles + row.turn) for row in hard]
        fixed = Targets(*_agreeing_nodes(*Row(join_stations(lines), "along").directions(symmetry)))
    held = np.zeros(mesh.vertex_count, bool)
    held[fixed.nodes] = True
    for row in rows:
        if not row.is_hard:
            nodes, values = _agreeing_nodes(*row.directions(symmetry))
            weights = penalties(mesh, row)[np.searchsorted(row.line.nodes, nodes)]
            free = ~held[nodes]
            drawn.append(Targets(nodes[free], values[free], weights[free]))
            held[nodes] |= weights > 0
    gives_way = np.zeros(len(fixed.nodes), bool)
    for row in grid:
        nodes, values = _agreeing_nodes(*row.directions(symmetry))
        free = ~held[nodes]
        fixed = Targets(np.append(fixed.nodes, nodes[free]), np.append(fixed.values, values[free]))
        gives_way = np.append(gives_way, np.ones(free.sum(), bool))
    return fixed, drawn, gives_way


def _agreeing_nodes(nodes, means):
    """Nodes where the stations agree well enough, and what they ask for."""
    good = np.abs(means) > AGREEMENT
    return nodes[good], means[good] / np.abs(means[good])


def _refuse_contradiction(symmetry, first, second):
    """Two rows have to agree on edges that both run over, and where most of one is on the other.

    Lines that only meet or cross need not.
    """
    (nodes, values), (others, other_values) = (row.directions(symmetry) for row in (first, second))
    shared, i, j = np.intersect1d(nodes, others, return_indices=True)
    vertices = shared[np.abs(values[i] - other_values[j]) > DISAGREEMENT]
    if len(vertices) < 0.5 * min(len(nodes), len(others)):
        if first.line.offsets.any() or second.line.offsets.any():
            return
        links = [np.unique(np.sort(row.line.links, axis=1), axis=0) for row in (first, second)]
        both, counts = np.unique(np.concatenate(links), axis=0, return_counts=True)
        vertices = np.unique(both[(counts == 2) & np.isin(both, vertices).all(axis=1)])
    if len(vertices):
        raise ContradictionError(
            f"{first.name} and {second.name} ask for different directions at {{vertices}}: remove one of them there",
            vertices,
        )
