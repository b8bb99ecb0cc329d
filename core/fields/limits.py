# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers whose distance stays between limits, such as the lowest and the highest bead that a nozzle can lay.

Even layers branch, and where one ends it is pinched between its neighbours. With a smaller share of the branches
(:mod:`.curl_removal`) fewer layers end, but distances vary more. A search finds the share with the least volume outside
of the limits. Where some is left, for instance between groups whose distance is not a whole number of layers, the
target distance there is corrected by the error.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..interpolate import TURN
from ..monitor import Callback, portion
from ..solution import Options
from .layers import LayerGroup, LayerPattern, SolidTargetOneForm, solve_one_form

# Shares of the branches that are tried, and corrections of the best of them; and the share of the volume outside of
# the limits at which the search ends.
SHARES, CORRECTIONS, ENOUGH = 5, 2, 1e-3
# The factor by which target distances stay away from the limits, if these leave room for it.
_MARGIN = 1.05
# The relative rounding error of a distance at a limit.
_ROUNDING = 1e-6


@dataclass(frozen=True)
class Limits:
    """Smallest and largest distance of layers, in the solid's units."""

    smallest: float = 0.0
    largest: float = math.inf

    @property
    def bind(self) -> bool:
        """Whether any limit is set."""
        return self.smallest > 0 or self.largest < math.inf

    def __str__(self) -> str:
        return f"{self.smallest:g} and {self.largest:g}"

    def clipped(self, distances: np.ndarray) -> np.ndarray:
        """Distances clipped to the limits."""
        return np.clip(distances, self.smallest, self.largest)

    def inside(self, distances: np.ndarray) -> np.ndarray:
        """Target distances: clipped to a little less than the limits."""
        low, high = self.smallest * _MARGIN, self.largest / _MARGIN
        if low > high:
            low = high = math.sqrt(self.smallest * self.largest)
        return np.clip(distances, low, high)

    def outside_share(self, pattern: LayerPattern) -> float:
        """Share of a pattern's volume where layers end, or their distance is outside of the limits."""
        if not self.bind:
            return 0.0
        distances, volumes = pattern.spacings.distances, pattern.mesh.volumes
        kept = (distances >= self.smallest * (1 - _ROUNDING)) & (distances <= self.largest * (1 + _ROUNDING))
        return float(volumes[~kept].sum() / volumes.sum())


def solve_within(
    one_form: SolidTargetOneForm,
    limits: Limits,
    groups: Sequence[LayerGroup] = (),
    options: Options | None = None,
    callback: Callback | None = None,
    branching: float = 1.0,
) -> tuple[LayerPattern, SolidTargetOneForm]:
    """Layers between limits, as far as possible: the best pattern that was tried, and the one-form it was solved for.

    Other arguments as for :func:`core.fields.layers.solve_layers`; ``branching`` is the largest share of the branches.
    """
    most = SHARES + CORRECTIONS if limits.bind else 1
    tried: list[_Tried] = []
    while len(tried) < most and not (tried and min(tried).outside <= ENOUGH):
        number, share = len(tried), branching
        if number < SHARES:
            share = _next_share(tried, branching)
        else:
            best = min(tried) if number == SHARES else tried[-1]
            one_form, share = _correct_distances(best.one_form, best.pattern, limits), best.share
        pattern = solve_one_form(one_form, groups, options, portion(callback, number / most, 1 / most), share)
        tried.append(_Tried(limits.outside_share(pattern), share, number, pattern, one_form))
    best = min(tried)
    return best.pattern, best.one_form


class _Tried(NamedTuple):
    """A solve; the best is the smallest."""

    outside: float
    share: float
    number: int
    pattern: LayerPattern
    one_form: SolidTargetOneForm


def _next_share(tried: list["_Tried"], branching: float) -> float:
    """First all branches, then none, then half way from the best share so far to the better of its neighbours."""
    if len(tried) < 2:
        return branching if not tried else 0.0
    order = sorted(tried, key=lambda one: one.share)
    place = order.index(min(tried))
    beside = [order[k] for k in (place - 1, place + 1) if 0 <= k < len(order)]
    return (order[place].share + min(beside).share) / 2


def _correct_distances(one_form: SolidTargetOneForm, pattern: LayerPattern, limits: Limits) -> SolidTargetOneForm:
    """The one-form with larger distances where layers are too close, and smaller ones where they are too far apart."""
    mesh, distances = one_form.mesh, pattern.spacings.distances
    wider = np.zeros(mesh.tet_count)
    known = np.isfinite(distances)
    wider[known] = np.log(limits.clipped(distances[known]) / distances[known])
    rates = one_form.rates * np.exp(-mesh.at_vertices(wider))[:, None]
    lengths = np.linalg.norm(rates, axis=1)
    known = lengths > 0
    rates[known] *= (TURN / limits.inside(TURN / lengths[known]) / lengths[known])[:, None]
    return replace(one_form, rates=rates, correction=None)
