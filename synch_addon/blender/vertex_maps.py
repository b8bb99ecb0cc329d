# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers on the vertices that change spacing and angle from place to place."""

import numpy as np

from ...core.errors import SettingError, name_elements
from . import attributes, groups


def read_factors(obj, given, name, factor):
    """(n,) factors on the spacing: a float attribute as it is, or a vertex group by its weights.

    Raises SettingError when there is neither, or a value of the attribute is not positive and finite.

    Parameters
    ----------
    name : of the attribute or vertex group; the attribute goes first
    factor : of a vertex with weight 1 in the group; 1 at weight 0, and geometric in between
    """
    values = attributes.read_numbers(obj, name, given)
    if groups.is_group(obj, name):
        return factor**values
    values[given.mesh.loose_vertices] = 1
    _refuse(obj, given, name, ~(np.isfinite(values) & (values > 0)), "a positive factor on the spacing")
    return values


def read_turns(obj, given, name, turn):
    """(n,) radians by which directions are turned: a float attribute as it is, or a vertex group by its weights.

    Raises SettingError when there is neither, or a value is not finite.

    Parameters
    ----------
    obj, given, name : as of :func:`read_factors`
    turn : radians at a vertex with weight 1 in the group
    """
    values = attributes.read_numbers(obj, name, given)
    if groups.is_group(obj, name):
        return turn * values
    _refuse(obj, given, name, ~np.isfinite(values), "a finite angle in radians")
    return values


def _refuse(obj, given, name, bad, wanted):
    vertices = np.unique(given.source[bad])
    if len(vertices):
        raise SettingError(
            f"the attribute {name!r} of {obj.name} is of no use at {name_elements('vertex', vertices)}: give {wanted}"
        )
