# SPDX-License-Identifier: GPL-3.0-or-later
"""The pattern of an object read back from its attributes, and the numbers of its stripes or quads over a UV map."""

from dataclasses import replace

import bpy
import numpy as np
from scipy.ndimage import distance_transform_edt

from ..core.extract.cells import cells
from ..core.interpolate import FacePhases
from . import scene_io
from .bake_shaders import glowing_attributes

# The largest number of a 16-bit PNG.
MOST = 65535

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
        values = scene_io.read_values(obj, name, domain)
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
    at_vertices = scene_io.read_values(obj, "synch_vertex_phase", "POINT")
    if at_vertices is None or phase.disclination.any():
        return False
    off = np.abs(np.exp(1j * (phase.corner_phase - at_vertices[polygons.corner_vertices])) - 1)
    return bool(off[~phase.corner_place.any(axis=1)].max(initial=0) < 1e-2)


def numbers_at(stage, polygons, coordinates, phases, size, margin):
    """(size, size) numbers of stripes or quads at the middle of each pixel, 0 where there is no face; and their count.

    The faces are laid out flat in a stage of their own, as their corners' UV coordinates tell.
    """
    corners = polygons.triangle_corners
    data = bpy.data.meshes.new("Synch Bake")
    flat = np.column_stack([coordinates[corners.ravel()], np.zeros(corners.size)])
    data.from_pydata(flat.tolist(), [], np.arange(corners.size).reshape(-1, 3).tolist())
    data.uv_layers.new(name="Synch Bake").uv.foreach_set("vector", flat[:, :2].astype(np.float32).ravel())
    stage.obj.modifiers.clear()
    stage.obj.data = data
    data.materials.append(None)
    scene_io.write_attribute(stage.obj, "triangle", "FACE", "INT", 1 + np.arange(len(corners)))
    for corner in range(2):
        weights = np.tile(np.eye(3)[corner], len(corners))
        scene_io.write_attribute(stage.obj, f"weight_{corner}", "CORNER", "FLOAT", weights)
    material = glowing_attributes("triangle", "weight_0", "weight_1")
    seen = stage.bake("EMIT", [material], size, samples=1, margin=0)
    inside = seen[:, :, 0] > 0.5
    triangles, weights = np.rint(seen[inside, 0]).astype(int) - 1, seen[inside, 1:3].astype(float)
    weights = np.column_stack([weights, 1 - weights.sum(axis=1)])
    found = cells(phases, polygons)
    numbers = np.zeros((size, size), int)
    numbers[inside] = found.at(triangles, weights)
    return _extended(numbers, inside, margin), found.count


def _extended(numbers, inside, margin):
    """Numbers where there are none yet: the nearest one, inside and up to a margin beside it."""
    if not numbers.any():
        return numbers
    distance, nearest = distance_transform_edt(numbers == 0, return_indices=True)
    return np.where(inside | (distance <= margin), numbers[tuple(nearest)], 0)
