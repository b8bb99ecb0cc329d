# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves that guide: how long they may be for places along them to be looked at one by one."""

import math

from ..errors import SettingError

# A microsecond to some ten and some hundred bytes each.
MOST_PLACES = 1_000_000


def check_length(name, length, step):
    """Refuse curves along which there would be more than ``MOST_PLACES`` places.

    Parameters
    ----------
    name : what errors call them
    length : of all, scene units
    step : from one place to the next, scene units

    Raises
    ------
    SettingError
        for curves that are too long, or of no finite length
    """
    if not math.isfinite(length):
        raise SettingError(f"{name} has points without a finite place: set their coordinates, or delete them")
    if length > MOST_PLACES * step:
        raise SettingError(
            f"{name} has a length of {length:.3g}, and no more than {MOST_PLACES * step:.3g} can be followed along "
            "this mesh: delete the points that are far away from it"
        )
