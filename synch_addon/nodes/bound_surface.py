# SPDX-License-Identifier: GPL-3.0-or-later
"""A geometry node group that puts a pattern's own surface in place of the faces it was made of, which it follows.

Each vertex of that surface keeps three vertices of the faces and their weights: it lies at the weighted mean of their
places, wherever modifiers have moved them. Where the faces are others by now, they are left as they are.
"""

import bpy

from ..blender.modifiers import SURFACE
from ..blender.schema import PARENTS, WEIGHTS
from .canvas import Expression, GeometryCanvas, Socket, group_tree
from .stripes import VERSION

_INPUTS = (
    Socket("Geometry", "Geometry", "The faces that the surface was made of"),
    Socket("Surface", "Object", "The object whose mesh is the surface"),
    Socket("Vertices", "Int", "How many vertices the faces have to have for the surface to fit", 0, (0, 2**31 - 1)),
)
_OUTPUTS = (Socket("Geometry", "Geometry", "The surface, or the faces where it does not fit"),)


def bound_surface_group() -> bpy.types.GeometryNodeTree:
    """The group "Synch Surface", built when missing, rebuilt when outdated."""
    tree, canvas = group_tree(SURFACE, f"{VERSION}", _INPUTS, _OUTPUTS, GeometryCanvas)
    if canvas is None:
        return tree
    tree.is_modifier = True
    with canvas.band("Place of each vertex"):
        inputs = canvas.inputs()
        place = _place(canvas, inputs["Geometry"])
    with canvas.band("Surface"):
        node = canvas.node("GeometryNodeObjectInfo", 1, "surface", {"Object": inputs["Surface"]})
        surface = Expression(canvas, node.outputs["Geometry"], 1)
        node = canvas.node(
            "GeometryNodeSetPosition", place.depth + 1, "bound", {"Geometry": surface, "Position": place}
        )
        bound = Expression(canvas, node.outputs["Geometry"], place.depth + 1)
        size = canvas.node("GeometryNodeAttributeDomainSize", 1, "", {"Geometry": inputs["Geometry"]}, component="MESH")
        test = {"A": Expression(canvas, size.outputs["Point Count"], 1), "B": inputs["Vertices"]}
        node = canvas.node("FunctionNodeCompare", 2, "fits?", data_type="INT", operation="EQUAL")
        for socket in node.inputs:
            if socket.enabled and socket.name in test:
                canvas.connect(test[socket.name], socket)
        fits = Expression(canvas, node.outputs["Result"], 2)
        values = {"Switch": fits, "False": inputs["Geometry"], "True": bound}
        depth = bound.depth + 1
        node = canvas.node("GeometryNodeSwitch", depth, "fits?", values, input_type="GEOMETRY")
        canvas.outputs(Geometry=Expression(canvas, node.outputs["Output"], depth))
    return tree


def _place(canvas, geometry):
    """The weighted mean of the places of three vertices of a geometry."""
    (weights,) = canvas.attribute(WEIGHTS.name, "Vector")
    place = Expression(canvas, canvas.node("GeometryNodeInputPosition", 0).outputs["Position"], 0)
    total = None
    for parent, weight in zip(PARENTS, canvas.separate(weights), strict=True):
        index = canvas.node("GeometryNodeInputNamedAttribute", 0, parent.name, {"Name": parent.name}, data_type="INT")
        index = Expression(canvas, index.outputs["Attribute"], 0)
        inputs = {"Geometry": geometry, "Value": place, "Index": index}
        node = canvas.node("GeometryNodeSampleIndex", 1, "", inputs, data_type="FLOAT_VECTOR", domain="POINT")
        part = canvas.vector("SCALE", Expression(canvas, node.outputs["Value"], 1), Scale=weight)
        total = part if total is None else canvas.vector("ADD", total, part)
    return total
