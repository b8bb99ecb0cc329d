# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows of the constraint list, and their targets for a direction field.

Rows of the kinds "along", "across" and "angle" constrain directions, "phase" and "constant" stripes; a stripe that lies
on a line needs directions along it, so that these two also constrain directions. Rows of the kind "grid" are made by
the program: lines on which quads have a grid line where no other row applies.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ...errors import ContradictionError, SettingError
from ...geometry.triangle_mesh import TriangleMesh
from ...problem import Targets
from ...settings.constraints import WISHES
from .lines import Line, join_stations

KINDS = tuple(wish.name for wish in WISHES if wish.name != "cut")
GRID = "grid"
# A vertex whose stations' mean unit power is shorter than this is left free: at a right angle a line field cannot run
# along both sides, though a cross field can.
AGREEMENT = 0.5
# Rows that differ by less (as powers) are averaged: tangents of polygons, strokes and fields hardly ever agree exactly.
DISAGREEMENT = 0.2
# Beyond this a soft constraint is as good as hard, and sums lose digits.
LARGEST_WEIGHT = 1e9


@dataclass(frozen=True)
class Row:
    """One constraint along a line.

    Attributes
    ----------
    kind : "along", "across", or "angle" to the line; "phase" for a fixed phase, "constant" for one that is
        free on each connected piece of the line; "grid" for a grid line that gives way to other rows
    value : radians: the angle, counterclockwise from the line, or the phase, where it grows to the line's left;
        one, or (k,) one at each of the line's nodes
    weight : None for a hard constraint; otherwise the penalty is weight * integral |x - target|^2 / sqrt(area)
        along the line, the same at every resolution and scale
    name : for messages
    """

    line: Line
    kind: str
    value: float | np.ndarray = 0.0
    weight: float | None = None
    name: str = "the row"

    def __post_init__(self) -> None:
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
    def is_hard(self) -> bool:
        return self.weight is None

    @property
    def is_of_phases(self) -> bool:
        return self.kind in ("phase", "constant", GRID)

    @property
    def turn(self) -> float | np.ndarray:
        """Angle from the line to the target direction."""
        return {"across": np.pi / 2, "angle": self.value}.get(self.kind, 0.0)

    def directions(self, symmetry: int) -> tuple[np.ndarray, np.ndarray]:
        """Nodes of the line that have a direction, and the (k,) means of their stations' target powers."""
        line = self.line.directed
        return line.nodes, line.means(np.exp(1j * symmetry * (line.angles + self.turn)))


def penalties(mesh: TriangleMesh, row: Row) -> np.ndarray:
    """(k,) weights of a soft row's targets at its line's nodes."""
    assert row.weight is not None
    return row.weight * row.line.node_lengths / np.sqrt(mesh.areas.sum())


def direction_targets(
    mesh: TriangleMesh, symmetry: int, rows: Sequence[Row]
) -> tuple[Targets, list[Targets], np.ndarray]:
    """Fixed directions and soft targets, as unit powers, and (k,) bool: fixed ones that may give way.

    Raises :class:`ContradictionError` when two hard rows ask for different directions on the same edge.
    """
    grid = [row for row in rows if row.kind == GRID]
    rows = [row for row in rows if row.kind != GRID]
    hard = [row for row in rows if row.is_hard]
    for first, second in combinations(hard, 2):
        _refuse_contradiction(symmetry, first, second)
    fixed, soft = Targets.none(), []
    if hard:
        lines = [replace(row.line.directed, angles=row.line.directed.angles + row.turn) for row in hard]
        fixed = Targets(*_agreeing_nodes(*Row(join_stations(lines), "along").directions(symmetry)))
    taken = np.zeros(mesh.vertex_count, bool)
    taken[fixed.nodes] = True
    for row in rows:
        if not row.is_hard:
            nodes, values = _agreeing_nodes(*row.directions(symmetry))
            weights = penalties(mesh, row)[np.searchsorted(row.line.nodes, nodes)]
            free = ~taken[nodes]
            soft.append(Targets(nodes[free], values[free], weights[free]))
            taken[nodes] |= weights > 0
    gives_way = np.zeros(len(fixed.nodes), bool)
    for row in grid:
        nodes, values = _agreeing_nodes(*row.directions(symmetry))
        free = ~taken[nodes]
        fixed = Targets(np.append(fixed.nodes, nodes[free]), np.append(fixed.values, values[free]))
        gives_way = np.append(gives_way, np.ones(free.sum(), bool))
    return fixed, soft, gives_way


def _agreeing_nodes(nodes: np.ndarray, means: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes whose stations agree well enough, and their (k,) unit targets."""
    good = np.abs(means) > AGREEMENT
    return nodes[good], means[good] / np.abs(means[good])


def _refuse_contradiction(symmetry: int, first: Row, second: Row) -> None:
    """Refuse rows that disagree on common edges, or where most of one lies on the other.

    Lines that only meet or cross need not agree.
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
