# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that move, and what they show in a frame."""

import bpy
import numpy as np

from .scenes import attribute


def moving(obj, shapes):
    """Give an object a shape in each frame from the first on, by keyed shape keys."""
    obj.shape_key_add(name="Basis")
    for frame, points in enumerate(shapes, start=1):
        key = obj.shape_key_add(name=f"Frame {frame}")
        key.data.foreach_set("co", np.float32(points).ravel())
        for beside, value in ((frame - 1, 0.0), (frame, 1.0), (frame + 1, 0.0)):
            key.value = value
            key.keyframe_insert("value", frame=beside)
    bpy.context.scene.frame_set(1)
    return obj


def swaying(obj, frames=3, much=0.25):
    """An object that is sheared to the side, more in each frame."""
    points = attribute(obj, "position").reshape(-1, 3)
    x, y, z = points.T
    return moving(obj, [np.column_stack([x + much * k * z * z / 2, y, z]) for k in range(frames)])


def turned(points, angle):
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T


def seen(obj, frame):
    """The object as it is evaluated in a frame."""
    bpy.context.scene.frame_set(frame)
    return obj.evaluated_get(bpy.context.evaluated_depsgraph_get())


def stored_frames(obj):
    return sorted(int(a.name.split(".")[1]) for a in obj.data.attributes if a.name.startswith("synch_pattern."))
