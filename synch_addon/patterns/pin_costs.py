# SPDX-License-Identifier: GPL-3.0-or-later
"""What pins cost, before a pattern is solved: how much more directions bend with them than without.

On larger meshes first fields tell that, which are quick and no more than a hint.
"""

from dataclasses import replace

from ...core.settings.pins import parse_pins
from ...core.solution import FIRST
from ..blender.pattern_surface import surface_of
from ..blender.translations import translate, translate_count
from ..jobs.kept_results import read_result_or_empty
from ..jobs.lru_cache import LruCache
from ..reading.surface import gather, settings_for
from ..settings.fields import stored_settings

# Shares of the last objects, by their pins.
_told = LruCache(8)
# Vertices up to which directions are solved for as they will be: in a third of a second there.
_SOLVED = 3000
# A bending for each vertex that is as good as none.
_FLAT = 1e-9


class PinCosts:
    """What pins of an object cost in directions, which are those of what was solved last.

    Raises SynchError as of a solve.
    """

    def __init__(self, obj):
        last = read_result_or_empty(obj.synch.result).get("command")
        command = last if last in ("quads", "quad_mesh") else "directions"
        request = gather(command, surface_of(obj), replace(settings_for(command, obj, stored_settings(obj)), pins=""))
        if request.given.mesh.vertex_count > _SOLVED:
            request = replace(request, options=replace(request.options, method=FIRST))
        self._request = request
        self._free = self._request.directed().bending

    def tell(self, obj):
        """How much more directions bend with the object's pins than without, as a share.

        None where free ones do not bend, or are given.
        """
        share, pins = None, parse_pins(obj.synch.pins)
        if self._free > _FLAT * self._request.given.mesh.vertex_count and self._request.source.directions is None:
            share = self._request.with_pins(pins).directed().bending / self._free - 1
        _told.put(obj.session_uid, (obj.synch.pins, share))
        return share


def cost_line(obj):
    """What :meth:`PinCosts.tell` last told of an object, as a line of the interface, where its pins are still the same;
    else ""."""
    pins, share = _told.get(obj.session_uid) or ("", None)
    if share is None or pins != obj.synch.pins:
        return ""
    return translate(
        "{pins}: about {more:+.0%} bending", pins=translate_count(len(parse_pins(pins)), "pin"), more=share
    )
