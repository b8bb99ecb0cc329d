# SPDX-License-Identifier: GPL-3.0-or-later
"""Constraint rows of patterns: fixed phases, soft targets for phases, and groups merged into one node."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...gauge import balance
from ...graphs import components
from ...problem import Merged, Targets
from .groups import TOLERANCE, Links, OneForm, contract_groups, fixed_phases, join_links
from .rows import Row, penalties


@dataclass(frozen=True)
class _LinePhases:
    """Phases at a row's nodes, of given vertices, from the one on its line:
    exp(1j * shifts) * (conj where turned)(phase).

    The phase on the line is that of the sheet in which it grows to the line's left; of the phases of a vertex it is the
    one that grows most across the line. Vertices without a direction follow the first of their piece from edge to edge,
    in its sheet; where there are two phases, both are constrained.
    """

    row: Row
    nodes: np.ndarray
    shifts: np.ndarray
    turned: np.ndarray
    vertices: np.ndarray

    @classmethod
    def of(cls, row: Row, one_form: OneForm) -> "_LinePhases":
        """Compute the shifts from the distances of the vertices from the line, as means over their places on it."""
        count = one_form.phase_count
        line = row.line.directed
        towards = one_form.angles[line.vertices] - line.angles - np.pi / 2
        rise = np.cos(towards[:, None] + one_form.turn * np.arange(count))
        own = np.abs(rise).argmax(axis=1)
        rise = np.take_along_axis(rise, own[:, None], axis=1)[:, 0]
        directed, place = np.unique(count * line.vertices + own, return_inverse=True)
        alone = np.setdiff1d(row.line.nodes, line.vertices)
        nodes = np.union1d(directed, (count * alone[:, None] + np.arange(count)).ravel())
        shifts, turned = np.zeros(len(nodes)), np.zeros(len(nodes), bool)
        if count == 1:
            i, j = row.line.links.T
            flips = one_form.matchings[one_form.mesh.edges_between(i, j)] == 1
            turned, _ = balance(len(nodes), np.searchsorted(nodes, row.line.links), flips)
        at = np.searchsorted(nodes, directed)
        stations = np.bincount(place)
        shifts[at] = np.bincount(place, one_form.rates.ravel()[directed][place] * line.offsets * rise) / stations
        turned[at] = (np.bincount(place, rise) < 0) & (not one_form.has_signs)
        return cls(row, nodes, shifts, turned, nodes // count)

    def of_vertices(self, values: ArrayLike) -> np.ndarray:
        """(k,) values at the nodes, from one value or from (v,) values at the vertices of the row."""
        vertices = self.row.line.nodes
        return np.broadcast_to(values, len(vertices))[np.searchsorted(vertices, self.vertices)]

    @property
    def values(self) -> np.ndarray:
        """(k,) complex phases at the nodes for the row's value."""
        phase = self.of_vertices(self.row.value)
        return np.exp(1j * (self.shifts + np.where(self.turned, -phase, phase)))


def phase_constraints(
    one_form: OneForm, rows: Sequence[Row], links: Iterable[Links] = (), slack: float = TOLERANCE
) -> tuple[Targets, Merged, list[Targets]]:
    """Fixed, merged and softly constrained phases of a pattern, by rows of the kinds "phase" and "constant" and further
    links.

    Linked values may differ by the slack. Raises :class:`ContradictionError` when hard rows ask for different phases at
    a vertex.
    """
    phases = [_LinePhases.of(row, one_form) for row in rows]
    hard = [p for p in phases if p.row.kind == "phase" and p.row.is_hard]
    fixed = fixed_phases([(p.row.name, p.nodes, p.values) for p in hard], "remove one of them there")
    joined = join_links([*links, *(_links(p, one_form) for p in phases if p.row.kind == "constant")])
    count = one_form.phase_count * one_form.mesh.vertex_count
    fixed, merged = contract_groups(count, joined, fixed, slack)
    is_fixed = np.zeros(count, bool)
    is_fixed[fixed.nodes] = True
    soft = []
    for p in phases:
        if not p.row.is_hard:
            free = ~is_fixed[p.nodes]
            weights = p.of_vertices(penalties(one_form.mesh, p.row))
            soft.append(Targets(p.nodes[free], p.values[free], weights[free]))
    return fixed, merged, soft


def _links(phases: _LinePhases, one_form: OneForm) -> Links:
    """Links from the first node of each connected piece of a line, in one phase, to the other nodes."""
    count, nodes = one_form.phase_count, phases.nodes
    i, j = np.sort(phases.row.line.links, axis=1).T
    matched = one_form.matchings[one_form.mesh.edges_between(i, j)]
    own = np.arange(count)
    tails, heads = count * i[:, None] + own, count * j[:, None] + (own - matched[:, None]) % count
    joined = np.isin(tails, nodes) & np.isin(heads, nodes)
    tails, heads = np.searchsorted(nodes, tails[joined]), np.searchsorted(nodes, heads[joined])
    pieces = components(len(nodes), np.column_stack([tails, heads]))
    root = np.unique(pieces, return_index=True)[1][pieces]
    flips = phases.turned != phases.turned[root]
    angles = phases.shifts - np.where(flips, -1, 1) * phases.shifts[root]
    return Links(nodes[root], nodes, angles, flips, np.full(len(root), phases.row.name, object))
