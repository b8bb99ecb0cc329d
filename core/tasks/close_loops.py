# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes with short loops: the grid lines of limbs and handles are asked to close, the cheapest first."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..errors import Cancelled, SynchError
from ..extract.quads.measure.loops import quad_loops
from ..extract.quads.measure.near_loops import near_loops
from ..extract.quads.trace.quad_mesh import QuadMesh
from ..fields.loop_closing import LoopClosing, MeshWalks
from ..fields.patterns import Pattern, change_pattern
from ..monitor import Monitor
from ..solution import FIRST

# Share of a mesh's loops that an energy as large as the pattern's has to bring into short ones: first for the cheapest
# loops, then for dearer ones.
PRICES = (0.3, 0.1, 0.03, 0.01, 0.003)
# Of a class of loops, the least share of the mesh's loops that closing it is for; how many classes are looked at.
LEAST_GAIN, MOST_CLASSES = 2e-3, 60
# What a mesh has to have in short loops more than the best one, to be kept.
BETTER = 3e-3
# How much the number of faces, and of irregular vertices, may change.
NEAR_COUNT, MORE_IRREGULAR, SPARE_IRREGULAR = 0.06, 1.1, 2
# Patterns that are tried at most.
TRIES = 24


@dataclass(frozen=True)
class _Closed:
    """A pattern whose loops are closed where conditions ask for it.

    Attributes
    ----------
    pattern : Pattern
    quads : QuadMesh of it, not smoothed
    conditions : list of Condition
    cost : what they raise the sum of squares of the asked changes by
    """

    pattern: Pattern
    quads: QuadMesh
    conditions: list[Any]
    cost: float

    @property
    def short_share(self):
        return quad_loops(self.quads).short_share


def close_loops(request, pattern, progress=None):
    """The pattern with more of its quads in short loops as far as energy allows, and the figures of the given loops.

    Loops are short where they pass at most 5 sqrt(f) of f quads (:attr:`QuadLoops.short_share`). The conditions that
    are held may cost ``loops / (1 - loops)`` times the pattern's energy.

    Parameters
    ----------
    request : SurfaceRequest with its share ``loops``
    pattern : Pattern without dislocations
    progress : callback, optional
    """
    monitor = Monitor(progress)
    try:
        given = _Closed(pattern, _whole_quads(request, pattern), [], 0.0)
    except SynchError:  # whoever finishes the mesh says what is wrong
        return pattern, None
    figures = quad_loops(given.quads).figures
    if pattern.energy == 0:
        return pattern, figures
    budget = 2 * pattern.energy * (request.loops / (1 - request.loops) if request.loops < 1 else np.inf)
    search = _Search(request, given, budget, monitor)
    for number, price in enumerate(PRICES):
        search.fraction = number / len(PRICES)
        while search.improve(price):
            pass
    return search.best.pattern, figures


class _Search:
    """The best pattern so far, and what closes more of its loops."""

    def __init__(self, request, given, budget, monitor):
        self._request, self._given, self._budget, self._monitor = request, given, budget, monitor
        self._closing, self._walks = LoopClosing(given.pattern), MeshWalks(given.pattern.mesh)
        self._tries, self._left = TRIES, {}
        self.best, self.fraction = given, 0.0

    def improve(self, price):
        """Close more loops at a price; whether there is a better pattern."""
        conditions, gains = self._candidates()
        energy = self._given.pattern.energy
        most = self._budget - self.best.cost
        chosen = self._closing.choose(self.best.conditions, conditions, gains, price / (2 * energy), most)
        # All at once; where that is worse, the better half, and so on.
        while chosen and self._tries > 0:
            self._tries -= 1
            tried = self._try([*self.best.conditions, *(conditions[number] for number in chosen)])
            if tried is not None and tried.short_share > self.best.short_share + BETTER:
                self.best, self._left = tried, {}
                return True
            chosen = chosen[: len(chosen) // 2]
        return False

    def _candidates(self):
        """Conditions that would close more of the best pattern's loops, and the share of all loops in each."""
        if self._left:
            return self._left["candidates"]
        quads, reached = self.best.quads, self.best.pattern.edge_phases.changes
        near = near_loops(quads, int(5 * np.sqrt(len(quads.sizes))))
        gains = near.quads / (2 * len(quads.sizes))
        conditions, kept = [], []
        for number in np.argsort(-gains, kind="stable")[:MOST_CLASSES]:
            if gains[number] < LEAST_GAIN:
                break
            self._monitor.at("closing loops", self.fraction)
            walk = self._walks.near(quads, near.walks[number])
            condition = self._closing.condition(walk, reached, near.steps[number], near.asides[number])
            if condition is not None:
                conditions.append(condition)
                kept.append(gains[number])
        self._left["candidates"] = conditions, np.array(kept)
        return self._left["candidates"]

    def _try(self, conditions):
        """The :class:`_Closed` of conditions; None where its mesh is worse in other ways."""
        correction, cost = self._closing.correction(conditions)
        options = replace(self._request.options, method=FIRST)
        self._monitor.at("closing loops", self.fraction)
        try:
            pattern = change_pattern(self._given.pattern, correction, options)
            quads = _whole_quads(self._request, pattern)
        except Cancelled:
            raise
        except SynchError:
            return None
        before = self._given.quads
        is_near = abs(len(quads.sizes) / len(before.sizes) - 1) <= NEAR_COUNT
        is_regular = quads.is_irregular.sum() <= MORE_IRREGULAR * before.is_irregular.sum() + SPARE_IRREGULAR
        has_quads = (quads.sizes == 4).mean() >= (before.sizes == 4).mean()
        return _Closed(pattern, quads, conditions, cost) if is_near and is_regular and has_quads else None


def _whole_quads(request, pattern):
    """The QuadMesh of a pattern, not smoothed."""
    return replace(request, smoothing=0).finish(*request.trace(pattern))["quads"]
