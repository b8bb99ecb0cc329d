# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers whose distance stays between limits, such as the lowest and the highest bead that a nozzle lays.

Even layers branch, and where one ends it is pinched between those beside it. With a smaller share of the branches
(:mod:`.curl_removal`) fewer end, and distances vary more. In between there is a share with the least outside of the
limits, which is searched for. What is left there, for instance between groups that are no whole number of layers apart,
is asked to be wider, or narrower, by what it is off.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..errors import SettingError
from ..interpolate import TURN
from ..monitor import portion
from .layers import LayerPattern, SolidTargetOneForm, solve_growth

# Shares of the branches that are tried, and corrections for the best of them; and the share of the volume outside of
# the limits from which on no more are.
SHARES, CORRECTIONS, ENOUGH = 5, 2, 1e-3
# What is asked for stays away from the limits by this factor, where they are as far apart.
_MARGIN = 1.05
# Of a distance that is at a limit.
_ROUNDING = 1e-6


@dataclass(frozen=True)
class Limits:
    """Smallest and largest distance of layers, in the solid's units.

    Raises
    ------
    SettingError
        for limits that nothing is between
    """

    smallest: float = 0.0
    largest: float = math.inf

    def __post_init__(self):
        if not 0 <= self.smallest < self.largest:
            raise SettingError(
                f"no layer is between {self} high: give a smallest height from 0 on, and a largest one above it"
            )

    @property
    def bind(self):
        """Whether there are any."""
        return self.smallest > 0 or self.largest < math.inf

    def __str__(self):
        return f"{self.smallest:g} and {self.largest:g}"

    def clipped(self, distances):
        """Distances between the limits."""
        return np.clip(distances, self.smallest, self.largest)

    def inside(self, distances):
        """Distances that are asked for: between the limits, and a little away from them."""
        low, high = self.smallest * _MARGIN, self.largest / _MARGIN
        if low > high:
            low = high = math.sqrt(self.smallest * self.largest)
        return np.clip(distances, low, high)

    def outside_share(self, pattern):
        """Share of a :class:`LayerPattern`'s volume where layers end, or their distance is outside of the limits."""
        if not self.bind:
            return 0.0
        distances, volumes = pattern.spacings.distances, pattern.mesh.volumes
        kept = (distances >= self.smallest * (1 - _ROUNDING)) & (distances <= self.largest * (1 + _ROUNDING))
        return float(volumes[~kept].sum() / volumes.sum())


def solve_within(growth, limits, groups=(), options=None, callback=None, branching=1.0):
    """Layers between limits, as far as can be.

    Parameters
    ----------
    growth : SolidGrowth
    limits : Limits
    groups, options, callback, branching : as for :func:`core.fields.layers.solve_layers`; the share of the branches is
        not exceeded

    Returns
    -------
    pattern : LayerPattern with the least share outside of the limits of all that were tried
    growth : the SolidGrowth that it was solved for
    """
    most = SHARES + CORRECTIONS if limits.bind else 1
    tried: list[_Tried] = []
    while len(tried) < most and not (tried and min(tried).outside <= ENOUGH):
        number, share = len(tried), branching
        if number < SHARES:
            share = _next_share(tried, branching)
        else:
            best = min(tried) if number == SHARES else tried[-1]
            growth, share = _correct_distances(best.growth, best.pattern, limits), best.share
        pattern = solve_growth(growth, groups, options, portion(callback, number / most, 1 / most), share)
        tried.append(_Tried(limits.outside_share(pattern), share, number, pattern, growth))
    best = min(tried)
    return best.pattern, best.growth


class _Tried(NamedTuple):
    """A solve, the better one first."""

    outside: float
    share: float
    number: int
    pattern: LayerPattern
    growth: SolidTargetOneForm


def _next_share(tried, branching):
    """All branches, none, and then half way from the best share so far to the better of its neighbours."""
    if len(tried) < 2:
        return branching if not tried else 0.0
    order = sorted(tried, key=lambda one: one.share)
    place = order.index(min(tried))
    beside = [order[k] for k in (place - 1, place + 1) if 0 <= k < len(order)]
    return (order[place].share + min(beside).share) / 2


def _correct_distances(growth, pattern, limits):
    """What is asked for, wider where layers are too near to one another and narrower where they are too far apart."""
    mesh, distances = growth.mesh, pattern.spacings.distances
    wider = np.zeros(mesh.tet_count)
    known = np.isfinite(distances)
    wider[known] = np.log(limits.clipped(distances[known]) / distances[known])
    rates = growth.rates * np.exp(-mesh.at_vertices(wider))[:, None]
    lengths = np.linalg.norm(rates, axis=1)
    known = lengths > 0
    rates[known] *= (TURN / limits.inside(TURN / lengths[known]) / lengths[known])[:, None]
    return replace(growth, rates=rates, correction=None)
