# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers that may be automatic, as panels show them: a field with the number that counts, and the button "Auto".

Turned off, the button leaves the number that the field showed.
"""

import math
from collections.abc import Callable
from typing import Any

from bpy.props import BoolProperty


def automatic_properties(
    name: str,
    make: Callable,
    read: Callable[[Any], float | None],
    write: Callable[[Any, float | None], None],
    expected: Callable[[Any], float | None],
) -> type:
    """A class to mix into a property group, with the property of the field and that of the button, ``name``_auto.

    Parameters
    ----------
    name : of the field's property
    make : makes the field's property, given its ``get`` and ``set``
    read, write : get and set the number that a property group stores, None for an automatic one
    expected : the automatic number of a group, None where it is not known
    """

    def shown(group):
        stored = read(group)
        return (expected(group) or 0) if stored is None else stored

    def change(group, number):
        before = shown(group)
        is_same = number == before if isinstance(number, int) else math.isclose(number, before, rel_tol=1e-5)
        if not is_same:  # Enter in a field sets it again
            write(group, number)

    def turn(group, is_automatic):
        number = None if is_automatic else shown(group)
        if is_automatic or number:
            write(group, number)

    button = BoolProperty(
        name="Automatic",
        description="Choose the number automatically; turned off, it stays as it is",
        get=lambda group: read(group) is None,
        set=turn,
    )
    field = make(get=shown, set=change)
    return type("Automatic", (), {"__annotations__": {name: field, f"{name}_auto": button}})
