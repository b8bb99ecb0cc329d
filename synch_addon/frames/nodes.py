# SPDX-License-Identifier: GPL-3.0-or-later
"""The modifier that shows an animated pattern: of each frame's attributes, those of the present one.

A geometry node group stores the attributes of the scene's frame, ``synch_phase.12`` and so on, under the plain names
that materials and reliefs read. It needs no driver and no script, so that a render farm shows what the viewport shows.
"""

from ..blender.modifiers import FRAMES, changes_faces, shows_frames
from ..nodes.canvas import Expression, GeometryCanvas, Socket, add_modifier, group_tree
from ..patterns.frame_attributes import frame_layout, frame_name

_VERSION = 1
_INPUTS = (
    Socket("Geometry", "Geometry", "A mesh with a pattern for each frame"),
    Socket("First", "Int", "First frame that has a pattern: it is shown before it, too", 1),
    Socket("Last", "Int", "Last frame that has a pattern: it is shown after it, too", 1),
)
_OUTPUTS = (Socket("Geometry", "Geometry", "The mesh with the pattern of this frame"),)


def frames_group(kind):
    """The group "Synch Frames" of stripes or "Synch Quad Frames", built when missing, rebuilt when outdated."""
    tree, canvas = group_tree(FRAMES[kind], f"{_VERSION}", _INPUTS, _OUTPUTS, GeometryCanvas)
    if canvas is None:
        return tree
    tree.is_modifier = True
    with canvas.band("Frame"):
        inputs = canvas.inputs()
        time = canvas.node("GeometryNodeInputSceneTime", 0)
        frame = canvas.math("ROUND", Expression(canvas, time.outputs["Frame"], 0))
        frame = frame.maximum(inputs["First"]).minimum(inputs["Last"]).named("frame")
        text = canvas.node("FunctionNodeValueToString", 4, "frame", inputs={"Value": frame, "Decimals": 0})
        text = Expression(canvas, text.outputs["String"], 4)
    geometry = inputs["Geometry"]
    for name, (domain, data_type) in frame_layout(kind).items():
        with canvas.band(name):
            geometry = _stored(canvas, geometry, text, name, domain, data_type)
    canvas.outputs(Geometry=geometry)
    return tree


def _stored(canvas, geometry, text, name, domain, data_type):
    """The geometry with a frame's attribute under its plain name; one that is missing is zero."""
    replaced = {"String": frame_name(name, "#"), "Find": "#", "Replace": text}
    of_frame = canvas.node("FunctionNodeReplaceString", 6, f"{name} of frame", inputs=replaced)
    read_type = "FLOAT_VECTOR" if data_type == "FLOAT2" else data_type  # two numbers are read as a vector
    read = canvas.node("GeometryNodeInputNamedAttribute", 7, data_type=read_type)
    canvas.connect(Expression(canvas, of_frame.outputs["String"], 6), read.inputs["Name"])
    return canvas.stored(geometry, name, (domain, data_type), Expression(canvas, read.outputs["Attribute"], 7), 8)


def add_frames(obj, kind, first, last):
    """Give an object the modifier, before the first one that changes its faces; returns the modifier."""
    group = frames_group(kind)
    add_modifier(obj, group, {"First": first, "Last": last})
    others = (n for n, other in enumerate(obj.modifiers) if changes_faces(other) and not shows_frames(other))
    place = next(others, len(obj.modifiers) - 1)
    obj.modifiers.move(len(obj.modifiers) - 1, place)
    return obj.modifiers[place]
