# SPDX-License-Identifier: GPL-3.0-or-later
"""The beads of a plan as tubes, as wide and as high as they are printed, with colours and a slider over time.

Tubes are in several objects, each a few thousand points of the program. The object that is seen shows them as
instances, so that moving its slider changes the mesh of one of them only, however large the part is.
"""

import bpy
import numpy as np
from mathutils import Matrix

from ...core.printing.gcode import print_times
from ...core.unit_vectors import unit_vectors
from ..blender.new_geometry import new_mesh
from ..nodes.beads import BEGIN, END, PRINTED, show_beads
from ..nodes.canvas import surface_material

# What the colours of beads may stand for.
LOOKS = ("layer", "height", "tilt", "speed")
# Points around a bead; the power that squares it, 1 for an ellipse; and share of its size, so that neighbours show.
AROUND, _SQUARE, _GAP = 10, 0.6, 0.97
# Points of an object of tubes, about.
_POINTS = 5000
# Colours from the smallest to the largest value, and those that layers take in turn.
_SCALE = np.array([[0.02, 0.16, 0.34], [0.16, 0.36, 0.36], [0.6, 0.45, 0.2], [0.6, 0.27, 0.09], [0.5, 0.07, 0.03]])
_LAYERS = np.array([[0.05, 0.25, 0.5], [0.75, 0.55, 0.25], [0.1, 0.4, 0.35], [0.6, 0.2, 0.1]])
_COLOR, _MATERIAL = "synch_color", "Synch Beads"


def add_beads(plan, look, name):
    """The named object of a PrintPlan's beads in the solid's space, and the collection of its tubes, which is in no
    scene.

    Attributes of the tubes hold what the beads have: `layer`, `height`, `tilt` and `speed` in millimetres, degrees and
    millimetres a second, and `printed`, the share of the printing time after which they are there. The look is one of
    :data:`LOOKS`, the colours.
    """
    lines, values = plan.lines, _values(plan)
    colors, rings = _colors(values[look], look), bead_rings(plan, plan.heights, AROUND)
    ends = np.cumsum(lines.sizes)
    parts = (ends - 1) // _POINTS
    tubes, times = [], []
    for part in np.unique(parts):
        chosen = parts == part
        rows = slice(ends[chosen][0] - lines.sizes[chosen][0], ends[chosen][-1])
        data = new_mesh(
            f"{name} {len(tubes):04d}", rings[rows].reshape(-1, 3), bead_faces(lines.chosen(chosen), AROUND)
        )
        data.transform(Matrix(plan.matrix).inverted())
        for key, of in values.items():
            _add_attribute(data, key, np.repeat(of[rows], AROUND))
        shown = data.color_attributes.new(_COLOR, "FLOAT_COLOR", "POINT")
        opaque = np.column_stack([colors[rows], np.ones(len(colors[rows]))])
        shown.data.foreach_set("color", np.repeat(opaque, AROUND, axis=0).ravel().astype(np.float32))
        data.color_attributes.active_color = shown
        data.materials.append(_material())
        tubes.append(bpy.data.objects.new(data.name, data))
        times.append(values[PRINTED][rows][[0, -1]])
    data = new_mesh(name, np.zeros((len(tubes), 3)))
    for key, of in zip((BEGIN, END), np.transpose(times), strict=True):
        _add_attribute(data, key, of)
    obj = bpy.data.objects.new(name, data)
    return obj, show_beads(obj, tubes)


def _add_attribute(data, name, values):
    data.attributes.new(name, "FLOAT", "POINT").data.foreach_set("value", values.astype(np.float32))


def _values(plan):
    """Attributes of beads by name: their values at the lines' points."""
    seconds, speeds = print_times(plan.course, plan.machine)
    layers, scale = plan.layers[plan.lines.numbers], plan.machine.scale
    printed = seconds / max(seconds[-1], np.finfo(float).tiny)
    return {"layer": layers, "height": plan.heights * scale, "tilt": plan.tilts, "speed": speeds, PRINTED: printed}


def _colors(values, look):
    if look == "layer":
        return _LAYERS[np.asarray(values, int) % len(_LAYERS)]
    low, high = np.quantile(values, [0.01, 0.99])
    share = np.clip((values - low) / max(high - low, 1e-12), 0, 1) * (len(_SCALE) - 1)
    return np.column_stack([np.interp(share, np.arange(len(_SCALE)), column) for column in _SCALE.T])


def bead_rings(plan, heights, around):
    """(n, around, 3) points around the beads of a plan, with (n,) heights, whose upper sides are at the tips."""
    lines, places, normals = plan.lines, plan.tips, plan.normals
    sides = unit_vectors(np.cross(normals, places[lines.next] - places[lines.previous]))
    turn = 2 * np.pi * (np.arange(around) + 0.5) / around
    across, upwards = (np.sign(v) * np.abs(v) ** _SQUARE for v in (np.cos(turn), np.sin(turn)))
    # Where nothing is printed, the tube is a thread.
    widths = np.where(plan.is_printed, plan.widths, 0)
    offsets = _GAP / 2 * widths[:, None, None] * across[:, None] * sides[:, None]
    offsets = offsets + (heights[:, None] / 2 * (_GAP * upwards - 1))[..., None] * normals[:, None]
    return places[:, None] + offsets


def bead_faces(lines, around):
    """Quads between rings of ``around`` points, and caps at the ends of open beads cut into quads."""
    following = lines.next
    first = np.flatnonzero(following != np.arange(len(following)))
    here, there = first[:, None] * around, following[first][:, None] * around
    ring = np.arange(around)
    turned = (ring + 1) % around
    quads = np.stack([here + ring, here + turned, there + turned, there + ring], axis=-1).reshape(-1, 4)
    ends = lines.starts[~lines.closed]
    strip = np.arange(around // 2 - 1)
    cap = np.column_stack([strip, around - 1 - strip, around - 2 - strip, strip + 1])
    lasts = ends + lines.sizes[~lines.closed] - 1
    caps = [
        (rows[:, None, None] * around + corners).reshape(-1, 4)
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
