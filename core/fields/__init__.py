# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields and patterns, each solved as a synchronization problem."""

from .constraints.lines import Line, boundary_line, line_of_edges
from .constraints.rows import Row
from .directions import DirectionField, DirectionWishes, direction_field, given_directions
from .guidance.guides import Guide
from .patterns import Pattern, PatternWishes, quad_pattern, stripe_pattern

__all__ = [
    "DirectionField",
    "DirectionWishes",
    "Guide",
    "Line",
    "Pattern",
    "PatternWishes",
    "Row",
    "boundary_line",
    "direction_field",
    "given_directions",
    "line_of_edges",
    "quad_pattern",
    "stripe_pattern",
]
