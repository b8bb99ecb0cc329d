# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of animated patterns: those of each frame, beside those that are shown."""

from ..blender import attributes
from ..blender.modifiers import shows_frames
from ..blender.schema import FRAMED, layout_of
from ..blender.transaction import at_the_end, set_aside


def frame_layout(kind):
    """Domain and type of the attributes that each frame has of its own, by their plain names."""
    return {attribute.name: attribute.layout for attribute in FRAMED[kind]}


def frame_name(name, frame):
    """Name of an attribute in a frame."""
    return f"{name}.{frame}"


def remove_frames(obj):
    """Remove the modifier and all attributes of frames."""
    leaving = [modifier for modifier in obj.modifiers if shows_frames(modifier)]
    for modifier in leaving:
        set_aside(modifier)
    at_the_end(lambda: [obj.modifiers.remove(modifier) for modifier in leaving])
    for name in [a.name for a in obj.data.attributes if "." in a.name and layout_of(a.name)]:
        attributes.remove_attribute(obj, name)
