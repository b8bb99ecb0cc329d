# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums over all rows of a matrix, which may be distributed over processes."""

from typing import TypeVar

import numpy as np

Numbers = TypeVar("Numbers")


class Reductions:
    """Sums for a process that holds all rows; ``bench/mpi/rows.py`` has one for several."""

    is_whole = True

    def sum(self, numbers: Numbers) -> Numbers:
        """Sum numbers or arrays over all processes."""
        return numbers

    def max(self, numbers: Numbers) -> Numbers:
        """Find the largest of numbers or arrays over all processes."""
        return numbers

    def norm(self, vector: np.ndarray) -> float:
        """Compute the length of a vector."""
        return np.linalg.norm(vector)


HERE = Reductions()
