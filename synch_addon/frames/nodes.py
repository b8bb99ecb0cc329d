# SPDX-License-Identifier: GPL-3.0-or-later
"""The modifier that shows an animated pattern: of each frame's attributes, those of the present one.

A geometry node group stores the attributes of the scene's frame, ``synch_phase.12`` and so on, under the plain names
that materials and reliefs read. It needs no driver and no script, so that a render farm shows what the viewport shows.
"""

from ..nodes.canvas import Expression, GeometryCanvas, Socket, group_tree, set_input
from ..patterns.relief import is_relief
from ..patterns.write import layout

NAMES = {"stripes": "Synch Frames", "quads": "Synch Quad Frames"}
_VERSION = 1
# Modifiers after which the mesh may have other faces.
_CHANGES_FACES = (
    {"ARRAY", "BEVEL", "BOOLEAN", "BUILD", "DECIMATE", "EDGE_SPLIT", "EXPLODE", "MASK", "MIRROR", "MULTIRES"}
    | {"NODES", "OCEAN", "REMESH", "SCREW", "SKIN", "SOLIDIFY", "SUBSURF", "TRIANGULATE", "WELD", "WIREFRAME"}
)  # fmt: skip
_INPUTS = (
    Socket("Geometry", "Geometry", "A mesh with a pattern for each frame"),
    Socket("First", "Int", "First frame that has a pattern: it is shown before it, too", 1),
    Socket("Last", "Int", "Last frame that has a pattern: it is shown after it, too", 1),
)
_OUTPUTS = (Socket("Geometry", "Geometry", "The mesh with the pattern of this frame"),)


def frame_layout(kind):
    """Domain and type of the attributes that each frame has of its own, by their plain names."""
    same = ("synch_barycentric", "synch_vertex_phase")
    own = {name: kind for name, kind in layout(1 if kind == "stripes" else 2).items() if not name.startswith(same)}
    return own | {"synch_direction": ("POINT", "FLOAT_VECTOR")}


def frame_name(name, frame):
    """What an attribute is called in a frame."""
    return f"{name}.{frame}"


def frames_group(kind):
    """The group "Synch Frames" of stripes or "Synch Quad Frames", built when missing, rebuilt when outdated."""
    tree, canvas = group_tree(NAMES[kind], f"{_VERSION}", _INPUTS, _OUTPUTS, GeometryCanvas)
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
    store = canvas.node("GeometryNodeStoreNamedAttribute", 8, name, data_type=data_type, domain=domain)
    store.inputs["Name"].default_value = name
    canvas.connect(geometry, store.inputs["Geometry"])
    canvas.connect(Expression(canvas, read.outputs["Attribute"], 7), store.inputs["Value"])
    return Expression(canvas, store.outputs["Geometry"], 8)


def add_frames(obj, kind, first, last):
    """Give an object the modifier, before the first one that changes its faces; returns the modifier."""
    group = frames_group(kind)
    modifier = obj.modifiers.new(group.name, "NODES")
    modifier.node_group = group
    set_input(modifier, "First", first)
    set_input(modifier, "Last", last)
    others = (n for n, other in enumerate(obj.modifiers) if changes_faces(other) and not shows_frames(other))
    place = next(others, len(obj.modifiers) - 1)
    obj.modifiers.move(len(obj.modifiers) - 1, place)
    return obj.modifiers[place]


def changing_modifiers(obj):
    """The modifiers after which the mesh that is seen may have other faces than the one that carries a pattern."""
    return [m for m in obj.modifiers if m.show_viewport and changes_faces(m) and not is_ours(m)]


def changes_faces(modifier):
    """Whether the mesh may have other faces after a modifier."""
    return modifier.type in _CHANGES_FACES


def is_ours(modifier):
    """Whether a modifier shows a pattern and does not shape the mesh that carries it."""
    return shows_frames(modifier) or is_relief(modifier)


def shows_frames(modifier):
    """Whether a modifier uses one of the groups."""
    group = modifier.node_group if modifier.type == "NODES" else None
    return group is not None and group.name in NAMES.values()


def remove_frames(obj):
    """Remove the modifier and all attributes of frames."""
    for modifier in [m for m in obj.modifiers if shows_frames(m)]:
        obj.modifiers.remove(modifier)
    plain = frame_layout("stripes") | frame_layout("quads")
    for name in [attribute.name for attribute in obj.data.attributes]:
        head, _, frame = name.rpartition(".")
        if head in plain and frame.lstrip("-").isdigit():
            obj.data.attributes.remove(obj.data.attributes[name])
