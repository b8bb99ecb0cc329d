# SPDX-License-Identifier: GPL-3.0-or-later
"""The slider of variations: a property that shows what it is set to. Variations that are not ready are searched for
beside the window, once the slider rests."""

import bpy
from bpy.props import IntProperty

from ...core.errors import SynchError
from .. import api
from ..blender.objects import ObjectLink
from ..blender.registration import Registration, register_all
from ..blender.timers import Timer
from ..blender.translations import operator_error
from ..jobs.queue import queue
from ..patterns import memory

# Seconds without a change after which the slider rests, and between two looks at what keeps a search waiting.
_REST = 0.4


def _show_variation(slider, context):
    """Show the variation that the slider is set to; where that cannot be, it goes back and a box says why."""
    obj = slider.id_data
    if not memory.holds(obj):
        return
    number, solved = slider.variation, memory.solve_of(obj)
    _search.forget()
    try:
        if number < len(solved.shown.solution.variations) or not solved.varies or bpy.app.background:
            api.vary(obj, number)
        else:
            _go_back(obj)
            _search.wish(obj, number)
    except SynchError as error:
        _go_back(obj)
        _say(context.window, str(error))


def _go_back(obj):
    """Set the slider to what the object shows."""
    memory.show_line(obj, obj.synch.result, memory.solve_of(obj).number)


def _say(window, line):
    """Say in a box why a variation cannot be shown."""
    if window is not None and not bpy.app.background:
        with bpy.context.temp_override(window=window):
            bpy.context.window_manager.popup_menu(
                lambda menu, _: menu.layout.label(text=line, translate=False), icon="ERROR"
            )


class _Search:
    """The variation that the slider was set to last, if it has to be searched for."""

    def __init__(self):
        self._link = self._number = None
        self._timer = Timer(self._begin, first=_REST)

    def wish(self, obj, number):
        """Search for it, unless the slider is moved on."""
        self.forget()
        self._link, self._number = ObjectLink.to(obj), number
        self._timer.start()

    def forget(self):
        """Search for nothing."""
        self._timer.stop()
        self._link = None

    def _begin(self):
        if self._link is None or self._link.present is None:
            return None
        obj, window = self._link.present, bpy.context.window_manager.windows[0]
        if queue.holds(obj):
            return _REST
        with bpy.context.temp_override(window=window):
            if bpy.context.active_object == obj:
                try:
                    bpy.ops.synch.draw_variation("INVOKE_DEFAULT", number=self._number)
                except RuntimeError as error:
                    _say(window, operator_error(error))
        return None


_search = _Search()


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


_properties = register_all((SynchShown,), (bpy.types.Object, "synch_shown", SynchShown))
_registration = Registration(_properties, (_search.forget, _search.forget))
register, unregister = _registration.register, _registration.unregister
