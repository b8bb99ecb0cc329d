# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings for all files, in Preferences > Add-ons."""

from pathlib import Path

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from ...core.memory import machine_bytes
from ..blender.registration import register_all

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

    panel: EnumProperty(
        name="Panel",
        description="What the sidebar shows",
        items=(
            ("SIMPLE", "Simple", "Size, direction, branching, look and one button"),
            ("ADVANCED", "Advanced", "All settings, constraints, layers, vortices, bake and animation"),
        ),
    )

    manual: StringProperty(
        name="Manual",
        description="Folder or web address of the manual, which Online Manual in the menu of a button opens",
    )

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        row = column.row()
        row.prop(self, "memory_limit")
        if not self.memory_limit:
            row.label(text=f"{memory_limit() / 2**20:,.0f} MB", translate=False)
        column.prop(self, "manual")


def preferences():
    """The extension's; None where the package was registered without Blender's preferences, as by the command line."""
    addon = bpy.context.preferences.addons.get(_PACKAGE)
    return addon.preferences if addon is not None else None


def manual_address():
    """Address of the folder with the manual's pages, with a slash at its end; "" where none is given."""
    given = preferences().manual.strip() if preferences() is not None else ""
    if given and "://" not in given:
        given = Path(given).expanduser().absolute().as_uri()
    return given.rstrip("/") + "/" if given else ""


def is_simple():
    """Whether the sidebar shows the simple panel."""
    return preferences() is not None and preferences().panel == "SIMPLE"


def memory_limit():
    """Bytes that a solve may take."""
    megabytes = preferences().memory_limit if preferences() is not None else 0
    return megabytes * 2**20 or int(_MEMORY_SHARE * machine_bytes())


register, unregister = register_all((SynchPreferences,))
