# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group "Synch Quads": grid lines, a checkerboard, a weave or dots from two phases.

From face to face the phases (x, y) are known up to (y, -x) and multiples of 2 pi; the centres of disclinations lie
where both are even, or both odd, multiples of pi. Each profile is the same for all of them, so that it is continuous
everywhere. A *cell* is a quad of the mesh that the pattern stands for, pi wide; its edges lie at multiples of pi.

The weave is a plain one all over the surface: strands run through the middles of the cells, one crossing in each,
where that of x is above if sin x sin y > 0. A turn exchanges the strands and changes the sign. Strands along the edges
of the cells would have no such rule: at a centre of turning, the one on top would have to be the other one too.
"""

import math
from typing import NamedTuple

import bpy

from ..blender.schema import PHASES
from .canvas import Expression, Socket, group_tree
from .stripes import INK_BLUE, VERSION, WARM_IVORY, Canvas, fade, phase_group, round_height

QUADS_NAME = "Synch Quads"
# In the order of the numbers that choose them.
PROFILES = ("grid lines", "checker", "weave", "dots")

# Parts of a cell: the bevel of a checker tile, and what stays free beside the strand on top of a weave.
_BEVEL = 0.12
_GAP = 0.045
# Height of a strand where it is neither above nor below another, and how far it rises or sinks there.
_LEVEL, _LIFT = 0.6, 0.4

_INPUTS = (
    Socket("Profile", "Int", ", ".join(f"{k}: {name}" for k, name in enumerate(PROFILES)), 0, (0, len(PROFILES) - 1)),
    Socket("Width", "Float", "Part of the area that is line, tile, crossing of strands or dot", 0.5, (0.0, 1.0)),
    Socket("Softness", "Float", "Part of a cell over which an edge fades into the background", 0.02, (0.0, 1.0)),
    Socket("Color", "Color", "Color of lines, tiles, strands or dots", INK_BLUE),
    Socket("Background", "Color", "Color of the rest", WARM_IVORY),
)
_OUTPUTS = (
    Socket("Color", "Color", "Pattern and background colors, mixed by the factor"),
    Socket("Factor", "Float", "1 on lines, tiles, strands or dots, 0 elsewhere"),
    Socket("Height", "Float", "Rounded profile from 0 to 1; strands of a weave go over and under"),
    Socket("Pattern", "Float", "cos(x) cos(y), continuous across faces"),
    Socket("Phase X", "Float", "First phase in radians; cells end at multiples of pi"),
    Socket("Phase Y", "Float", "Second phase in radians; its name and sign may change from face to face"),
)


class _Shape(NamedTuple):
    """A profile at a point: cells inside the edge (negative outside), its widest fade, and the height from 0 to 1."""

    inside: Expression
    widest: Expression
    height: Expression


def quads_group() -> bpy.types.ShaderNodeTree:
    """The node group "Synch Quads", built when missing and rebuilt in place when outdated."""
    tree, canvas = group_tree(QUADS_NAME, f"{VERSION}", _INPUTS, _OUTPUTS)
    phase_trees = phase_groups("quads", "Synch Phase", Canvas)
    if canvas is None:
        return tree
    with canvas.band("Phases"):
        inputs = canvas.inputs()
        phases = [canvas.group(phase_tree) for phase_tree in phase_trees]
        x, y = (phase["Phase"] for phase in phases)
        pattern = (phases[0]["Cosine"] * phases[1]["Cosine"]).named("cos x cos y")
    shapes = profile_shapes(canvas, x, y, pattern, inputs["Width"])
    with canvas.band("Chosen profile"):
        chosen = _choose_shape(inputs["Profile"], shapes)
        factor = fade(chosen.inside, inputs["Softness"], chosen.widest)
        color = canvas.color_mix(factor, inputs["Background"], inputs["Color"])
        named = {"Color": color, "Factor": factor, "Height": chosen.height, "Pattern": pattern}
        canvas.outputs(**named, **{"Phase X": x, "Phase Y": y})
    return tree


def profile_shapes(canvas, x, y, pattern, width):
    """The shapes of all :data:`PROFILES` for two phases, cos x cos y, and a width."""
    with canvas.band("Grid lines"):
        across = [(phase.ping_pong(math.pi / 2) / math.pi).named("cells to an edge") for phase in (x, y)]
        grid = _grid_lines(across, width)
    with canvas.band("Checker"):
        checker = _checker(across, width, pattern)
    with canvas.band("Weave"):
        weave = _weave(across, width, (x.sine() * y.sine()).named("sin x sin y"))
    with canvas.band("Dots"):
        dots = _dots(across, width)
    return grid, checker, weave, dots


def phase_groups(kind, name, canvas_type):
    """The node group for the phase of stripes, or those for both phases of quads."""
    if kind == "stripes":
        return [phase_group(name, canvas_type=canvas_type)]
    return [phase_group(f"{name} {'XY'[k]}", phase, k, canvas_type) for k, phase in enumerate(PHASES["quads"])]


def _grid_lines(across, width):
    line = (1.0 - (1.0 - width).root()).named("line")
    inside = line * 0.5 - across[0].minimum(across[1])
    return _Shape(inside, line.minimum(1.0 - line), round_height(inside, line * 0.5))


def _checker(across, width, pattern):
    is_tile = (pattern > 0.0).named("tile?")
    to_edge = (0.5 - across[0].maximum(across[1])).named("cells to the edge of the square")
    side = (2.0 * width.minimum(1.0 - width)).root().named("side of the smaller squares")
    grown = (width < 0.5).choose(side - 1.0, 1.0 - side) * 0.5
    inside = is_tile.choose(to_edge, -to_edge) + grown
    return _Shape(inside, side, round_height(inside, (side * 0.5).minimum(_BEVEL)))


def _weave(across, width, above):
    strand = width.root().named("strand")
    hole = (0.5 - strand * 0.5).named("half the space between strands")
    gap = (hole * 0.5).minimum(_GAP)
    x_inside, y_inside = (strand * 0.5 - (0.5 - distance) for distance in across)
    x_over = (above > 0.0).named("x over y?")
    over = x_over.choose(x_inside, y_inside).named("over")
    under = x_over.choose(y_inside, x_inside).named("under")
    free = (-over - gap).named("free of the one above")
    rise = abs(above) * _LIFT
    # Half way to the next crossing the strands change places, and nothing is to be seen of it.
    end = hole - gap
    above_height = round_height(over, strand * 0.5) * (_LEVEL + rise)
    below_height = round_height(under, strand * 0.5) * (_LEVEL - rise) * round_height(free, end)
    inside = over.maximum(under.minimum(free))
    return _Shape(inside, strand.minimum(2.0 * end), above_height.maximum(below_height))


def _dots(across, width):
    radius = (width / math.pi).root().named("radius")
    inside = radius - (across[0] * across[0] + across[1] * across[1]).root()
    return _Shape(inside, 2.0 * radius.minimum(math.sqrt(0.5) - radius), round_height(inside, radius))


def _choose_shape(profile, shapes):
    """The shape with the number `profile`."""
    chosen = shapes[-1]
    for number, shape in reversed(list(enumerate(shapes[:-1]))):
        is_it = (profile < number + 0.5).named(f"{PROFILES[number]}?")
        chosen = _Shape(*(is_it.choose(mine, others) for mine, others in zip(shape, chosen, strict=True)))
    return chosen
