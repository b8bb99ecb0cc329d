# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of an object's settings, in the header of the sidebar tab: a few of our own, and the user's."""

from functools import partial
from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from ..blender.registration import Registration, class_steps
from ..settings.fields import STORED_NAMES

FOLDER = "synch_fields"
# Where Blender finds our own: in a folder that it wants to be called presets.
_SHIPPED = Path(__file__).parent / "shipped"


class SYNCH_PT_presets(PresetPanel, bpy.types.Panel):
    """Settings of directions and patterns, kept under a name"""

    bl_label = "Synch Fields Presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "synch.add_preset"


class SYNCH_OT_add_preset(AddPresetBase, bpy.types.Operator):
    """Save the active object's settings under a name, or remove saved ones"""

    bl_idname = "synch.add_preset"
    bl_label = "Add Synch Fields Preset"
    preset_menu = "SYNCH_PT_presets"
    preset_subdir = FOLDER
    preset_defines = ["synch = bpy.context.active_object.synch"]
    preset_values = [f"synch.{name}" for name in ("guidance", "guide", "guides", *STORED_NAMES)]


_registration = Registration(
    (partial(bpy.utils.register_preset_path, str(_SHIPPED)), partial(bpy.utils.unregister_preset_path, str(_SHIPPED))),
    *class_steps(SYNCH_PT_presets, SYNCH_OT_add_preset),
)
register, unregister = _registration.register, _registration.unregister
