# SPDX-License-Identifier: GPL-3.0-or-later
"""What the rows of the constraint list ask of stripes: fixed phases, drawn ones, and groups merged into one node."""

from dataclasses import dataclass

import numpy as np

from ..connection import line_flips
from ..errors import ContradictionError
from ..gauge import balance
from ..problem import Targets
from .groups import TOLERANCE, Links, contracted, joined_links
from .rows import penalties


@dataclass(frozen=True)
class _LinePhases:
    """Phases at a row's nodes from the one on its line: exp(1j * shifts) * (conj where turned)(phase).

    On the line the phase is meant in the sheet in which it grows to the line's left. Nodes without a direction follow
    the first of their piece from edge to edge, whose own sheet counts.
    """

    nodes: np.ndarray
    shifts: np.ndarray
    turned: np.ndarray

    @classmethod
    def of(cls, row, field, rates):
        nodes, line = row.line.nodes, row.line.directed
        shifts, turned = np.zeros(len(nodes)), np.zeros(len(nodes), bool)
        if field.symmetry == 2:
            i, j = row.line.links.T
            flips = line_flips(field.mesh, field.angles)[field.mesh.edges_between(i, j)]
            turned, _ = balance(len(nodes), np.searchsorted(nodes, row.line.links), flips)
        # The phase grows a quarter turn counterclockwise from the stripe: this is its growth to the left.
        growth = np.cos(field.angles[line.vertices] - line.angles)
        place = np.searchsorted(nodes, line.nodes)
        shifts[place] = line.means(rates[line.vertices] * line.offsets * growth)
        turned[place] = (line.means(growth) < 0) & (field.symmetry == 2)
        return cls(nodes, shifts, turned)

    def values(self, phase):
        """(k,) complex phases for the line's phase in radians."""
        return np.exp(1j * (self.shifts + np.where(self.turned, -phase, phase)))


def phase_constraints(mesh, field, rates, rows, links=(), slack=TOLERANCE):
    """Fixed, merged and drawn phases of a stripe pattern: (Targets or None, Merged or None, list of Targets).

    Parameters
    ----------
    mesh : TriangleMesh
    field : DirectionField along which stripes run
    rates : (n,) phase per unit length
    rows : Rows of the kinds "phase" and "constant"
    links : further Links between phases
    slack : how far values that links join may differ

    Raises
    ------
    ContradictionError
        when hard rows ask for different phases at a vertex
    """
    phases = [_LinePhases.of(row, field, rates) for row in rows]
    hard = [(row, p) for row, p in zip(rows, phases, strict=True) if row.kind == "phase" and row.is_hard]
    constant = [(row, p) for row, p in zip(rows, phases, strict=True) if row.kind == "constant"]
    fixed = None
    if hard:
        fixed = _agreed(
            np.concatenate([p.nodes for _, p in hard]),
            np.concatenate([p.values(row.value) for row, p in hard]),
            np.concatenate([np.full(len(p.nodes), row.name, object) for row, p in hard]),
        )
    links = joined_links([*links, *(_links(row, p) for row, p in constant)])
    fixed, merged = contracted(mesh.vertex_count, links, fixed, slack)
    held = np.zeros(mesh.vertex_count, bool)
    held[fixed.nodes if fixed is not None else []] = True
    drawn = []
    for row, p in zip(rows, phases, strict=True):
        if not row.is_hard:
            free = ~held[p.nodes]
            drawn.append(Targets(p.nodes[free], p.values(row.value)[free], penalties(mesh, row)[free]))
    return fixed, merged, drawn


def _agreed(nodes, values, names):
    """One target a node; refuses nodes that are wanted at different phases."""
    unique, first, place = np.unique(nodes, return_index=True, return_inverse=True)
    apart = np.abs(values - values[first][place]) > TOLERANCE
    if apart.any():
        other = np.flatnonzero(apart)[0]
        raise ContradictionError(
            f"{names[first[place[other]]]} and {names[other]} fix {{vertices}} to different phases: "
            "remove one of them there",
            nodes[apart],
        )
    return Targets(unique, values[first])


def _links(row, phases):
    """From the first node of each piece of a line to the others."""
    pieces = row.line.pieces
    root = np.unique(pieces, return_index=True)[1][pieces]
    flips = phases.turned != phases.turned[root]
    angles = phases.shifts - np.where(flips, -1, 1) * phases.shifts[root]
    return Links(phases.nodes[root], phases.nodes, angles, flips, np.full(len(root), row.name, object))
