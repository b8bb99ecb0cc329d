# SPDX-License-Identifier: GPL-3.0-or-later
"""The pattern that an object's attributes hold, as the shader reads it."""

from dataclasses import replace

import numpy as np

from ...core.interpolate import FacePhases
from . import attributes

_SUFFIXES = {"stripes": ("",), "quads": ("_x", "_y")}


def pattern_kind(obj):
    """ "stripes" or "quads", the pattern that an object's attributes hold, or None."""
    for kind, suffixes in _SUFFIXES.items():
        found = [obj.data.attributes.get(f"synch_phase{suffix}") for suffix in suffixes]
        if all(phase is not None and (phase.domain, phase.data_type) == ("CORNER", "FLOAT") for phase in found):
            return kind
    return None


def read_phases(obj, kind):
    """The :class:`FacePhases` of each phase, as the shader reads them."""
    faces, corners = len(obj.data.polygons), len(obj.data.loops)

    def read(name, domain, *shape):
        values = attributes.read_values(obj, name, domain)
        return np.zeros(shape) if values is None else values.astype(float)

    place = read("synch_barycentric", "CORNER", corners, 3)
    closings = read("synch_closing", "FACE", faces, 2)
    result = []
    for number, suffix in enumerate(_SUFFIXES[kind]):
        phase = FacePhases(
            corner_phase=read(f"synch_phase{suffix}", "CORNER", corners),
            corner_place=place,
            index=read(f"synch_index{suffix}", "FACE", faces).astype(int),
            index_2=read(f"synch_index{suffix}_2", "FACE", faces).astype(int),
            disclination=read(f"synch_disclination{suffix}", "FACE", faces, 4),
            closing=closings[:, number],
            unfit=np.empty(0, int),
        )
        result.append(phase if kind == "quads" else replace(phase, closing=-phase.disclination[:, 0]))
    return tuple(result)


def is_signed(obj, polygons, phase):
    """Whether the phase of stripes has the same sign in all faces: their corners have the phase of their vertex."""
    at_vertices = attributes.read_values(obj, "synch_vertex_phase", "POINT")
    if at_vertices is None or phase.disclination.any():
        return False
    off = np.abs(np.exp(1j * (phase.corner_phase - at_vertices[polygons.corner_vertices])) - 1)
    return bool(off[~phase.corner_place.any(axis=1)].max(initial=0) < 1e-2)
