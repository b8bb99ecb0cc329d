# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes with short loops: the grid lines of limbs and handles are asked to close, the cheapest first."""

from dataclasses import dataclass, replace

import numpy as np

from ..errors import Cancelled, SynchError
from ..extract.quads.measure.loops import SHORT, quad_loops
from ..extract.quads.measure.near_loops import near_loops
from ..extract.quads.trace.quad_mesh import QuadMesh
from ..fields.loop_closing import Condition, LoopClosing, MeshWalks, cosines
from ..fields.patterns import Pattern, change_pattern
from ..memory import check_memory
from ..monitor import Monitor
from ..solution import FIRST

# Prices: the share of a mesh's loops that must become short for a cost as large as the pattern's energy. The search
# begins with the best bargains.
PRICES = (0.3, 0.1, 0.03, 0.01, 0.003)
# Classes with a smaller share of the mesh's loops are ignored; so many classes, the largest, are looked at.
LEAST_GAIN, MOST_CLASSES = 1e-3, 60
# Arrays of all changes that each of them takes at most.
HELD_ARRAYS = 8
# Conditions whose changes have a larger cosine than this are alike.
ALIKE = 0.97
# A mesh is kept where its share in short loops is larger by this than that of the best so far.
BETTER = 3e-3
# How far the number of faces may be from what it was, and from a number that is asked for; how many more irregular
# vertices there may be.
NEAR_COUNT, NEAR_ASKED = 0.06, 0.03
MORE_IRREGULAR, SPARE_IRREGULAR = 1.1, 2
# Meshes that are tried at most.
TRIES = 30
# How many patterns in a row may be no better, where each is chosen from the one before.
AHEAD = 3
# Where the phases leave a walk open though the asked sum is 0, the sum is moved this many radians the other way; the
# number of solves in all.
PUSH, PUSHES = 1.0, 3


@dataclass(frozen=True)
class _Closed:
    """A pattern whose loops are closed where conditions ask for it.

    Attributes
    ----------
    pattern : Pattern
    quads : QuadMesh of it, not smoothed
    conditions : list of Condition
    cost : of what is added to the asked changes for them (see :mod:`..fields.loop_closing`)
    """

    pattern: Pattern
    quads: QuadMesh
    conditions: list[Condition]
    cost: float

    @property
    def short_share(self):
        return quad_loops(self.quads).short_share


def close_loops(request, pattern, progress=None):
    """The pattern with more of its quads in short loops, and the figures of the loops before; None where it stays.

    Loops are short up to 5 sqrt(f) of f quads (:attr:`QuadLoops.short_share`). What all conditions add to the changes
    may cost, measured as the energy is, ``loops / (1 - loops)`` times the pattern's energy.

    Parameters
    ----------
    request : SurfaceRequest with its share ``loops``
    pattern : Pattern of branching 0
    progress : callback, optional
    """
    try:
        given = _Closed(pattern, _whole_quads(request, pattern), [], 0.0)
    except SynchError:  # whoever finishes the mesh says what is wrong
        return pattern, None
    if pattern.energy == 0:
        return pattern, None
    allowed = request.loops / (1 - request.loops) if request.loops < 1 else np.inf
    search = _Search(request, given, allowed, Monitor(progress))
    for number, price in enumerate(PRICES):
        search.fraction = number / len(PRICES)
        while search.improve(price):
            pass
    return search.best.pattern, None if search.best is given else quad_loops(given.quads).figures


@dataclass(frozen=True)
class _Offers:
    """What would close more loops.

    Attributes
    ----------
    conditions : list of Condition
    gains : (k,) the share of all loops that each would close; 0 where that is too little, or was tried in vain
    """

    conditions: list[Condition]
    gains: np.ndarray


class _Search:
    """The best pattern so far, and what closes more of its loops."""

    def __init__(self, request, given, allowed, monitor):
        self._request, self._given, self._monitor = request, given, monitor
        numbers = given.pattern.growth.changes.size
        check_memory(8 * numbers * HELD_ARRAYS * MOST_CLASSES, "closing loops")
        self._closing = LoopClosing(given.pattern, request.mirrors)
        self._walks = MeshWalks(given.pattern.mesh)
        # The energy is half the sum of squares that a correction raises.
        self._unit = 2 * given.pattern.energy
        self._budget, self._tries_left = allowed * self._unit, TRIES
        self.best, self.fraction = given, 0.0
        self._offers = self._look(given)

    def improve(self, price):
        """Close more loops at a price; whether there is a better pattern."""
        while self._tries_left > 0:
            chosen = self._choose(self.best, self._offers, price)
            if not chosen:
                return False
            if self._follow(chosen, price):
                return True
            self._offers.gains[chosen[0]] = 0  # is not tried again
        return False

    def _follow(self, chosen, price):
        """Hold what is chosen, and what that leads to, until there is a better pattern; whether there is one."""
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

    def _choose(self, state, offers, price):
        """Numbers of the conditions that are worth their price."""
        most = self._budget - state.cost
        return self._closing.choose(state.conditions, offers.conditions, offers.gains, price / self._unit, most)

    def _look(self, state):
        """The :class:`_Offers` of a pattern."""
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
        # Loops around one limb give nearly parallel conditions, also with irregular vertices between them and where
        # they go around several times: the first stands for all.
        alike = np.abs(cosines(found)) > ALIKE
        first = alike.argmax(axis=1) if len(found) else np.zeros(0, int)
        sums = np.bincount(first, gains, minlength=len(found))
        sums[sums < LEAST_GAIN] = 0
        return _Offers(found, sums)

    def _tell(self, *_):
        self._monitor.at("closing loops", self.fraction)

    def _try(self, conditions):
        """The :class:`_Closed` of conditions; None where its mesh is worse in other ways."""
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
        faces = self._request.faces
        wanted, near = (len(before.sizes), NEAR_COUNT) if faces is None else (faces, NEAR_ASKED)
        is_near = abs(len(quads.sizes) / wanted - 1) <= near
        is_regular = quads.is_irregular.sum() <= MORE_IRREGULAR * before.is_irregular.sum() + SPARE_IRREGULAR
        has_quads = (quads.sizes == 4).mean() >= (before.sizes == 4).mean()
        return _Closed(pattern, quads, conditions, cost) if is_near and is_regular and has_quads else None


def _whole_quads(request, pattern):
    """The QuadMesh of a pattern, not smoothed."""
    return replace(request, smoothing=0).finish(*request.trace(pattern))["quads"]
