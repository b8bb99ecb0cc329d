# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers of an object's stripes and coordinates along them, written for shaders and geometry nodes."""

import bpy
import numpy as np

from ...core.errors import SettingError, SynchError
from ...core.extract.lines.isolines import isolines
from ...core.extract.lines.stripe_numbers import StripeNumbers, slot_numbers, stripe_table
from ..blender import attributes, meshes, schema
from ..blender.pattern_surface import surface_of
from ..blender.phases import pattern_kind, read_phases
from ..blender.transaction import whole_or_nothing
from ..nodes.stripe_profiles import ALONG, NUMBER
from .read_back import shown_pattern

# Between the points of the lines along which coordinates are measured, in spacings.
_STEP = 0.1


def number_stripes(obj: bpy.types.Object) -> int:
    """Number the stripes of an object and write coordinates along them, for shaders and relief.

    What is written follows every later solve and variation of the object. Raises SynchError, with nothing written.
    ``obj``: bpy.types.Object with stripes. Returns int, how many stripes have a line: number k is that of spline k - 1
    of :func:`api.isolines`; greater numbers are those of stripes whose middle lies beyond the boundary.
    """
    meshes.refuse(obj)
    with meshes.object_mode(obj), whole_or_nothing():
        if pattern_kind(obj) != "stripes":
            raise SynchError("stripes are numbered: solve stripes first")
        return _write(obj, *shown_pattern(obj))


def numbers_of(obj, phase, polygons):
    """The :class:`StripeNumbers` of an object's stripes, numbered or not; errors as :func:`shown_pattern`."""
    written = attributes.read(surface_of(obj), schema.NUMBER)
    slots = (
        slot_numbers(*_numbering_phases(obj, *shown_pattern(obj))) if written is None else np.abs(written).astype(int)
    )
    return StripeNumbers(phase, polygons, slots)


def _numbering_phases(obj, request, pattern):
    """The phase, polygons and lines that stripes are numbered by."""
    (phase,) = read_phases(obj, "stripes")
    return phase, request.given.polygons, isolines(pattern.edge_phases).resampled(_STEP * request.spacing)


def _write(obj, request, pattern):
    phase, polygons, lines = _numbering_phases(obj, request, pattern)
    if len(lines.sizes) == 0:
        raise SettingError(f"no stripe has its middle on {obj.name}: reduce the spacing and solve again")
    table = stripe_table(phase, polygons, lines, request.spacing)
    surface = surface_of(obj)
    attributes.write(surface, schema.NUMBER, table.numbers)
    attributes.write(surface, schema.ALONG, table.along)
    meshes.update(surface)
    return len(lines.sizes)


def renew_shown(obj):
    """Number the stripes that an object shows again if they were numbered."""
    if NUMBER in surface_of(obj).data.attributes:
        with meshes.object_mode(obj), whole_or_nothing():
            renew_numbers(obj, *shown_pattern(obj))


def renew_numbers(obj, request, pattern):
    """Number the stripes of an object again if they were numbered; remove the numbers if no stripe can be numbered."""
    if NUMBER not in surface_of(obj).data.attributes:
        return
    if pattern is None or pattern_kind(obj) != "stripes":
        remove_numbers(obj)
        return
    try:
        _write(obj, request, pattern)
    except SynchError:
        remove_numbers(obj)


def remove_numbers(obj):
    """Remove the numbers of an object's stripes."""
    for name in (NUMBER, ALONG):
        attributes.remove_attribute(surface_of(obj), name)
