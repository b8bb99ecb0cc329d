# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A flow that Blender's own nodes compute and bake to a .vdb file goes in."""

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon.flows.job import clebsch

CENTRE = (0.04, -0.03, 0.0)
CORE = 0.02


class Nodes:
    """A geometry node tree, of which each node is linked to what it takes as it is made."""

    def __init__(self):
        self.tree = bpy.data.node_groups.new("Flow", "GeometryNodeTree")
        self.tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")

    def add(self, kind, *taken, operation=None, **inputs):
        node = self.tree.nodes.new(kind)
        if operation:
            node.operation = operation
        return self.give(node, *taken, **inputs)

    def give(self, node, *taken, **inputs):
        for number, value in enumerate(taken):
            self._set(node.inputs[number], value)
        for name, value in inputs.items():
            self._set(node.inputs[name.replace("_", " ")], value)
        return node

    def _set(self, socket, value):
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def vector(self, operation, *taken, **inputs):
        return self.add("ShaderNodeVectorMath", *taken, operation=operation, **inputs)


def vortex_tree():
    """A grid with the velocity around an upright line of circulation 1, baked."""
    nodes = Nodes()
    place = nodes.vector("SUBTRACT", nodes.add("GeometryNodeInputPosition").outputs[0], CENTRE)
    level = nodes.vector("MULTIPLY", place.outputs[0], (1, 1, 0)).outputs[0]
    square = nodes.vector("DOT_PRODUCT", level, level).outputs["Value"]
    spread = nodes.add("ShaderNodeMath", square, CORE, operation="ADD").outputs[0]
    speed = nodes.add("ShaderNodeMath", 1 / (2 * np.pi), spread, operation="DIVIDE").outputs[0]
    around = nodes.vector("CROSS_PRODUCT", (0, 0, 1), level).outputs[0]
    velocity = nodes.vector("SCALE", around, Scale=speed).outputs[0]
    box = {"Bounds_Min": (-1, -1, -0.5), "Bounds_Max": (1, 1, 0.5)}
    box |= {"Resolution_X": 16, "Resolution_Y": 16, "Resolution_Z": 8}
    topology = nodes.add("GeometryNodeCubeGridTopology", **box).outputs[0]
    grid = nodes.add("GeometryNodeFieldToGrid", Topology=topology)
    grid.grid_items.new("VECTOR", "velocity")
    nodes.give(grid, velocity=velocity)
    volume = nodes.tree.nodes.new("GeometryNodeStoreNamedGrid")
    volume.data_type = "VECTOR_FLOAT"
    nodes.give(volume, Name="velocity", Grid=grid.outputs["velocity"])
    bake = nodes.tree.nodes.new("GeometryNodeBake")
    bake.bake_items.new("GEOMETRY", "Geometry")
    nodes.give(bake, Geometry=volume.outputs["Volume"])
    nodes.add("NodeGroupOutput", bake.outputs["Geometry"])
    return nodes.tree


@pytest.mark.skipif(
    not hasattr(bpy.types, "GeometryNodeCubeGridTopology"), reason="this Blender has no nodes for grids of vectors"
)
def test_a_volume_that_nodes_bake_holds_the_vortex(tmp_path):
    obj = bpy.data.objects.new("Flow", bpy.data.meshes.new("Flow"))
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    modifier = obj.modifiers.new("Flow", "NODES")
    modifier.node_group = vortex_tree()
    modifier.bake_directory = str(tmp_path)
    bpy.context.view_layer.update()
    (bake,) = modifier.bakes
    bake.bake_mode, bake.bake_target = "STILL", "DISK"
    which = {"session_uid": obj.session_uid, "modifier_name": modifier.name, "bake_id": bake.bake_id}
    assert bpy.ops.object.geometry_node_bake_single(**which) == {"FINISHED"}
    (path,) = tmp_path.rglob("*.vdb")
    report = clebsch(path, resolution=16, quantum=1.0, smoothing=0)
    (line,) = report["filaments"]
    assert not line["closed"] and line["strength"] == 1.0
    points = np.array([point.co[:3] for point in bpy.data.objects[report["object"]].data.splines[0].points])
    assert np.abs(points[:, :2] - CENTRE[:2]).max() < 0.5 * 0.125
    assert points[-1, 2] > points[0, 2]
