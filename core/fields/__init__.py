# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields that artists ask for, each posed as a synchronization problem."""

from .directions import DirectionField, DirectionWishes, direction_field, given_directions
from .guidance import Guide
from .lines import Line, boundary_line, line_of_edges
from .rows import Row
from .stripes import StripePattern, stripe_pattern

__all__ = [
    "DirectionField",
    "DirectionWishes",
    "Guide",
    "Line",
    "Row",
    "StripePattern",
    "boundary_line",
    "direction_field",
    "given_directions",
    "line_of_edges",
    "stripe_pattern",
]
