# SPDX-License-Identifier: GPL-3.0-or-later
"""The phases that lines are drawn at."""

from dataclasses import dataclass
from typing import Literal

import numpy as np


@dataclass(frozen=True)
class Levels:
    """Phases of lines in units of pi, with period 2 and symmetric about 0.

    The *label* of a level changes between sheets as phases do, by the sign and by multiples of 2. Labels are integers
    or halves, so that they compare exactly; an integer label equals the value. ``values, labels``: (m,) the levels of
    the period [-1, 1), in increasing order.
    """

    values: np.ndarray
    labels: np.ndarray

    @property
    def count(self) -> int:
        """Number of levels in a period."""
        return len(self.values)

    def above(self, phases: np.ndarray) -> np.ndarray:
        """Number of the lowest level above phases; levels are numbered upwards."""
        return self._number(phases, "right")

    def not_below(self, phases: np.ndarray) -> np.ndarray:
        """Number of the lowest level that is not below phases."""
        return self._number(phases, "left")

    def _number(self, phases: np.ndarray, side: Literal["left", "right"]) -> np.ndarray:
        period = np.floor((phases + 1) / 2)
        place = np.searchsorted(self.values, phases - 2 * period, side=side)
        return period.astype(int) * self.count + place

    def value(self, numbers: np.ndarray) -> np.ndarray:
        return self.values[numbers % self.count] + 2 * (numbers // self.count)

    def label(self, numbers: np.ndarray) -> np.ndarray:
        return self.labels[numbers % self.count] + 2 * (numbers // self.count)

    def nearest(self, phases: np.ndarray) -> np.ndarray:
        """Values of the levels nearest to phases."""
        above = self.above(phases)
        high, low = self.value(above), self.value(above - 1)
        return np.where(high - phases < phases - low, high, low)


# Grid lines are at all multiples of pi.
GRID = Levels(np.array([-1.0, 0.0]), np.array([-1.0, 0.0]))
# Smallest width of a stripe or gap with two distinct edges, as part of a period.
_NARROWEST = 1e-3


def stripe_levels(width: float) -> Levels:
    """Edges of stripes that fill the part ``width`` of a period; the middles of stripes for 0, of gaps for 1."""
    if width in (0, 1):
        return Levels(np.array([-float(width)]), np.array([-float(width)]))
    place = float(np.clip(width, _NARROWEST, 1 - _NARROWEST))
    return Levels(np.array([-place, place]), np.array([-0.5, 0.5]))
