# SPDX-License-Identifier: GPL-3.0-or-later
"""How the object of a solid and the objects that show its layers know one another: by custom properties, which undo
restores."""

import bpy

from ..blender.objects import no_object

# On what is made, the object whose solid it shows; on that one, what was made by what it shows.
SOLID = "synch_solid"
MADE = {
    "layers": "synch_layers_object",
    "curves": "synch_curves_object",
    "surface": "synch_surface_object",
    "volume": "synch_volume_object",
}


def solid_of(obj):
    """The object whose layers an object shows, or the object itself."""
    source = obj.get(SOLID) if no_object(obj) is None else None
    return source if isinstance(source, bpy.types.Object) and source.users_collection else obj


def made_of(obj, kind):
    """The object of a kind that an earlier run has made for an object; None if it was removed."""
    made = obj.get(MADE[kind]) if obj is not None else None
    is_there = isinstance(made, bpy.types.Object) and made.users_collection and made.get(SOLID) == obj
    return made if is_there else None
