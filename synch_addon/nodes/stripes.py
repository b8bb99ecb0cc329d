# SPDX-License-Identifier: GPL-3.0-or-later
"""Node groups that turn the attributes of a pattern into its phases, and one phase into stripes.

The phase at a point of a face is ``theta = phase + N * lstar(b) + D``: the interpolated corner
values, the turn around a dislocation of index N (lArg of Knöppel et al., "Stripe Patterns on
Surfaces", 2015) and the sheet change around a disclination. A shader sees interpolated corner
values and constant face values only, so the singular terms are evaluated here, at every shading
point, and stay crisp at any resolution. Only ``cos(theta)`` agrees across faces, and for the two
phases of quads the pair of cosines, in either order.
"""

import math

import bpy

from ..blender.schema import BARYCENTRIC, CLOSING, PHASES
from .canvas import Canvas, Socket, group_tree
from .stripe_profiles import PROFILE_TIP, PROFILES, THREAD_TIP, choose_profile, place_in_stripe, profile_heights

STRIPES_NAME = "Synch Stripes"
PHASE_NAME = "Synch Phase"
INK_BLUE = (0.0075, 0.024, 0.085, 1.0)
WARM_IVORY = (0.86, 0.77, 0.60, 1.0)

# In the stamp of every group: raise it when what is built here changes.
VERSION = 3
_THIRD = math.pi / 3.0
# Smallest divisor: ell is undefined at the centre of a singular triangle, and any value will do.
_TINY = 1e-6
# Narrowest fade of an edge, in periods or cells: none at all.
_SHARP = 5e-6


def turning_angle(at_p, at_q, at_r):
    """ell at weights of P, Q and R in a triangle: it grows by 2 pi / 3 along each edge, once around the centre.

    It is constant along rays from the centre: the vertex of smallest weight shows which edge the ray meets, and where.
    """
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


def disclination_turn(place, values, closing):
    """D: how far the phase is from its value at the centre of a disclination, a multiple of pi."""
    x, y, z = place
    first, second, third, fourth = values
    smallest = x.minimum(y).minimum(z)
    # The term of the smallest weight vanishes; next to the last edge the walk is back at corner 0.
    at_start = (y < x.minimum(z)).choose(closing, first).named("at corner 0")
    in_triangle = (x - smallest) * at_start + (y - smallest) * second + (z - smallest) * third
    toward_a = (1.0 - abs(x) - 2.0 * y).named("u = bA - bC")
    at_a = toward_a.maximum(0.0) * (x < 0.0).choose(closing, first).named("at A")
    at_c = (-toward_a).maximum(0.0) * third
    in_quad = at_a + at_c + x.maximum(0.0) * second + (-x).maximum(0.0) * fourth
    return (z < -0.5).choose(in_quad, in_triangle).named("D")


def fade(inside, softness, widest):
    """1 inside, 0 outside, for a distance `inside` that is negative outside.

    The fade at the edge is `softness` wide, but not wider than the `widest` that leaves 0 and 1 in the picture.
    """
    fade = softness.minimum(widest).maximum(_SHARP).named("fade")
    ramp = (inside / fade + 0.5).clamped().named("ramp")
    return (ramp * ramp * (3.0 - 2.0 * ramp)).named("factor")


def round_height(inside, depth):
    """Rounded height: 0 outside, 1 where the distance `inside` has grown to `depth`."""
    share = (inside / depth.maximum(_TINY)).clamped()
    return (0.5 - 0.5 * (share * math.pi).cosine()).named("height")


_PHASE_OUTPUTS = (
    Socket("Phase", "Float", "Phase theta in radians; stripes are centred where it is 0"),
    Socket("Cosine", "Float", "cos(theta), continuous across faces"),
)
_STRIPES_INPUTS = (
    Socket("Profile", "Int", PROFILE_TIP, 0, (0, len(PROFILES) - 1)),
    Socket("Width", "Float", "Part of a period that is stripe", 0.5, (0.0, 1.0)),
    Socket(
        "Softness",
        "Float",
        "Part of a period over which a stripe fades into the background at either edge",
        0.02,
        (0.0, 1.0),
    ),
    Socket("Color", "Color", "Color of the stripes", INK_BLUE),
    Socket("Background", "Color", "Color between the stripes", WARM_IVORY),
    Socket("Strands", "Int", THREAD_TIP, 2, (0, 64)),
)
_STRIPES_OUTPUTS = (
    Socket("Color", "Color", "Stripe and background colors, mixed by the factor"),
    Socket("Factor", "Float", "1 in a stripe, 0 between stripes"),
    Socket("Height", "Float", "The profile, from 0 between stripes to 1 along their middles"),
    *_PHASE_OUTPUTS,
    Socket(
        "Across",
        "Float",
        "Place in a period, from -1 in a gap over 0 in the middle of the stripe to 1; without a sign where stripes are "
        "not numbered",
    ),
    Socket("Along", "Float", "Way along the stripe in spacings, once stripes are numbered; round ones are whole"),
    Socket("Index", "Float", "Number of the stripe, once stripes are numbered: it ends where the line along it does"),
    Socket("Random", "Float", "A number from 0 to 1 for each stripe, once stripes are numbered"),
)


def phase_group(name=PHASE_NAME, attributes=PHASES["stripes"][0], component=None, canvas_type=Canvas):
    """The node group `name` that evaluates one phase from `attributes`, built when missing, of a canvas's kind.

    The value with which a walk around a disclination comes back to its first corner is a `component` of
    :data:`CLOSING`; for None it is the negative of the first value, as for lines.
    Its outputs are Phase (theta, radians) and Cosine. A group of that name that was built for
    other attributes or by an older version is rebuilt in place.
    """
    read = attributes.phase, BARYCENTRIC, attributes.index, attributes.index_2, attributes.disclination
    closing = " 0" if component is None else f"{CLOSING.name} {component}"
    stamp = f"{VERSION} {' '.join(attribute.name for attribute in read)} {closing}"
    tree, canvas = group_tree(name, stamp, (), _PHASE_OUTPUTS, canvas_type)
    if canvas is None:
        return tree
    with canvas.band("Attributes of the mesh"):
        (phase,) = canvas.attribute(attributes.phase.name, "Fac")
        (index,) = canvas.attribute(attributes.index.name, "Fac")
        (index_2,) = canvas.attribute(attributes.index_2.name, "Fac")
        place = canvas.separate(*canvas.attribute(BARYCENTRIC.name, "Vector"))
        color, fourth = canvas.attribute(attributes.disclination.name, "Color", "Alpha")
        values = (*canvas.separate(color), fourth)
        closing = _closing(canvas, component, values[0])
    with canvas.band("Turn around a dislocation: N lstar(b)"):
        dislocation = dislocation_turn(place, index, index_2)
    with canvas.band("Turn around a disclination: D"):
        # An absent attribute has Alpha 1, which is no value: a face with a dislocation has none.
        is_whole = (abs(index) + abs(index_2) < 0.5).named("N = 0?")
        disclination = is_whole * disclination_turn(place, values, closing)
    with canvas.band("Phase"):
        theta = (phase + dislocation + disclination).named("theta")
        canvas.outputs(Phase=theta, Cosine=theta.cosine().named("cos theta"))
    return tree


def _closing(canvas, component, first):
    if component is None:
        return -first
    (both,) = canvas.attribute(CLOSING.name, "Vector")
    return canvas.separate(both)[component]


def stripes_group() -> bpy.types.ShaderNodeTree:
    """The node group "Synch Stripes", built when missing and rebuilt in place when outdated."""
    tree, canvas = group_tree(STRIPES_NAME, f"{VERSION}", _STRIPES_INPUTS, _STRIPES_OUTPUTS)
    phase_tree = phase_group()
    if canvas is None:
        return tree
    with canvas.band("Place in the stripe"):
        inputs = canvas.inputs()
        phase = canvas.group(phase_tree)
        place = place_in_stripe(canvas, phase["Phase"])
        named = {"Across": place.across * 2.0, "Along": place.along, "Index": place.index}
        named["Random"] = canvas.noise(place.index)
    with canvas.band("Profile"):
        width, softness = inputs["Width"], inputs["Softness"]
        named["Height"] = choose_profile(inputs["Profile"], profile_heights(place, width, inputs["Strands"]))
    with canvas.band("Colors"):
        # Periods to the edge of a stripe: the middle is Width / 2 inside.
        factor = fade((width * 0.5 - place.away).named("inside"), softness, width.minimum(1.0 - width))
        color = canvas.color_mix(factor, inputs["Background"], inputs["Color"])
        canvas.outputs(Color=color, Factor=factor, **named, **phase)
    return tree
