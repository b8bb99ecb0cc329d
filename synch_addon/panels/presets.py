# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel of looks: a picture of the one that is shown, a list of pictures that a click applies, and a button for the
library of assets."""

import bpy
import bpy.utils.previews
from bpy.props import EnumProperty

from ..blender.phases import pattern_kind
from ..looks import assets
from ..looks.presets import PLAIN, PRESETS, shown_preset
from ..settings.preferences import is_simple
from ..solids.links import solid_of
from .look import draw_look
from .sidebar import SettingsPanel

# Items without icons, for what is shown as text.
PRESET = [(name, preset.label, preset.description) for name, preset in PRESETS.items()]
_LOOKS = [(PLAIN, "Plain", "Two colours, as every pattern has at first"), *PRESET]
# Custom property of a scene: the number of the look that was chosen before there was a pattern.
_CHOSEN = "synch_chosen_look"


class SYNCH_PT_material_presets(SettingsPanel, bpy.types.Panel):
    """Materials in one click"""

    bl_label = "Look"
    bl_parent_id = "SYNCH_PT_result"
    bl_order = 0
    in_simple = True

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        obj = context.active_object
        has_none = obj.synch_simple.kind == "quad_mesh" or solid_of(obj) != obj
        return pattern_kind(obj) is not None or not has_none

    def draw_body(self, context):
        layout = self.layout
        layout.template_icon_view(context.scene, "synch_preset", show_labels=True, scale=5.0, scale_popup=5.0)
        draw_look(layout, context.active_object)
        if is_simple():
            return
        if pattern_kind(context.active_object) == "stripes":
            layout.operator("synch.number_stripes", icon="LINENUMBERS_ON")
        if not assets.is_registered(context.preferences):
            layout.operator("synch.asset_library", icon="ASSET_MANAGER")


def _plain_kind():
    """The kind of pattern that the plain look of the active object shows, or will show."""
    obj = bpy.context.active_object
    if obj is None or obj.type != "MESH":
        return "stripes"
    return pattern_kind(obj) or ("quads" if obj.synch_simple.kind == "quads" else "stripes")


def _get_look(scene):
    shown = shown_preset(bpy.context.active_object)
    names = [name for name, *_ in _LOOKS]
    return min(scene.get(_CHOSEN, 0), len(names) - 1) if shown is None else names.index(shown)


def _set_look(scene, number):
    """A click on a look's picture in the window applies it."""
    scene[_CHOSEN] = number
    name = _LOOKS[number][0]
    operator, given = (bpy.ops.synch.plain_look, {}) if name == PLAIN else (bpy.ops.synch.preset, {"preset": name})
    if not bpy.app.background and operator.poll():
        operator("INVOKE_DEFAULT", **given)


class _Thumbnails:
    """The choice of a preset in every scene, with thumbnails."""

    def __init__(self):
        self._icons = None

    def register(self):
        """Load the thumbnails and register choice and panel."""
        self._icons = bpy.utils.previews.new()
        # Blender keeps no reference to the texts of items that a function returns.
        items = {kind: [self._item(kind, number) for number in range(len(_LOOKS))] for kind in ("stripes", "quads")}
        bpy.types.Scene.synch_preset = EnumProperty(
            name="Look",
            description="What the object looks like: a click on a picture applies it",
            items=lambda _owner, _context: items[_plain_kind()],
            get=_get_look,
            set=_set_look,
        )
        bpy.utils.register_class(SYNCH_PT_material_presets)

    def _item(self, kind, number):
        """A look in the list of an object with a kind of pattern, of which the plain look is a picture."""
        name, label, tip = _LOOKS[number]
        file = kind if name == PLAIN else name
        icon = self._icons.get(file) or self._icons.load(file, str(assets.THUMBNAILS / f"{file}.png"), "IMAGE")
        return name, label, tip, icon.icon_id, number

    def unregister(self):
        """Take all of it out again."""
        bpy.utils.unregister_class(SYNCH_PT_material_presets)
        del bpy.types.Scene.synch_preset
        bpy.utils.previews.remove(self._icons)


thumbnails = _Thumbnails()
register, unregister = thumbnails.register, thumbnails.unregister
