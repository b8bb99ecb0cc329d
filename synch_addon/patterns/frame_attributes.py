# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of animated patterns: those of each frame, beside those that are shown."""

from ..blender.modifiers import shows_frames
from ..blender.schema import FRAMED, layout_of


def frame_layout(kind):
    """Domain and type of the attributes that each frame has of its own, by their plain names."""
    return {attribute.name: attribute.layout for attribute in FRAMED[kind]}


def frame_name(name, frame):
    """What an attribute is called in a frame."""
    return f"{name}.{frame}"


def remove_frames(obj):
    """Remove the modifier and all attributes of frames."""
    for modifier in [m for m in obj.modifiers if shows_frames(m)]:
        obj.modifiers.remove(modifier)
    for name in [a.name for a in obj.data.attributes if "." in a.name and layout_of(a.name)]:
        obj.data.attributes.remove(obj.data.attributes[name])
