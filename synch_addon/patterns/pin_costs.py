# SPDX-License-Identifier: GPL-3.0-or-later
"""Cost of pins before a pattern is solved: how much more directions bend with them than without.

On larger meshes it is that of first fields, which is quick and only an estimate.
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

# Costs last computed, with the pins that they are for.
_costs = LruCache(8)
# Vertices up to which directions are solved by the method that is set: a third of a second.
_SOLVED = 3000
# Bending for each vertex that counts as none.
_FLAT = 1e-9


class PinCosts:
    """The cost of an object's pins in directions of the kind that was solved last; SynchError as for a solve."""

    def __init__(self, obj):
        last = read_result_or_empty(obj.synch.result).get("command")
        command = last if last in ("quads", "quad_mesh") else "directions"
        request = gather(command, surface_of(obj), replace(settings_for(command, obj, stored_settings(obj)), pins=""))
        if request.given.mesh.vertex_count > _SOLVED:
            request = replace(request, options=replace(request.options, method=FIRST))
        self._request = request
        self._free = self._request.directed().bending

    def compute(self, obj):
        """How much more directions bend with the object's pins than without, as a share.

        None if they do not bend without pins, or are given.
        """
        share, pins = None, parse_pins(obj.synch.pins)
        if self._free > _FLAT * self._request.given.mesh.vertex_count and self._request.source.directions is None:
            share = self._request.with_pins(pins).directed().bending / self._free - 1
        _costs.put(obj.session_uid, (obj.synch.pins, share))
        return share


def cost_line(obj):
    """The cost that :meth:`PinCosts.compute` last found for an object, as a line; "" if its pins have changed since."""
    pins, share = _costs.get(obj.session_uid) or ("", None)
    if share is None or pins != obj.synch.pins:
        return ""
    return translate(
        "{pins}: about {more:+.0%} bending", pins=translate_count(len(parse_pins(pins)), "pin"), more=share
    )
