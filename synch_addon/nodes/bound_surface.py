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
        faces = inputs["Geometry"]
        surface = canvas.value("GeometryNodeObjectInfo", "Geometry", "surface", {"Object": inputs["Surface"]})
        values = {"Geometry": surface, "Position": place}
        bound = canvas.value("GeometryNodeSetPosition", "Geometry", "bound", values)
        values = {"Geometry": faces}
        count = canvas.value("GeometryNodeAttributeDomainSize", "Point Count", "", values, component="MESH")
        numbers = {"A": count, "B": inputs["Vertices"]}
        node = canvas.node("FunctionNodeCompare", 2, "fits?", data_type="INT", operation="EQUAL")
        for socket in node.inputs:  # some versions keep those of all data types, with the same names
            if socket.enabled and socket.name in numbers:
                canvas.connect(numbers[socket.name], socket)
        values = {"Switch": Expression(canvas, node.outputs["Result"], 2), "False": faces, "True": bound}
        shown = canvas.value("GeometryNodeSwitch", "Output", "fits?", values, input_type="GEOMETRY")
        canvas.outputs(Geometry=shown)
    return tree


def _place(canvas, geometry):
    """The weighted mean of the places of three vertices of a geometry."""
    (weights,) = canvas.attribute(WEIGHTS.name, "Vector")
    place = canvas.value("GeometryNodeInputPosition", "Position")
    total = None
    for parent, weight in zip(PARENTS, canvas.separate(weights), strict=True):
        name = parent.name
        index = canvas.value("GeometryNodeInputNamedAttribute", "Attribute", name, {"Name": name}, data_type="INT")
        inputs = {"Geometry": geometry, "Value": place, "Index": index}
        of_one = canvas.value("GeometryNodeSampleIndex", "Value", "", inputs, data_type="FLOAT_VECTOR", domain="POINT")
        part = canvas.vector("SCALE", of_one, Scale=weight)
        total = part if total is None else canvas.vector("ADD", total, part)
    return total
