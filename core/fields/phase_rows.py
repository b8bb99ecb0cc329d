# SPDX-License-Identifier: GPL-3.0-or-later
"""What the rows of the constraint list ask of stripes: fixed phases, drawn ones, and groups merged into one node."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from ..connection import circle_transports
from ..errors import ContradictionError
from ..problem import Merged, Targets
from .rows import TOLERANCE, penalties


@dataclass(frozen=True)
class _LinePhases:
    """Phases at a row's nodes from the one on its line: exp(1j * shifts) * (conj where turned)(phase).

    On the line the phase is meant in the sheet in which it grows to the line's left.
    """

    nodes: np.ndarray
    shifts: np.ndarray
    turned: np.ndarray

    @classmethod
    def of(cls, row, field, rates):
        line = row.line
        # The phase grows a quarter turn counterclockwise from the stripe: this is its growth to the left.
        growth = np.cos(field.angles[line.vertices] - line.angles)
        shifts = line.means(np.where(line.offsets == 0, 0, rates[line.vertices] * line.offsets * growth))
        turned = (line.means(growth) < 0) & (field.symmetry == 2)
        return cls(line.nodes, shifts, turned)

    def values(self, phase):
        """(k,) complex phases for the line's phase in radians."""
        return np.exp(1j * (self.shifts + np.where(self.turned, -phase, phase)))


@dataclass(frozen=True)
class _Link:
    """phase_j = exp(1j * angles) * (conj where flips)(phase_i), and the name of the row that says so."""

    i: np.ndarray
    j: np.ndarray
    angles: np.ndarray
    flips: np.ndarray
    names: np.ndarray


def phase_constraints(mesh, field, rates, rows):
    """Fixed, merged and drawn phases of a stripe pattern: (Targets or None, Merged or None, list of Targets).

    Parameters
    ----------
    mesh : TriangleMesh
    field : DirectionField along which stripes run
    rates : (n,) phase per unit length
    rows : Rows of the kinds "phase" and "constant"

    Raises
    ------
    ContradictionError
        when hard rows ask for different phases at a vertex
    """
    phases = [_LinePhases.of(row, field, rates) for row in rows]
    hard = [(row, p) for row, p in zip(rows, phases, strict=True) if row.kind == "phase" and row.is_hard]
    constant = [(row, p) for row, p in zip(rows, phases, strict=True) if row.kind == "constant"]
    fixed = merged = None
    if hard:
        fixed = _agreed(
            np.concatenate([p.nodes for _, p in hard]),
            np.concatenate([p.values(row.value) for row, p in hard]),
            np.concatenate([np.full(len(p.nodes), row.name, object) for row, p in hard]),
        )
    if constant:
        fixed, merged = _contracted(mesh.vertex_count, _joined([_links(row, p) for row, p in constant]), fixed)
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
    return _Link(phases.nodes[root], phases.nodes, angles, flips, np.full(len(root), row.name, object))


def _joined(links):
    names = _Link.__dataclass_fields__
    return _Link(*(np.concatenate([getattr(link, name) for link in links]) for name in names))


def _contracted(count, links, fixed):
    """Groups that links join: those with a fixed node become fixed, the others merge into their first node."""
    members = np.unique([links.i, links.j])
    lead, angles, flips = _from_leads(count, links)
    closing = links.angles + np.where(links.flips, -angles[links.i], angles[links.i]) - angles[links.j]
    torn = np.abs(np.exp(1j * closing) - 1) > TOLERANCE
    torn |= flips[links.i] ^ links.flips ^ flips[links.j]
    if torn.any():
        raise ContradictionError(
            f"{links.names[torn][0]} cannot keep its phase constant at {{vertices}}: "
            "another row comes back to it with another phase, remove one of them",
            links.j[torn],
        )
    free = np.ones(count, bool)
    if fixed is not None and np.isin(fixed.nodes, members).any():
        inside = np.isin(fixed.nodes, members)
        known = fixed.nodes[inside]
        at_lead = np.exp(-1j * angles[known]) * fixed.values[inside]
        at_lead = np.where(flips[known], at_lead.conj(), at_lead)
        leading = _agreed(lead[known], at_lead, [f"the phase fixed at vertex {node}" for node in known])
        reached = members[np.isin(lead[members], leading.nodes)]
        value = leading.values[np.searchsorted(leading.nodes, lead[reached])]
        value = np.exp(1j * angles[reached]) * np.where(flips[reached], value.conj(), value)
        nodes = np.concatenate([fixed.nodes[~inside], reached])
        fixed = Targets(nodes, np.concatenate([fixed.values[~inside], value]))
        free[reached] = False
    led = members[free[members] & (lead[members] != members)]
    merged = Merged(led, lead[led], circle_transports(angles[led], flips[led])) if len(led) else None
    return fixed, merged


def _from_leads(count, links):
    """(n,) the first node of each node's group, and angle and flip of the link from there."""
    graph = coo_matrix((np.ones(len(links.i)), (links.i, links.j)), shape=(count, count)).tocsr()
    _, first, place = np.unique(connected_components(graph, directed=False)[1], return_index=True, return_inverse=True)
    lead = first[place]
    step = {}
    for i, j, angle, flip in zip(*(a.tolist() for a in (links.i, links.j, links.angles, links.flips)), strict=True):
        step[i, j] = angle, flip
        step[j, i] = (angle if flip else -angle), flip
    angles, flips = np.zeros(count), np.zeros(count, bool)
    for root in np.unique(lead[links.i]):
        order, before = breadth_first_order(graph, root, directed=False)
        for node in order[1:].tolist():
            angle, flip = step[int(before[node]), node]
            angles[node] = angle + (-angles[before[node]] if flip else angles[before[node]])
            flips[node] = flips[before[node]] ^ flip
    return lead, angles, flips
