# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields that artists ask for, each posed as a synchronization problem."""

from .directions import DirectionField, DirectionWishes, direction_field, given_directions
from .stripes import StripePattern, stripe_pattern

__all__ = [
    "DirectionField",
    "DirectionWishes",
    "StripePattern",
    "direction_field",
    "given_directions",
    "stripe_pattern",
]
