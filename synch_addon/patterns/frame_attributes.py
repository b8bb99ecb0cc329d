# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of animated patterns: those of each frame, beside those that are shown."""

from ..blender.modifiers import shows_frames
from .write import layout


def frame_layout(kind):
    """Domain and type of the attributes that each frame has of its own, by their plain names."""
    same = ("synch_barycentric", "synch_vertex_phase")
    own = {name: kind for name, kind in layout(1 if kind == "stripes" else 2).items() if not name.startswith(same)}
    return own | {"synch_direction": ("POINT", "FLOAT_VECTOR")}


def frame_name(name, frame):
    """What an attribute is called in a frame."""
    return f"{name}.{frame}"


def remove_frames(obj):
    """Remove the modifier and all attributes of frames."""
    for modifier in [m for m in obj.modifiers if shows_frames(m)]:
        obj.modifiers.remove(modifier)
    plain = frame_layout("stripes") | frame_layout("quads")
    for name in [attribute.name for attribute in obj.data.attributes]:
        head, _, frame = name.rpartition(".")
        if head in plain and frame.lstrip("-").isdigit():
            obj.data.attributes.remove(obj.data.attributes[name])
