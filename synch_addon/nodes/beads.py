# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group "Synch Beads": tubes of the beads that have been printed after a share of the time."""

import bpy

from ..blender.modifiers import modifier_of
from .canvas import Expression, GeometryCanvas, Socket, add_modifier, group_tree

BEADS_NAME = "Synch Beads"
_VERSION = 1
# When tubes are printed, of their points, and from when to when each object of tubes, as shares of the time.
PRINTED, BEGIN, END = "printed", "begin", "end"
SLIDER = "Printed"
_INPUTS = (
    Socket("Geometry", "Geometry", "A point for each object of tubes, in their order, with its begin and end"),
    Socket("Tubes", "Collection", "The objects of tubes"),
    Socket(SLIDER, "Float", "Share of the printing time up to which beads are shown", 1.0, (0.0, 1.0)),
)
_OUTPUTS = (Socket("Geometry", "Geometry", "The beads that are printed by then"),)


def show_beads(obj, tubes):
    """Give an object of points the modifier that shows objects of tubes; returns their collection."""
    collection = bpy.data.collections.new(obj.name)
    for tube in tubes:
        collection.objects.link(tube)
    add_modifier(obj, beads_group(), {"Tubes": collection})
    return collection


def beads_modifier(obj):
    """The modifier of :func:`show_beads`, or None."""
    return modifier_of(obj, BEADS_NAME)


def beads_group():
    """The geometry node group "Synch Beads", built when missing and rebuilt in place when outdated.

    Tubes that are wholly printed are instances; only those that are being printed are cut.
    """
    tree, canvas = group_tree(BEADS_NAME, f"{_VERSION}", _INPUTS, _OUTPUTS, GeometryCanvas)
    if canvas is None:
        return tree
    tree.is_modifier = True
    inputs = canvas.inputs()
    printed, begin, end = (canvas.attribute(name, "Fac")[0] for name in (PRINTED, BEGIN, END))
    time = inputs[SLIDER]
    values = {"Collection": inputs["Tubes"], "Separate Children": True}
    tubes = canvas.value("GeometryNodeCollectionInfo", "Instances", "tubes", values)
    is_begun = (begin < time).named("begun?")
    values = {"Points": inputs["Geometry"], "Selection": is_begun, "Instance": tubes, "Pick Instance": True}
    begun = canvas.value("GeometryNodeInstanceOnPoints", "Instances", "", values)
    values = {"Geometry": begun, "Selection": (end > time).named("cut?")}
    parted = canvas.node("GeometryNodeSeparateGeometry", 3, "", values, domain="INSTANCE")
    cut, whole = (Expression(canvas, parted.outputs[name], 3) for name in ("Selection", "Inverted"))
    cut = canvas.value("GeometryNodeRealizeInstances", "Geometry", "", {"Geometry": cut})
    values = {"Geometry": cut, "Selection": (printed > time).named("later?")}
    cut = canvas.value("GeometryNodeDeleteGeometry", "Geometry", "", values, domain="POINT")
    joined = canvas.node("GeometryNodeJoinGeometry", 6)
    for part in (whole, cut):
        canvas.connect(part, joined.inputs["Geometry"])
    canvas.outputs(Geometry=Expression(canvas, joined.outputs["Geometry"], 6))
    return tree
