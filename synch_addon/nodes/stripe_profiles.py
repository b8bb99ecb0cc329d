# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a point is in its stripe, and how high the stripe is there: shared by shaders and geometry nodes.

The phase says how far a point is from the middle of its stripe, on a side whose name may change from face to face.
Where stripes were numbered (`core/extract/lines/stripe_numbers.py`), `synch_number` and `synch_along` say which stripe
it is, which side, and how far along it the point is.
"""

import math
from typing import NamedTuple

from ...core.extract.lines.stripe_numbers import SLOTS
from ..blender import schema
from .canvas import Expression

NUMBER, ALONG = schema.NUMBER.name, schema.ALONG.name
# In the order of the numbers that choose them.
PROFILES = ("sine", "square", "triangle", "rounded", "thread")
PROFILE_TIP = ", ".join(f"{number}: {name}" for number, name in enumerate(PROFILES))
THREAD_TIP = "Grooves of the profile thread in the length of one spacing, once stripes are numbered"

# Part of the half width over which the edge of a square one rises.
_EDGE = 0.25
# How deep the grooves between the strands of a thread are, as a part of its height.
_GROOVE = 0.38
_TINY = 1e-6


class Place(NamedTuple):
    """A point in its stripe.

    Attributes
    ----------
    away : periods to the middle of the stripe, from 0 to 1/2
    across : the same with a side, positive on the left of the direction along; not negative where there is no number
    along : periods along the stripe
    index : number of the stripe, 0 where stripes are not numbered
    """

    away: Expression
    across: Expression
    along: Expression
    index: Expression


def place_in_stripe(canvas, phase):
    """The :class:`Place` of a point with this phase."""
    assert SLOTS == 3, "a vector attribute has three"
    numbers = canvas.separate(*canvas.attribute(NUMBER, "Vector"))
    coordinates = canvas.separate(*canvas.attribute(ALONG, "Vector"))
    periods = (phase / (2.0 * math.pi)).named("periods")
    period = canvas.math("ROUND", periods).named("period of the stripe")
    slot = canvas.math("FLOORED_MODULO", period, float(SLOTS)).named("slot")
    is_first, is_second = (slot < 0.5).named("slot 0?"), (slot < 1.5).named("slot 1?")
    number, along = (is_first.choose(x, is_second.choose(y, z)) for x, y, z in (numbers, coordinates))
    offset = (periods - period).named("from the middle")
    away = abs(offset).named("away")
    index = abs(number).named("index")
    side = canvas.math("SIGN", number) * offset
    return Place(away, (index < 0.5).choose(away, side).named("across"), along.named("along"), index)


def profile_heights(place, width, strands):
    """Heights from 0 to 1 of all :data:`PROFILES`, for stripes that are a part `width` of a period; 0 outside."""
    half = (width * 0.5).maximum(_TINY).named("half width")
    share = ((half - place.away) / half).clamped().named("from edge to middle")
    sine = (0.5 - 0.5 * (share * math.pi).cosine()).named("sine")
    edge = (share / _EDGE).clamped()
    square = (edge * edge * (3.0 - 2.0 * edge)).named("square")
    rounded = (share * (2.0 - share)).root().named("rounded")
    around = ((place.across / half).maximum(-1.0).minimum(1.0)).arcsine().named("around the thread")
    ridge = abs((place.along * strands * math.pi + around).sine()).named("ridge of a strand")
    depth = (place.index > 0.5) * _GROOVE
    thread = (rounded * (1.0 - depth * (1.0 - ridge))).named("thread")
    return sine, square, share, rounded, thread


def choose_profile(profile, values, names=PROFILES):
    """The value with the number `profile`."""
    result = values[-1]
    for number in reversed(range(len(values) - 1)):
        result = (profile < number + 0.5).named(f"{names[number]}?").choose(values[number], result)
    return result.named("height")
