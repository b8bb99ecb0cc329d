# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawing node groups: formulas as arithmetic on expressions, nodes in readable columns."""

from collections import Counter
from contextlib import contextmanager
from typing import NamedTuple

import bpy

from ..blender.modifiers import input_property, input_value
from ..blender.transaction import keep, undone_by

_STAMP = "synch_stamp"
_COLUMN_WIDTH = 190
_ROW_HEIGHT = 50


class Expression:
    """A number in a node tree: arithmetic on expressions adds the Math nodes that compute it."""

    def __init__(self, canvas, socket, depth):
        self.canvas, self.socket, self.depth = canvas, socket, depth

    def __add__(self, other):
        return self.canvas.math("ADD", self, other)

    def __sub__(self, other):
        return self.canvas.math("SUBTRACT", self, other)

    def __rsub__(self, other):
        return self.canvas.math("SUBTRACT", other, self)

    def __mul__(self, other):
        return self.canvas.math("MULTIPLY", self, other)

    def __truediv__(self, other):
        return self.canvas.math("DIVIDE", self, other)

    def __neg__(self):
        return self.canvas.math("MULTIPLY", self, -1.0)

    def __abs__(self):
        return self.canvas.math("ABSOLUTE", self)

    def __lt__(self, other):
        return self.canvas.math("LESS_THAN", self, other)

    def __gt__(self, other):
        return self.canvas.math("GREATER_THAN", self, other)

    __radd__ = __add__
    __rmul__ = __mul__

    def minimum(self, other):
        return self.canvas.math("MINIMUM", self, other)

    def maximum(self, other):
        return self.canvas.math("MAXIMUM", self, other)

    def cosine(self):
        return self.canvas.math("COSINE", self)

    def sine(self):
        return self.canvas.math("SINE", self)

    def arcsine(self):
        return self.canvas.math("ARCSINE", self)

    def root(self):
        return self.canvas.math("SQRT", self)

    def ping_pong(self, scale):
        """Distance to the nearest even multiple of `scale`."""
        return self.canvas.math("PINGPONG", self, scale)

    def clamped(self):
        """This between 0 and 1."""
        return self.maximum(0.0).minimum(1.0)

    def choose(self, where_true, where_false):
        """`where_true` where this comparison holds (1), `where_false` where not (0)."""
        return self.canvas.mix(self, where_false, where_true)

    def named(self, label):
        """Label the node, so that the formula can be read in the node editor too."""
        self.socket.node.label = label
        return self


class Canvas:
    """A node tree that is being drawn: nodes stand in the column of their depth. This one is of shader nodes."""

    tree_type, group_type = "ShaderNodeTree", "ShaderNodeGroup"

    def __init__(self, tree):
        self.tree = tree
        self._frame = None
        self._top = self._last_column = 0
        self._rows = Counter()

    @contextmanager
    def band(self, label):
        """Nodes that are added inside stand in a frame, below everything that is there."""
        self._frame = self.tree.nodes.new("NodeFrame")
        self._frame.label, self._frame.select = label, False
        yield
        self._top += max(self._rows.values()) + 2
        self._frame, self._rows = None, Counter()

    def place(self, type_name, depth, label="", rows=1):
        """Add a node to column `depth` of this band, below those that are there."""
        node = self.tree.nodes.new(type_name)
        node.parent = self._frame
        node.location = (_COLUMN_WIDTH * depth, -_ROW_HEIGHT * (self._top + self._rows[depth]))
        node.label, node.select = label, False
        self._rows[depth] += rows
        self._last_column = max(self._last_column, depth)
        return node

    def connect(self, value, socket):
        """Link an expression to an input, or set the input to a plain number."""
        if isinstance(value, Expression):
            self.tree.links.new(value.socket, socket)
        else:
            socket.default_value = value

    def attribute(self, name, *outputs):
        """Read the mesh attribute `name`; one expression for each output asked for."""
        node = self.place("ShaderNodeAttribute", 0, name, rows=4)
        node.attribute_name = name
        wanted = [node.outputs[output] for output in outputs]
        for output in node.outputs:
            output.hide = output not in wanted
        return [Expression(self, output, 0) for output in wanted]

    def separate(self, vector):
        """The three components of a vector or colour."""
        node = self.place("ShaderNodeSeparateXYZ", vector.depth + 1, rows=3)
        self.connect(vector, node.inputs[0])
        return [Expression(self, output, vector.depth + 1) for output in node.outputs]

    def math(self, operation, *operands):
        return self._node("ShaderNodeMath", operands, lambda node: node.inputs, operation)

    def mix(self, factor, first, second):
        return self._node("ShaderNodeMix", (factor, first, second), _float_inputs)

    def noise(self, value):
        """A number from 0 to 1 for a whole number: the same for the same one, nothing alike for others."""
        return self.value("ShaderNodeTexWhiteNoise", "Value", "random", {"W": value}, noise_dimensions="1D")

    def color_mix(self, factor, first, second):
        return self.value("ShaderNodeMix", 2, "Color", {0: factor, 6: first, 7: second}, data_type="RGBA")

    def color(self, label, value):
        """A colour that many inputs can share."""
        node = self.place("ShaderNodeRGB", 0, label)
        node.outputs[0].default_value = value
        return Expression(self, node.outputs[0], 0)

    def tinted(self, color, ratio):
        """A colour times another one."""
        settings = {"data_type": "RGBA", "blend_type": "MULTIPLY"}
        return self.value("ShaderNodeMix", 2, "tint", {0: 1.0, 6: color, 7: ratio}, **settings)

    def node(self, type_name, depth, label="", inputs=(), **settings):
        """Add a node with these settings and values of its inputs, by their names."""
        node = self.place(type_name, depth, label, rows=4)
        for name, value in settings.items():
            setattr(node, name, value)
        for name, value in dict(inputs).items():
            self.connect(value, node.inputs[name])
        return node

    def value(self, type_name, output, label="", inputs=(), **settings):
        """An output of a new node, which stands one column after what its inputs come from."""
        depth = 1 + max((value.depth for value in dict(inputs).values() if isinstance(value, Expression)), default=-1)
        return Expression(self, self.node(type_name, depth, label, inputs, **settings).outputs[output], depth)

    def group(self, tree, depth=0, inputs=()):
        """Use another node group with these values of its inputs; its outputs as expressions by name."""
        depth = max([depth, *(value.depth + 1 for value in dict(inputs).values() if isinstance(value, Expression))])
        node = self.place(self.group_type, depth, rows=4)
        node.node_tree = tree
        for name, value in dict(inputs).items():
            self.connect(value, node.inputs[name])
        return {output.name: Expression(self, output, depth) for output in node.outputs}

    def inputs(self):
        """The inputs of this group, as expressions by name."""
        node = self.place("NodeGroupInput", 0, rows=4)
        return {out.name: Expression(self, out, 0) for out in node.outputs if out.name}

    def outputs(self, **values):
        """Connect the outputs of this group, one column after everything else."""
        node = self.place("NodeGroupOutput", self._last_column + 1)
        for name, value in values.items():
            self.connect(value, node.inputs[name])

    def _node(self, type_name, operands, inputs_of, operation=None):
        depth = max(value.depth for value in operands if isinstance(value, Expression)) + 1
        node = self.place(type_name, depth)
        node.hide = True
        if operation:
            node.operation = operation
        # A Math node has inputs to spare: how many it uses depends on the operation.
        for value, socket in zip(operands, inputs_of(node), strict=False):
            self.connect(value, socket)
        return Expression(self, node.outputs[0], depth)


def _float_inputs(mix_node):
    # A Mix node keeps the inputs of all its data types; those for numbers are 0, 2 and 3.
    return mix_node.inputs[0], mix_node.inputs[2], mix_node.inputs[3]


class Socket(NamedTuple):
    """An input or output of a group; ``kind`` is the end of Blender's name for its type."""

    name: str
    kind: str
    description: str
    default: object = None
    limits: tuple | None = None


def group_tree(name, stamp, inputs, outputs, kind=Canvas):
    """The local node group `name`, and where it was not built with this `stamp`, a canvas to draw it on, else None.

    It is emptied then; sockets that are still wanted stay, and with them what users have set there.
    """
    groups = [
        tree
        for tree in bpy.data.node_groups
        if tree.name == name and tree.bl_idname == kind.tree_type and tree.library is None
    ]
    tree = groups[0] if groups else bpy.data.node_groups.new(name, kind.tree_type)
    if tree.get(_STAMP) == stamp:
        return tree, None
    if groups:
        keep(tree)
    tree.nodes.clear()
    tree[_STAMP] = stamp
    _declare(tree, inputs, outputs)
    return tree, kind(tree)


def _declare(tree, inputs, outputs):
    """Give a group these sockets; those that it has already keep their users' values."""
    sockets = [(socket, "INPUT") for socket in inputs] + [(socket, "OUTPUT") for socket in outputs]
    wanted = {(socket.name, direction) for socket, direction in sockets}
    present = {(item.name, item.in_out): item for item in tree.interface.items_tree}
    for key, item in present.items():
        if key not in wanted:
            tree.interface.remove(item)
    for socket, direction in sockets:
        if (socket.name, direction) not in present:
            _new_socket(tree, socket, direction)


def _new_socket(tree, socket, direction):
    item = tree.interface.new_socket(
        socket.name, description=socket.description, in_out=direction, socket_type=f"NodeSocket{socket.kind}"
    )
    if socket.limits:
        item.min_value, item.max_value = socket.limits
        if socket.kind == "Float":
            item.subtype = "FACTOR"
    if socket.default is not None:
        item.default_value = socket.default


def find_node(tree, kind):
    """The first node of a kind, such as "ShaderNodeBackground", in a tree; None without one, or without a tree.

    Nodes are found by their kind, since Blender translates their names.
    """
    return next((node for node in (tree.nodes if tree else ()) if node.bl_idname == kind), None)


def surface_material(name):
    """A new material with its Principled BSDF and its output node, which are all that it has.

    Blender's own new materials have other nodes where a volume is active.
    """
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    surface, output = nodes.new("ShaderNodeBsdfPrincipled"), nodes.new("ShaderNodeOutputMaterial")
    output.location = (300, 0)
    material.node_tree.links.new(surface.outputs["BSDF"], output.inputs["Surface"])
    return material, surface, output


class GeometryCanvas(Canvas):
    """A geometry node tree that is being drawn."""

    tree_type, group_type = "GeometryNodeTree", "GeometryNodeGroup"
    _TYPES = {"Fac": "FLOAT", "Vector": "FLOAT_VECTOR", "Color": "FLOAT_COLOR"}

    def attribute(self, name, *outputs):
        """Read the mesh attribute `name` as the shader's Attribute node gives it; absent is zero, Alpha too."""
        node = self.place("GeometryNodeInputNamedAttribute", 0, name, rows=4)
        node.data_type = self._TYPES[outputs[0]]
        node.inputs["Name"].default_value = name
        read = [Expression(self, node.outputs["Attribute"], 0)]
        if "Alpha" in outputs:
            parts = self.place("FunctionNodeSeparateColor", 1, "alpha", rows=4)
            self.connect(read[0], parts.inputs[0])
            read.append(Expression(self, parts.outputs["Alpha"], 1))
        return read

    def vector(self, operation, *operands, **inputs):
        """A vector of vectors, by an operation of the Vector Math node; ``inputs`` are others of its inputs."""
        values = dict(enumerate(operands)) | inputs
        return self.value("ShaderNodeVectorMath", "Vector", "", values, operation=operation)

    def stored(self, geometry, name, layout, value):
        """The geometry with a value as an attribute of a layout, domain and type."""
        domain, data_type = layout
        inputs = {"Geometry": geometry, "Name": name, "Value": value}
        settings = {"data_type": data_type, "domain": domain}
        return self.value("GeometryNodeStoreNamedAttribute", "Geometry", name, inputs, **settings)

    def on_corners(self, value):
        """A number evaluated at the corners of faces, whatever it is used on."""
        settings = {"data_type": "FLOAT", "domain": "CORNER"}
        return self.value("GeometryNodeFieldOnDomain", "Value", "on corners", {"Value": value}, **settings)


def set_inputs(modifier, values):
    """Set inputs of a modifier's group, by their names; undone where the work fails."""
    obj, name, before = modifier.id_data, modifier.name, {key: input_value(modifier, key) for key in values}
    undone_by(obj, lambda: _set_values(obj.modifiers[name], before))
    _set_values(modifier, values)


def add_modifier(obj, group, values):
    """A new last modifier that runs a geometry node group with values of inputs; it goes where the work fails."""
    present = {modifier.name for modifier in obj.modifiers}
    undone_by(obj, lambda: [obj.modifiers.remove(one) for one in list(obj.modifiers) if one.name not in present])
    modifier = obj.modifiers.new(group.name, "NODES")
    modifier.node_group = group
    _set_values(modifier, values)
    return modifier


def _set_values(modifier, values):
    for name, value in values.items():
        holder, key = input_property(modifier, name)
        if key == "value":
            holder.value = value
        else:
            holder[key[2:-2]] = value
    modifier.id_data.update_tag()
