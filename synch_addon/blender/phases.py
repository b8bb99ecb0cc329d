# SPDX-License-Identifier: GPL-3.0-or-later
"""The pattern that an object shows, as the shader reads it."""

from dataclasses import replace

import numpy as np

from ...core.interpolate import FacePhases
from . import attributes, schema
from .pattern_surface import surface_of


def pattern_kind(obj):
    """ "stripes" or "quads", the pattern that an object's attributes hold, or None."""
    data = surface_of(obj).data
    for kind, phases in schema.PHASES.items():
        found = [(phase.layout, data.attributes.get(phase.name)) for phase, *_ in phases]
        if all(there is not None and (there.domain, there.data_type) == layout for layout, there in found):
            return kind
    return None


def read_phases(obj, kind):
    """The :class:`FacePhases` of each phase, as the shader reads them."""
    obj = surface_of(obj)

    def read(attribute):
        values = attributes.read(obj, attribute)
        if values is None:
            width = schema.TYPES[attribute.data_type][1]
            values = np.zeros((obj.data.attributes.domain_size(attribute.domain), width)[: 1 + (width > 1)])
        return values.astype(float)

    place, closings = read(schema.BARYCENTRIC), read(schema.CLOSING)
    result = []
    for number, own in enumerate(schema.PHASES[kind]):
        phase = FacePhases(
            corner_phase=read(own.phase),
            corner_place=place,
            index=read(own.index).astype(int),
            index_2=read(own.index_2).astype(int),
            disclination=read(own.disclination),
            closing=closings[:, number],
            unfit=np.empty(0, int),
        )
        result.append(phase if kind == "quads" else replace(phase, closing=-phase.disclination[:, 0]))
    return tuple(result)


def is_signed(obj, polygons, phase):
    """Whether the phase of stripes has the same sign in all faces: their corners have the phase of their vertex."""
    at_vertices = attributes.read(surface_of(obj), schema.PHASES["stripes"][0].vertex_phase)
    if at_vertices is None or phase.disclination.any():
        return False
    off = np.abs(np.exp(1j * (phase.corner_phase - at_vertices[polygons.corner_vertices])) - 1)
    return bool(off[~phase.corner_place.any(axis=1)].max(initial=0) < 1e-2)
