# SPDX-License-Identifier: GPL-3.0-or-later
"""What is set once for all files, in Preferences > Add-ons."""

import bpy
from bpy.props import IntProperty

from ...core.memory import machine_bytes

# Share of the machine's memory that a solve may take where nothing is set.
_MEMORY_SHARE = 0.8
_PACKAGE = __package__.removesuffix(".synch_addon.settings")


class SynchPreferences(bpy.types.AddonPreferences):
    """Preferences of the extension"""

    bl_idname = _PACKAGE

    memory_limit: IntProperty(
        name="Memory Limit (MB)",
        description="Memory that a solve may take before it is stopped; 0 stands for four fifths of the machine's",
        default=0,
        min=0,
    )

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        column.prop(self, "memory_limit")


def memory_limit():
    """Bytes that a solve may take."""
    addon = bpy.context.preferences.addons.get(_PACKAGE)
    megabytes = addon.preferences.memory_limit if addon is not None and addon.preferences is not None else 0
    return megabytes * 2**20 or int(_MEMORY_SHARE * machine_bytes())


register, unregister = bpy.utils.register_classes_factory((SynchPreferences,))
