# SPDX-License-Identifier: GPL-3.0-or-later
"""The favourites of an object as Blender properties, which it keeps in the file."""

import bpy
from bpy.props import IntProperty, StringProperty

from ..blender.registration import register_all


def _make_name_unique(favourite, _context):
    """Give a favourite another name if its own is empty or taken."""
    taken = {other.name for other in favourite.id_data.synch.favourites if other != favourite}
    wanted = favourite.name or f"Variation {favourite.variation}"
    number, name = 1, wanted
    while name in taken:
        number += 1
        name = f"{wanted} ({number})"
    if favourite.name != name:
        favourite.name = name


class SynchFavourite(bpy.types.PropertyGroup):
    """A configuration of defects that was kept; its phases and directions are attributes of the mesh."""

    name: StringProperty(name="Name", description="What the favourite is called", update=_make_name_unique)
    number: IntProperty(name="Number", description="The one in the names of its attributes", min=1)
    variation: IntProperty(name="Variation", description="What the slider said", min=0)
    result: StringProperty(name="Result", description="What the panel shows of it, as JSON")


register, unregister = register_all((SynchFavourite,))
