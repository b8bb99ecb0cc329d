# SPDX-License-Identifier: GPL-3.0-or-later
"""The phases that lines are drawn at."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Levels:
    """Phases of lines in units of pi: the same ones in every period of 2, and with each of them its negative.

    A level has a *label*, which changes from sheet to sheet as phases do: by the sign, and by multiples of 2. Labels
    are integers and halves, and compare exactly.

    Attributes
    ----------
    values, labels : (m,) the levels of the period [-1, 1) in increasing order; labels that are integers are the values
    """

    values: np.ndarray
    labels: np.ndarray

    @property
    def count(self):
        """Levels in a period."""
        return len(self.values)

    def above(self, phases):
        """Number of the lowest level above phases; they are numbered upwards."""
        return self._number(phases, "right")

    def not_below(self, phases):
        """Number of the lowest level that is not below phases."""
        return self._number(phases, "left")

    def _number(self, phases, side):
        period = np.floor((phases + 1) / 2)
        place = np.searchsorted(self.values, phases - 2 * period, side=side)
        return period.astype(int) * self.count + place

    def value(self, numbers):
        return self.values[numbers % self.count] + 2 * (numbers // self.count)

    def label(self, numbers):
        return self.labels[numbers % self.count] + 2 * (numbers // self.count)

    def nearest(self, phases):
        """The values of the levels nearest to phases."""
        above = self.above(phases)
        high, low = self.value(above), self.value(above - 1)
        return np.where(high - phases < phases - low, high, low)


# The lines of a grid: all multiples of pi.
GRID = Levels(np.array([-1.0, 0.0]), np.array([-1.0, 0.0]))
# Narrowest stripe and gap whose two edges are told apart, as parts of a period.
_NARROWEST = 1e-3


def stripe_levels(width):
    """The edges of stripes that take a part ``width`` of a period; the middles of stripes for 0, of gaps for 1."""
    if width in (0, 1):
        return Levels(np.array([-float(width)]), np.array([-float(width)]))
    place = float(np.clip(width, _NARROWEST, 1 - _NARROWEST))
    return Levels(np.array([-place, place]), np.array([-0.5, 0.5]))
