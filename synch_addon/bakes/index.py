# SPDX-License-Identifier: GPL-3.0-or-later
"""The pattern of an object read back from its attributes, and the numbers of its stripes or quads over a UV map."""

import numpy as np
from scipy.ndimage import distance_transform_edt

from ..blender import attributes
from ..blender.new_geometry import new_mesh
from .shaders import glowing_attributes

# The largest number of a 16-bit PNG.
MOST = 65535


def numbers_at(stage, polygons, coordinates, numbering, size, margin):
    """(size, size) numbers of stripes or quads at the middle of each pixel, 0 where there is no face.

    The faces are laid out flat in a stage of their own, as their corners' UV coordinates tell.
    """
    corners = polygons.triangle_corners
    flat = np.column_stack([coordinates[corners.ravel()], np.zeros(corners.size)])
    data = new_mesh("Synch Bake", flat, np.arange(corners.size).reshape(-1, 3))
    data.uv_layers.new(name="Synch Bake").uv.foreach_set("vector", flat[:, :2].astype(np.float32).ravel())
    stage.obj.modifiers.clear()
    stage.obj.data = data
    data.materials.append(None)
    attributes.write_attribute(stage.obj, "triangle", "FACE", "INT", 1 + np.arange(len(corners)))
    for corner in range(2):
        weights = np.tile(np.eye(3)[corner], len(corners))
        attributes.write_attribute(stage.obj, f"weight_{corner}", "CORNER", "FLOAT", weights)
    material = glowing_attributes("triangle", "weight_0", "weight_1")
    seen = stage.bake("EMIT", [material], size, samples=1, margin=0)
    inside = seen[:, :, 0] > 0.5
    triangles, weights = np.rint(seen[inside, 0]).astype(int) - 1, seen[inside, 1:3].astype(float)
    weights = np.column_stack([weights, 1 - weights.sum(axis=1)])
    numbers = np.zeros((size, size), int)
    numbers[inside] = numbering.at(triangles, weights)
    return _extend_numbers(numbers, inside, margin)


def _extend_numbers(numbers, inside, margin):
    """Numbers where there are none yet: the nearest one, inside and up to a margin beside it."""
    if not numbers.any():
        return numbers
    distance, nearest = distance_transform_edt(numbers == 0, return_indices=True)
    return np.where(inside | (distance <= margin), numbers[tuple(nearest)], 0)
