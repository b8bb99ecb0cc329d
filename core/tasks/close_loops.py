# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes with short loops: grid lines around limbs and handles are made to close, the cheapest first."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import Cancelled, SynchError
from ..extract.quads.measure.loops import SHORT, quad_loops
from ..extract.quads.measure.near_loops import near_loops
from ..extract.quads.trace.quad_mesh import QuadMesh
from ..fields.loop_closing import Condition, LoopClosing, MeshWalks, cosines
from ..fields.patterns import Pattern, change_pattern
from ..memory import check_memory
from ..monitor import Callback, Monitor
from ..solution import FIRST

if TYPE_CHECKING:
    from .surfaces import SurfaceRequest

# Prices: the share of a mesh's loops that must become short for a cost as large as the pattern's energy. The search
# begins with the best bargains.
PRICES = (0.3, 0.1, 0.03, 0.01, 0.003)
# Smallest share of the mesh's loops for which a class is considered, and number of classes, the largest first.
LEAST_GAIN, MOST_CLASSES = 1e-3, 60
# Most arrays of the size of all changes that each class needs.
HELD_ARRAYS = 8
# Conditions whose changes have a larger cosine than this are nearly parallel.
ALIKE = 0.97
# A mesh is kept if its share of short loops exceeds the best one so far by this.
BETTER = 3e-3
# Largest relative change of the number of faces, and deviation from a number that is asked for; factor and number by
# which irregular vertices may increase.
NEAR_COUNT, NEAR_ASKED = 0.06, 0.03
MORE_IRREGULAR, SPARE_IRREGULAR = 1.1, 2
# Most meshes that are tried.
TRIES = 30
# Most patterns in a row without an improvement, each chosen from the previous one.
AHEAD = 3
# Where the phases leave a walk open though the asked sum is 0, the sum is moved this many radians the other way; number
# of solves in all.
PUSH, PUSHES = 1.0, 3


@dataclass(frozen=True)
class _Closed:
    """A pattern with loops closed by conditions, its quad mesh before smoothing, and the cost of the conditions.

    The cost is that of the changes that are added for them (see :mod:`..fields.loop_closing`).
    """

    pattern: Pattern
    quads: QuadMesh
    conditions: list[Condition]
    cost: float

    @property
    def short_share(self) -> float:
        return quad_loops(self.quads).short_share


def close_loops(
    request: "SurfaceRequest", pattern: Pattern, progress: Callback | None = None
) -> tuple[Pattern, dict[str, float] | None]:
    """The pattern with more of its quads in short loops, and the figures of the loops before; None if it is unchanged.

    Loops of up to 5 sqrt(f) of f quads are short (:attr:`QuadLoops.short_share`). The changes that all conditions add
    may cost, in units of energy, ``loops / (1 - loops)`` times the energy of the pattern, whose branching is 0.
    """
    try:
        given = _Closed(pattern, _whole_quads(request, pattern), [], 0.0)
    except SynchError:  # reported when the mesh is finished
        return pattern, None
    if not pattern.energy:
        return pattern, None
    search = _Search(request, given, 2 * pattern.energy, Monitor(progress))
    for number, price in enumerate(PRICES):
        search.fraction = number / len(PRICES)
        while search.improve(price):
            pass
    return search.best.pattern, None if search.best is given else quad_loops(given.quads).figures


@dataclass(frozen=True)
class _Offers:
    """Conditions that would close more loops, and (k,) the share of all loops that each would close.

    A gain of 0 means that it is too small, or that the condition has been tried in vain.
    """

    conditions: list[Condition]
    gains: list[float]


class _Search:
    """Search for the best pattern with closed loops."""

    def __init__(self, request: "SurfaceRequest", given: _Closed, unit: float, monitor: Monitor) -> None:
        self._request, self._given, self._monitor = request, given, monitor
        numbers = given.pattern.one_form.changes.size
        check_memory(8 * numbers * HELD_ARRAYS * MOST_CLASSES, "closing loops")
        self._closing = LoopClosing(given.pattern, request.mirrors)
        self._walks = MeshWalks(given.pattern.mesh)
        # The cost of a correction is a sum of squares, the energy half of one: the unit is twice the energy.
        self._unit, self._tries_left = unit, TRIES
        loops = request.settings.loops
        self._budget = (loops / (1 - loops) if loops < 1 else np.inf) * unit
        self.best, self.fraction = given, 0.0
        self._offers = self._look(given)

    def improve(self, price: float) -> bool:
        """Close more loops at a price; False if no better pattern was found."""
        while self._tries_left > 0:
            chosen = self._choose(self.best, self._offers, price)
            if not chosen:
                return False
            if self._follow(chosen, price):
                return True
            self._offers.gains[chosen[0]] = 0.0  # not tried again
        return False

    def _follow(self, chosen: list[int], price: float) -> bool:
        """Apply the chosen conditions, then further ones, until the pattern is better; False if it never is."""
        state, offers = self.best, self._offers
        for _ in range(AHEAD):
            tried = None
            while chosen and tried is None and self._tries_left > 0:
                tried = self._try([*state.conditions, *(offers.conditions[number] for number in chosen)])
                chosen = chosen[: len(chosen) // 2]
            if tried is None:
                return False
            state, offers = tried, self._look(tried)
            if state.short_share > self.best.short_share + BETTER:
                self.best, self._offers = state, offers
                return True
            chosen = self._choose(state, offers, price)
        return False

    def _choose(self, state: _Closed, offers: _Offers, price: float) -> list[int]:
        """Numbers of the conditions that gain enough for their cost."""
        most = self._budget - state.cost
        return self._closing.choose(state.conditions, offers.conditions, offers.gains, price / self._unit, most)

    def _look(self, state: _Closed) -> _Offers:
        """Conditions that would close more loops of a pattern."""
        quads, reached = state.quads, state.pattern.edge_phases.changes
        near = near_loops(quads, int(SHORT * np.sqrt(len(quads.sizes))))
        shares = near.quads / (2 * len(quads.sizes))
        found, gains = [], []
        for number in np.argsort(-shares, kind="stable")[:MOST_CLASSES]:
            self._tell()
            walk = self._walks.near(quads, near.walks[number])
            condition = self._closing.condition(walk, reached, near.steps[number], near.asides[number])
            if condition is not None:
                found.append(condition)
                gains.append(shares[number])
        # Loops around one limb give nearly parallel conditions, even if irregular vertices lie between them or if they
        # go around several times: the first represents all.
        alike = np.abs(cosines(found)) > ALIKE
        first = alike.argmax(axis=1) if len(found) else np.zeros(0, int)
        sums = np.bincount(first, gains, minlength=len(found))
        sums[sums < LEAST_GAIN] = 0
        return _Offers(found, sums.tolist())

    def _tell(self, *_: object) -> None:
        self._monitor.at("closing loops", self.fraction)

    def _try(self, conditions: list[Condition]) -> _Closed | None:
        """The pattern with these conditions; None if its mesh is worse in other ways."""
        self._tries_left -= 1
        options = replace(self._request.options, method=FIRST)
        sums = np.zeros(len(conditions))
        try:
            for _ in range(PUSHES):
                correction, cost = self._closing.correction(conditions, sums)
                pattern = change_pattern(self._given.pattern, correction, options, self._tell)
                reached = np.array([c.row @ pattern.edge_phases.changes.ravel() for c in conditions])
                is_open = np.abs(reached) > 0.5 * np.pi
                if not is_open.any():
                    break
                sums[is_open] -= PUSH * np.sign(reached[is_open])
            if cost > self._budget:
                return None
            quads = _whole_quads(self._request, pattern)
        except Cancelled:
            raise
        except SynchError:
            return None
        before = self._given.quads
        faces = self._request.settings.faces
        wanted, near = (len(before.sizes), NEAR_COUNT) if not faces else (faces, NEAR_ASKED)
        is_near = abs(len(quads.sizes) / wanted - 1) <= near
        is_regular = quads.is_irregular.sum() <= MORE_IRREGULAR * before.is_irregular.sum() + SPARE_IRREGULAR
        has_quads = (quads.sizes == 4).mean() >= (before.sizes == 4).mean()
        return _Closed(pattern, quads, conditions, cost) if is_near and is_regular and has_quads else None


def _whole_quads(request: "SurfaceRequest", pattern: Pattern) -> QuadMesh:
    """The quad mesh of a pattern before smoothing."""
    return request.smoothed(0).finish(*request.trace(pattern))["quads"]
