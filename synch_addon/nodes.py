# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader node groups that turn the attributes of a field into its picture.

The phase at a point of a face is ``theta = phase + N * lstar(b) + D``: the interpolated corner
values, the turn around a dislocation of index N (lArg of Knöppel et al., "Stripe Patterns on
Surfaces", 2015) and the sheet change around a disclination. A shader sees interpolated corner
values and constant face values only, so the singular terms are evaluated here, at every shading
point, and stay crisp at any resolution. Only ``cos(theta)`` agrees across faces.
"""

import math
from collections import Counter
from contextlib import contextmanager
from dataclasses import astuple, dataclass
from typing import NamedTuple

import bpy

STRIPES_NAME = "Synch Stripes"
PHASE_NAME = "Synch Phase"
INK_BLUE = (0.0075, 0.024, 0.085, 1.0)
WARM_IVORY = (0.86, 0.77, 0.60, 1.0)

_STAMP = "synch_stamp"
_VERSION = 1
_THIRD = math.pi / 3.0
# Smallest divisor: ell is undefined at the centre of a singular triangle, and any value will do.
_TINY = 1e-6
_COLUMN_WIDTH = 190
_ROW_HEIGHT = 50


@dataclass(frozen=True)
class PhaseAttributes:
    """Names of the attributes that hold one phase; the defaults are those of stripes."""

    phase: str = "synch_phase"
    barycentric: str = "synch_barycentric"
    index: str = "synch_index"
    index_2: str = "synch_index_2"
    disclination: str = "synch_disclination"


class Expression:
    """A number in a shader: arithmetic on expressions adds the Math nodes that compute it."""

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

    __radd__ = __add__
    __rmul__ = __mul__

    def minimum(self, other):
        return self.canvas.math("MINIMUM", self, other)

    def maximum(self, other):
        return self.canvas.math("MAXIMUM", self, other)

    def cosine(self):
        return self.canvas.math("COSINE", self)

    def ping_pong(self, scale):
        """Distance to the nearest even multiple of `scale`."""
        return self.canvas.math("PINGPONG", self, scale)

    def choose(self, where_true, where_false):
        """`where_true` where this comparison holds (1), `where_false` where not (0)."""
        return self.canvas.mix(self, where_false, where_true)

    def named(self, label):
        """Label the node, so that the formula can be read in the node editor too."""
        self.socket.node.label = label
        return self


class Canvas:
    """A node tree that is being drawn: nodes stand in the column of their depth."""

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

    def color_mix(self, factor, first, second):
        depth = max(value.depth for value in (factor, first, second)) + 1
        node = self.place("ShaderNodeMix", depth, "Color", rows=5)
        node.data_type = "RGBA"
        for value, index in ((factor, 0), (first, 6), (second, 7)):
            self.connect(value, node.inputs[index])
        return Expression(self, node.outputs[2], depth)

    def group(self, tree, depth=0):
        """Use another node group; its outputs as expressions by name."""
        node = self.place("ShaderNodeGroup", depth, rows=4)
        node.node_tree = tree
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


def turning_angle(at_p, at_q, at_r):
    """ell of a triangle PQR: grows by 2 pi / 3 along each edge, once around the centre."""
    smallest = at_p.minimum(at_q).minimum(at_r).named("smallest weight")
    r_smallest = (at_r < at_p.minimum(at_q)).named("R smallest?")
    p_smallest = (at_p < at_q).named("P smaller than Q?")
    start = r_smallest.choose(1.0, p_smallest.choose(3.0, 5.0)).named("middle of the edge")
    along = r_smallest.choose(at_q - at_p, p_smallest.choose(at_r - at_q, at_p - at_r))
    ratio = along.named("along the edge") / (1.0 - 3.0 * smallest).maximum(_TINY)
    return ((start + ratio) * _THIRD).named("ell")


def dislocation_turn(place, index, index_2):
    """N * lstar(b) at the `place` (three components) of a triangle or a split quad."""
    x, y, z = place
    is_quad = (z < -0.5).named("quad?")
    in_second = (x < 0.0).named("second triangle?")
    # A quad stores s in x and t in y: its triangles are PQR = ABC (s >= 0) and CDA (s < 0).
    at_b_or_d = abs(x).named("|s|")
    at_a = (1.0 - at_b_or_d - y).named("A: 1 - |s| - t")
    at_p = is_quad.choose(in_second.choose(y, at_a), x).named("bP")
    at_q = is_quad.choose(at_b_or_d, y).named("bQ")
    at_r = is_quad.choose(in_second.choose(at_a, y), z).named("bR")
    # This term makes lstar a multiple of 2 pi along the diagonal RP, and continuous across it.
    across = is_quad * (_THIRD * at_q + 2.0 * _THIRD * at_r)
    number = (is_quad * in_second).choose(index_2, index).named("N")
    return (number * (turning_angle(at_p, at_q, at_r) + across).named("lstar")).named("N lstar")


def disclination_turn(place, values):
    """D: how far the phase is from the value 0 or pi at the centre of a disclination."""
    x, y, z = place
    first, second, third, fourth = values
    smallest = x.minimum(y).minimum(z)
    # The term of the smallest weight vanishes; corner 0 changes its sheet next to edge 20.
    sheet = (y < x.minimum(z)).choose(-1.0, 1.0).named("sheet of corner 0")
    in_triangle = (x - smallest) * first * sheet + (y - smallest) * second + (z - smallest) * third
    toward_a = (1.0 - abs(x) - 2.0 * y).named("u = bA - bC")
    at_a = toward_a.maximum(0.0) * first * (x < 0.0).choose(-1.0, 1.0)
    at_c = (-toward_a).maximum(0.0) * third
    in_quad = at_a + at_c + x.maximum(0.0) * second + (-x).maximum(0.0) * fourth
    return (z < -0.5).choose(in_quad, in_triangle).named("D")


class _Socket(NamedTuple):
    name: str
    kind: str
    description: str
    default: object = None
    limits: tuple | None = None


_PHASE_OUTPUTS = (
    _Socket("Phase", "Float", "Phase theta in radians; stripes are centred where it is 0"),
    _Socket("Cosine", "Float", "cos(theta), continuous across faces"),
)
_STRIPES_INPUTS = (
    _Socket("Width", "Float", "Part of a period that is stripe", 0.5, (0.0, 1.0)),
    _Socket(
        "Softness",
        "Float",
        "Part of a period over which a stripe fades into the background at either edge",
        0.02,
        (0.0, 1.0),
    ),
    _Socket("Color", "Color", "Color of the stripes", INK_BLUE),
    _Socket("Background", "Color", "Color between the stripes", WARM_IVORY),
)
_STRIPES_OUTPUTS = (
    _Socket("Color", "Color", "Stripe and background colors, mixed by the factor"),
    _Socket("Factor", "Float", "1 in a stripe, 0 between stripes"),
    _Socket("Height", "Float", "Rounded profile, 1 along the middle of a stripe, 0 between"),
    *_PHASE_OUTPUTS,
)


def phase_group(name=PHASE_NAME, attributes=PhaseAttributes()):
    """The node group `name` that evaluates one phase from `attributes`, built when missing.

    Its outputs are Phase (theta, radians) and Cosine. A group of that name that was built for
    other attributes or by an older version is rebuilt in place.
    """
    tree, is_current = _tree_for(name, f"{_VERSION} {' '.join(astuple(attributes))}")
    if is_current:
        return tree
    _declare(tree, (), _PHASE_OUTPUTS)
    canvas = Canvas(tree)
    with canvas.band("Attributes of the mesh"):
        (phase,) = canvas.attribute(attributes.phase, "Fac")
        (index,) = canvas.attribute(attributes.index, "Fac")
        (index_2,) = canvas.attribute(attributes.index_2, "Fac")
        place = canvas.separate(*canvas.attribute(attributes.barycentric, "Vector"))
        color, fourth = canvas.attribute(attributes.disclination, "Color", "Alpha")
        values = (*canvas.separate(color), fourth)
    with canvas.band("Turn around a dislocation: N lstar(b)"):
        dislocation = dislocation_turn(place, index, index_2)
    with canvas.band("Turn around a disclination: D"):
        # An absent attribute has Alpha 1, which is no value: a face with a dislocation has none.
        is_whole = (abs(index) + abs(index_2) < 0.5).named("N = 0?")
        disclination = is_whole * disclination_turn(place, values)
    with canvas.band("Phase"):
        theta = (phase + dislocation + disclination).named("theta")
        canvas.outputs(Phase=theta, Cosine=theta.cosine().named("cos theta"))
    return tree


def stripes_group() -> bpy.types.ShaderNodeTree:
    """The node group "Synch Stripes", built when missing and rebuilt in place when outdated."""
    tree, is_current = _tree_for(STRIPES_NAME, f"{_VERSION}")
    phase_tree = phase_group()
    if is_current:
        return tree
    _declare(tree, _STRIPES_INPUTS, _STRIPES_OUTPUTS)
    canvas = Canvas(tree)
    inputs = canvas.inputs()
    phase = canvas.group(phase_tree)
    width, softness = inputs["Width"], inputs["Softness"]
    # Half periods from the middle of a stripe, a function of cos(theta): the edge is at Width.
    distance = (phase["Phase"].ping_pong(math.pi) / math.pi).named("distance")
    # A fade wider than the stripe or the gap would leave grey where Width is 0 or 1.
    fade = softness.minimum(width).minimum(1.0 - width).maximum(1e-5).named("fade")
    ramp = ((width - distance) / fade * 0.5 + 0.5).maximum(0.0).minimum(1.0).named("ramp")
    factor = (ramp * ramp * (3.0 - 2.0 * ramp)).named("factor")
    across = (distance / width.maximum(_TINY)).minimum(1.0).named("across the stripe")
    height = (0.5 + 0.5 * (across * math.pi).cosine()).named("height")
    color = canvas.color_mix(factor, inputs["Background"], inputs["Color"])
    canvas.outputs(Color=color, Factor=factor, Height=height, **phase)
    return tree


def _tree_for(name, stamp):
    """The local shader group `name`, and whether it was built with this `stamp`.

    One that was not is emptied; its sockets stay, and with them what users have set there.
    """
    groups = [
        tree
        for tree in bpy.data.node_groups
        if tree.name == name and tree.bl_idname == "ShaderNodeTree" and tree.library is None
    ]
    tree = groups[0] if groups else bpy.data.node_groups.new(name, "ShaderNodeTree")
    if tree.get(_STAMP) == stamp:
        return tree, True
    tree.nodes.clear()
    tree[_STAMP] = stamp
    return tree, False


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
        socket.name,
        description=socket.description,
        in_out=direction,
        socket_type=f"NodeSocket{socket.kind}",
    )
    if socket.limits:
        item.subtype = "FACTOR"
        item.min_value, item.max_value = socket.limits
    if socket.default is not None:
        item.default_value = socket.default
