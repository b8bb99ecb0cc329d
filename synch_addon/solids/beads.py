# SPDX-License-Identifier: GPL-3.0-or-later
"""The beads of a plan as one mesh of tubes, as wide and as high as they are printed, with colours."""

import bpy
import numpy as np

from ..blender.new_geometry import new_mesh
from ..nodes.canvas import surface_material

# What the colours of beads may stand for.
LOOKS = ("layer", "height", "tilt", "speed")
# Points around a bead; the power that squares it, 1 for an ellipse; and share of its size, so that neighbours show.
_AROUND, _SQUARE, _GAP = 10, 0.6, 0.97
# Colours from the smallest to the largest value, and those that layers take in turn.
_SCALE = np.array([[0.02, 0.16, 0.34], [0.16, 0.36, 0.36], [0.6, 0.45, 0.2], [0.6, 0.27, 0.09], [0.5, 0.07, 0.03]])
_LAYERS = np.array([[0.05, 0.25, 0.5], [0.75, 0.55, 0.25], [0.1, 0.4, 0.35], [0.6, 0.2, 0.1]])
_COLOR, _MATERIAL = "synch_color", "Synch Beads"


def beads_mesh(plan, look):
    """A mesh in the world: its attributes `layer`, `height`, `tilt` and `speed` hold what the beads have, millimetres,
    degrees and millimetres a second; one of them is its colours.

    Parameters
    ----------
    plan : PrintPlan
    look : one of :data:`LOOKS`
    """
    lines = plan.lines
    rings = _rings(plan)
    vertices = rings.reshape(-1, 3)
    values = _values(plan)
    data = new_mesh("Beads", vertices, _faces(lines))
    for name, of in values.items():
        data.attributes.new(name, "FLOAT", "POINT").data.foreach_set("value", np.repeat(of, _AROUND).astype(np.float32))
    colors = np.repeat(_colors(values[look], look), _AROUND, axis=0)
    shown = data.color_attributes.new(_COLOR, "FLOAT_COLOR", "POINT")
    shown.data.foreach_set("color", np.column_stack([colors, np.ones(len(colors))]).ravel().astype(np.float32))
    data.color_attributes.active_color = shown
    data.materials.append(_material())
    return data


def _values(plan):
    """What the beads have at the lines' points; the first layer and the table's limits do not slow the speed here."""
    machine, layers = plan.machine, plan.layers[plan.lines.numbers]
    sections = plan.widths * plan.heights * machine.scale**2
    speeds = np.full(len(sections), machine.feed / 60)
    if machine.largest_flow:
        speeds = np.minimum(speeds, machine.largest_flow / np.maximum(sections, 1e-9))
    return {"layer": layers, "height": plan.heights * machine.scale, "tilt": plan.tilts, "speed": speeds}


def _colors(values, look):
    if look == "layer":
        return _LAYERS[np.asarray(values, int) % len(_LAYERS)]
    low, high = np.quantile(values, [0.01, 0.99])
    share = np.clip((values - low) / max(high - low, 1e-12), 0, 1) * (len(_SCALE) - 1)
    return np.column_stack([np.interp(share, np.arange(len(_SCALE)), column) for column in _SCALE.T])


def _rings(plan):
    """(n, _AROUND, 3) points around the beads, whose upper sides are at the tips."""
    lines, places, normals = plan.lines, plan.tips, plan.normals
    following, before = lines.next, np.arange(len(places))
    before[following] = np.arange(len(places))
    starts = lines.starts[~lines.closed]
    before[starts] = starts
    sides = np.cross(normals, places[following] - places[before])
    sides /= np.maximum(np.linalg.norm(sides, axis=1, keepdims=True), np.finfo(float).tiny)
    turn = 2 * np.pi * (np.arange(_AROUND) + 0.5) / _AROUND
    across, upwards = (np.sign(v) * np.abs(v) ** _SQUARE for v in (np.cos(turn), np.sin(turn)))
    offsets = _GAP / 2 * plan.widths[:, None, None] * across[:, None] * sides[:, None]
    offsets = offsets + (plan.heights[:, None] / 2 * (_GAP * upwards - 1))[..., None] * normals[:, None]
    return places[:, None] + offsets


def _faces(lines):
    """Quads between rings, and caps at the ends of open beads cut into quads."""
    following = lines.next
    first = np.flatnonzero(following != np.arange(len(following)))
    around = np.arange(_AROUND)
    turned = (around + 1) % _AROUND
    quads = np.stack(
        [first[:, None] * _AROUND + around, first[:, None] * _AROUND + turned,
         following[first][:, None] * _AROUND + turned, following[first][:, None] * _AROUND + around], axis=-1
    ).reshape(-1, 4)  # fmt: skip
    ends = lines.starts[~lines.closed]
    strip = np.arange(_AROUND // 2 - 1)
    cap = np.column_stack([strip, _AROUND - 1 - strip, _AROUND - 2 - strip, strip + 1])
    lasts = ends + lines.sizes[~lines.closed] - 1
    caps = [
        (rows[:, None, None] * _AROUND + corners).reshape(-1, 4)
        for rows, corners in ((ends, cap), (lasts, cap[:, ::-1]))
    ]
    return np.concatenate([quads, *caps])


def _material():
    """The material that shows the colours; that of the file where there is one."""
    found = bpy.data.materials.get(_MATERIAL)
    if found is not None:
        return found
    material, surface, _ = surface_material(_MATERIAL)
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeVertexColor")
    node.layer_name, node.location = _COLOR, (-250, 0)
    tree.links.new(node.outputs["Color"], surface.inputs["Base Color"])
    surface.inputs["Roughness"].default_value = 0.55
    return material
