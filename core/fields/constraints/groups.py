# SPDX-License-Identifier: GPL-3.0-or-later
"""Linked nodes on the circle, merged into one node, or fixed together with one of them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...connection import circle_transports
from ...errors import ContradictionError
from ...geometry.triangle_mesh import TriangleMesh
from ...graphs import components, sum_by, walk_trees
from ...problem import Merged, Targets

# Unit values that differ by more contradict each other; positions in single precision change angles by less.
TOLERANCE = 1e-4


class OneForm(Protocol):
    """The part of a :class:`core.fields.target_one_form.TargetOneForm` that constraints use."""

    @property
    def mesh(self) -> TriangleMesh: ...
    @property
    def angles(self) -> np.ndarray: ...
    @property
    def rates(self) -> np.ndarray: ...
    @property
    def matchings(self) -> np.ndarray: ...
    @property
    def has_signs(self) -> bool: ...
    @property
    def phase_count(self) -> int: ...
    @property
    def turn(self) -> float: ...


@dataclass(frozen=True)
class Links:
    """Links between phases: phase_j = exp(1j * angle) * phase_i, with phase_i conjugated where the link flips.

    ``names`` are the rows or settings that ask for them, for messages.
    """

    i: np.ndarray
    j: np.ndarray
    angles: np.ndarray
    flips: np.ndarray
    names: np.ndarray

    def chosen(self, rows: np.ndarray) -> "Links":
        """Some of the links, by indices or a mask."""
        return Links(self.i[rows], self.j[rows], self.angles[rows], self.flips[rows], self.names[rows])


def join_links(parts: Iterable[Links]) -> Links:
    """Concatenate any number of :class:`Links`."""
    none = Links(np.empty(0, int), np.empty(0, int), np.empty(0), np.empty(0, bool), np.empty(0, object))
    names = Links.__dataclass_fields__
    return Links(*(np.concatenate([getattr(part, name) for part in (none, *parts)]) for name in names))


def fixed_phases(parts: Sequence[tuple[str, np.ndarray, np.ndarray]], remedy: str) -> Targets:
    """The fixed phases of several sources, each node once; a part is the name of a source, (k,) nodes and (k,) complex
    values.

    Raises :class:`ContradictionError`, with a remedy, for nodes that are fixed to different phases.
    """
    if not parts:
        return Targets.none()
    nodes, values = (np.concatenate(arrays) for arrays in list(zip(*parts, strict=True))[1:])
    names = np.concatenate([np.full(len(met), name, object) for name, met, _ in parts])
    unique, first, place = np.unique(nodes, return_index=True, return_inverse=True)
    apart = np.abs(values - values[first][place]) > TOLERANCE
    if apart.any():
        other = np.flatnonzero(apart)[0]
        raise ContradictionError(
            f"{names[first[place[other]]]} and {names[other]} fix {{vertices}} to different phases: {remedy}",
            nodes[apart],
        )
    return Targets(unique, values[first])


def drop_contradictions(fixed: Targets, gives_way: np.ndarray, links: Links, slack: float) -> Targets:
    """Drop the fixed values that differ from others by more than the slack through a link, where (k,) bool they may
    give way."""
    values = np.full(
        max(links.i.max(initial=-1), links.j.max(initial=-1), fixed.nodes.max(initial=-1)) + 1, np.nan, complex
    )
    values[fixed.nodes] = fixed.values
    start = values[links.i]
    apart = np.abs(np.exp(1j * links.angles) * np.where(links.flips, start.conj(), start) - values[links.j]) > slack
    contradicts = np.isin(fixed.nodes, np.append(links.i[apart], links.j[apart]))
    keep = ~(gives_way & contradicts)
    return Targets(fixed.nodes[keep], fixed.values[keep])


def contract_groups(count: int, links: Links, fixed: Targets, slack: float = TOLERANCE) -> tuple[Targets, Merged]:
    """Fixed and merged nodes of linked groups: a group with a fixed node is fixed, others merge into their first node.

    Linked unit values may differ by the slack; those that are joined are averaged. Raises :class:`ContradictionError`
    when links come back with another phase, or join nodes that are fixed to different ones.
    """
    if len(links.i) == 0:
        return fixed, Merged.none()
    members = np.unique([links.i, links.j])
    lead, angles, flips = walk_from_leads(count, links)
    closing = links.angles + np.where(links.flips, -angles[links.i], angles[links.i]) - angles[links.j]
    torn = np.abs(np.exp(1j * closing) - 1) > slack
    torn |= flips[links.i] ^ links.flips ^ flips[links.j]
    if torn.any():
        raise ContradictionError(
            f"{links.names[torn][0]} cannot keep its phase constant at {{vertices}}: "
            "another row comes back to it with another phase, remove one of them",
            links.j[torn],
        )
    free = np.ones(count, bool)
    inside = np.isin(fixed.nodes, members)
    if inside.any():
        known = fixed.nodes[inside]
        at_lead = np.exp(-1j * angles[known]) * fixed.values[inside]
        at_lead = np.where(flips[known], at_lead.conj(), at_lead)
        leading = _agree_leads(links, lead, known, at_lead, slack)
        reached = members[np.isin(lead[members], leading.nodes)]
        value = leading.values[np.searchsorted(leading.nodes, lead[reached])]
        value = np.exp(1j * angles[reached]) * np.where(flips[reached], value.conj(), value)
        nodes = np.concatenate([fixed.nodes[~inside], reached])
        fixed = Targets(nodes, np.concatenate([fixed.values[~inside], value]))
        free[reached] = False
    led = members[free[members] & (lead[members] != members)]
    return fixed, Merged(led, lead[led], circle_transports(angles[led], flips[led]))


def _agree_leads(links: Links, lead: np.ndarray, known: np.ndarray, at_lead: np.ndarray, slack: float) -> Targets:
    """The target of each lead, from the (k,) values there that known nodes imply; refuses different ones."""
    leads, first, place = np.unique(lead[known], return_index=True, return_inverse=True)
    apart = np.abs(at_lead - at_lead[first][place]) > slack
    if apart.any():
        name = links.names[lead[links.j] == lead[known[apart][0]]][0]
        raise ContradictionError(
            f"{name} joins {{vertices}}, for which different values are asked: make them agree, or ask for one only",
            np.append(known[apart], known[first[place[apart]]]),
        )
    sums = sum_by(place, at_lead)
    return Targets(leads, sums / np.abs(sums))


def walk_from_leads(count: int, links: Links) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(n,) the first node of each node's group, and angle and flip of the walk from there, whole turns included."""
    pairs = np.column_stack([links.i, links.j])
    labels = components(count, pairs)
    lead = np.unique(labels, return_index=True)[1][labels]
    step = {}
    for i, j, angle, flip in zip(*(a.tolist() for a in (links.i, links.j, links.angles, links.flips)), strict=True):
        step[i, j] = angle, flip
        step[j, i] = (angle if flip else -angle), flip
    nodes, before, _ = walk_trees(count, pairs)
    angles, flips = np.zeros(count), np.zeros(count, bool)
    for node, last in zip(nodes.tolist(), before.tolist(), strict=True):
        angle, flip = step[last, node]
        angles[node] = angle + (-angles[last] if flip else angles[last])
        flips[node] = flips[last] ^ flip
    return lead, angles, flips
