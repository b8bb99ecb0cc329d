# SPDX-License-Identifier: GPL-3.0-or-later
"""A modifier that carries a pattern through others: subdivision, mirrors, solid walls and what else comes before it.

Phases at corners and numbers of faces go through such modifiers as they are, and shaders read nothing else. What is
kept at vertices does not: a modifier takes means of cosines, of phases that differ by a turn and of directions that
may point either way, and mirrors no direction. A geometry node group makes it anew from the phases of the mesh that it
gets: of each vertex, those at one of its corners.
"""

import bpy

from ...core.errors import SynchError
from ..blender.modifiers import CARRIES, carries
from ..blender.phases import pattern_kind
from ..blender.schema import DIRECTION, PATTERN, PHASES
from ..blender.transaction import assign
from ..nodes.canvas import GeometryCanvas, Socket, add_modifier, group_tree
from ..nodes.quads import phase_groups
from ..nodes.stripes import VERSION

_INPUTS = (Socket("Geometry", "Geometry", "What other modifiers made of a mesh with a pattern"),)
_OUTPUTS = (Socket("Geometry", "Geometry", "The same with directions, phases and pattern at its vertices"),)


def carry_group(kind) -> bpy.types.GeometryNodeTree:
    """The group "Synch Carry" of stripes or "Synch Quad Carry", built when missing, rebuilt when outdated."""
    tree, canvas = group_tree(CARRIES[kind], f"{VERSION}", _INPUTS, _OUTPUTS, GeometryCanvas)
    phases = phase_groups(kind, "Synch Relief Phase", GeometryCanvas)
    if canvas is None:
        return tree
    tree.is_modifier = True
    with canvas.band("Phases"):
        inputs = canvas.inputs()
        phases = [canvas.group(phase) for phase in phases]
    with canvas.band("Direction"):
        direction = _along(canvas, phases[0]["Phase"])
    with canvas.band("At a corner of each vertex"):
        corner = canvas.value("GeometryNodeCornersOfVertex", "Corner Index")
        pattern = phases[0]["Cosine"] if kind == "stripes" else phases[0]["Cosine"] * phases[1]["Cosine"]
        values = [(DIRECTION, "FLOAT_VECTOR", direction), (PATTERN, "FLOAT", pattern)]
        values += [(own.vertex_phase, "FLOAT", p["Phase"]) for own, p in zip(PHASES[kind], phases, strict=True)]
        geometry = inputs["Geometry"]
        for attribute, data_type, value in values:
            value = _at(canvas, value, corner, data_type)
            geometry = canvas.stored(geometry, attribute.name, attribute.layout, value)
        canvas.outputs(Geometry=geometry)
    return tree


def _at(canvas, value, index, data_type):
    """A value at the corner of an index."""
    inputs = {"Value": value, "Index": index}
    return canvas.value("GeometryNodeFieldAtIndex", "Value", "", inputs, data_type=data_type, domain="CORNER")


def _along(canvas, phase):
    """The unit vector at a corner along which a phase stays as it is and to whose left it grows.

    With the edges a and b to the next and the last corner of the face, and the changes of the phase along them, it is
    change(b) a - change(a) b, but for its length.
    """
    place = canvas.value("GeometryNodeInputPosition", "Position")
    corner = canvas.value("GeometryNodeInputIndex", "Index")
    edges, changes = [], []
    for step in (1, -1):
        inputs = {"Corner Index": corner, "Offset": step}
        other = canvas.value("GeometryNodeOffsetCornerInFace", "Corner Index", "", inputs)
        edges.append(canvas.vector("SUBTRACT", _at(canvas, place, other, "FLOAT_VECTOR"), place))
        changes.append(_at(canvas, phase, other, "FLOAT") - phase)
    parts = [canvas.vector("SCALE", edge, Scale=change) for edge, change in zip(edges, reversed(changes), strict=True)]
    return canvas.vector("NORMALIZE", canvas.vector("SUBTRACT", *parts))


def add_carry(obj):
    """Give an object's stripes or quads the modifier, after all others, or renew the one that it has; returns it.

    Raises SynchError where there is no pattern.
    """
    kind = pattern_kind(obj)
    if kind is None:
        raise SynchError(f"{obj.name} has no stripes or quads: solve one of them first")
    group = carry_group(kind)
    found = next((modifier for modifier in obj.modifiers if carries(modifier)), None)
    if found is None:
        return add_modifier(obj, group, {})
    if found.node_group != group:
        assign(found, "node_group", group)
    return found
