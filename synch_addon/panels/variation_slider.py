# SPDX-License-Identifier: GPL-3.0-or-later
"""The slider of variations: a property that shows what it is set to."""

import bpy
from bpy.props import IntProperty

from ...core.errors import SynchError
from .. import api
from ..blender.registration import register_all
from ..patterns import memory


def _show_variation(slider, context):
    """Show the variation that the slider is set to; where that cannot be, it goes back and a box says why."""
    obj = slider.id_data
    if not memory.holds(obj):
        return
    try:
        api.vary(obj, slider.variation)
    except SynchError as error:
        line = str(error)
        memory.show_line(obj, obj.synch.result, memory.solve_of(obj).number)
        if context.window is not None and not bpy.app.background:
            context.window_manager.popup_menu(
                lambda menu, _: menu.layout.label(text=line, translate=False), icon="ERROR"
            )


class SynchShown(bpy.types.PropertyGroup):
    """What of its last solve an object shows."""

    variation: IntProperty(
        name="Variation",
        description="Other configurations of defects from the last solve: 0 is the best one and the next numbers are "
        "other good ones; high numbers need a new search",
        min=0,
        soft_max=20,
        update=_show_variation,
    )


register, unregister = register_all((SynchShown,), (bpy.types.Object, "synch_shown", SynchShown))
