# SPDX-License-Identifier: GPL-3.0-or-later
"""Stripes on a bending tentacle: how much changes from frame to frame.

    python bench/animation.py

Prints a table: the animation without and with a hold on the frame before, and solves of each frame alone. Needs Blender
as a module (bpy).
"""

import time

import bpy
import numpy as np

import synch_fields
from synch_fields.bench.command import arguments
from synch_fields.bench.tables import Column, print_table
from synch_fields.synch_addon import api

FRAMES = 24
SEGMENTS, RINGS, LENGTH, RADIUS = 56, 190, 5.0, 0.62
SPACING = 0.16
COLUMNS = (
    Column("mean change", "mean", ".3f"),
    Column("largest change", "largest", ".3f"),
    Column("energy", "energy", ".1f"),
    Column("s a frame", "seconds", ".2f"),
)


def main():
    """Print the table."""
    arguments(__doc__).parse_args()
    synch_fields.register()
    try:
        bpy.ops.wm.read_homefile(use_empty=True)
        measure(tentacle())
    finally:
        synch_fields.unregister()


def tentacle():
    """A tapering arm with a round tip on its foot, which curls and sways as the frames go on."""
    along = np.linspace(0, 1, RINGS)
    radii = RADIUS * (1 - 0.8 * along) * np.sqrt(np.minimum(1, (1 - along) / 0.03 + 1e-4))
    radii[0] *= 0.96
    turns = 2 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    points = np.array(
        [(r * np.cos(a), r * np.sin(a), LENGTH * z) for z, r in zip(along, radii, strict=True) for a in turns]
    )
    points = np.vstack([points, [(0, 0, 0), (0, 0, LENGTH * 1.0005)]])
    ring = np.arange(SEGMENTS)
    after = (ring + 1) % SEGMENTS
    faces = []
    for k in range(RINGS - 1):
        low, high = k * SEGMENTS, (k + 1) * SEGMENTS
        faces += np.column_stack([low + ring, low + after, high + after, high + ring]).tolist()
    foot, tip = len(points) - 2, len(points) - 1
    faces += np.column_stack([np.full(SEGMENTS, foot), after, ring]).tolist()
    top = (RINGS - 1) * SEGMENTS
    faces += np.column_stack([np.full(SEGMENTS, tip), top + ring, top + after]).tolist()
    mesh = bpy.data.meshes.new("Tentacle")
    mesh.from_pydata(points.tolist(), [], faces)
    mesh.shade_smooth()
    obj = bpy.data.objects.new("Tentacle", mesh)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.shape_key_add(name="Basis")
    for frame in range(1, FRAMES + 1):
        key = obj.shape_key_add(name=f"Frame {frame}")
        key.data.foreach_set("co", np.float32(curled(points, frame)).ravel())
        for near, value in ((frame - 1, 0.0), (frame, 1.0), (frame + 1, 0.0)):
            key.value = value
            key.keyframe_insert("value", frame=near)
    return obj


def curled(points, frame):
    """The arm along a curve in a plane whose curvature grows to the tip and changes its sign once a cycle."""
    phase = 2 * np.pi * (frame - 1) / FRAMES
    steps = np.linspace(0, 1.01, 800)
    bend = np.cos(phase) * 1.1 * steps**1.5 + np.sin(phase) * 0.5 * np.sin(np.pi * steps)
    angle = np.cumsum(4.2 * bend) * (steps[1] - steps[0])
    middle = np.cumsum(np.column_stack([np.sin(angle), np.cos(angle)]), axis=0) * (steps[1] - steps[0]) * LENGTH
    share = np.clip(points[:, 2] / LENGTH, 0, 1.01)
    at, x, z = (np.interp(share, steps, values) for values in (angle, *middle.T))
    return np.column_stack([x + points[:, 0] * np.cos(at), points[:, 1], z - points[:, 0] * np.sin(at)])


def measure(obj):
    """Print what the animation costs and changes beside solves of each frame alone, also along its directions."""
    rows = [
        row("hold 0.1", api.animate(obj, frames=(1, FRAMES), spacing=SPACING)),
        alone(obj, "each alone, the same directions", guidance="attribute:synch_direction"),
    ]
    rows.append(alone(obj, "each alone"))
    rows.insert(0, row("hold 0", api.animate(obj, frames=(1, FRAMES), spacing=SPACING, hold=0)))
    print_table(f"{FRAMES} frames of {len(obj.data.vertices)} vertices", COLUMNS, rows)


def alone(obj, label, **settings):
    """A row of the table for solves of each frame alone."""
    start = time.perf_counter()
    patterns, energies = [], []
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        shape = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        copy = bpy.data.objects.new("Alone", bpy.data.meshes.new_from_object(shape))
        bpy.context.scene.collection.objects.link(copy)
        energies.append(api.stripes(copy, spacing=SPACING, **settings)["energy"])
        values = np.empty(len(copy.data.vertices), np.float32)
        copy.data.attributes["synch_pattern"].data.foreach_get("value", values)
        patterns.append(values)
        bpy.data.objects.remove(copy)
    changes = np.abs(np.diff(patterns, axis=0)).mean(axis=1)
    seconds = (time.perf_counter() - start) / FRAMES
    return {
        "label": label,
        "mean": changes.mean(),
        "largest": changes.max(),
        "energy": np.mean(energies),
        "seconds": seconds,
    }


def row(label, report):
    """A row of the table for an animation."""
    changes = [frame["change"] for frame in report["frames"][1:]]
    return {
        "label": label,
        "mean": np.mean(changes),
        "largest": max(changes),
        "energy": np.mean([frame["energy"] for frame in report["frames"]]),
        "seconds": report["times"]["total"] / FRAMES,
    }


if __name__ == "__main__":
    main()
