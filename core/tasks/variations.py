# SPDX-License-Identifier: GPL-3.0-or-later
"""Searches for other patterns and direction fields of the same solve."""

from dataclasses import dataclass

import numpy as np

from ..fields.directions import SolvedField
from ..fields.patterns import Pattern
from ..fields.placement import nearest_variation
from ..monitor import Callback


@dataclass(frozen=True)
class VariationRequest:
    """Search the nearest of some variations, as of :func:`nearest_variation`.

    Attributes
    ----------
    solved : what was solved
    numbers : of the variations that are tried
    """

    solved: Pattern | SolvedField
    numbers: tuple[int, ...]

    def solve(self, progress: Callback | None = None) -> tuple[int, np.ndarray]:
        """The number and the phases of the variation."""
        return nearest_variation(self.solved, self.numbers, progress)
