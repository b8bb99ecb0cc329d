# SPDX-License-Identifier: GPL-3.0-or-later
"""Relief: geometry node groups that subdivide a mesh and raise it by the profile of its pattern.

They read the attributes alone, as the shaders do, so that relief and colour coincide. At a corner of a small
face the attributes have the values of the place in the large face that it came from, linear in a triangle and bilinear
in a quad, and the phase is evaluated there by the same formula. From face to face its sign and its multiples of 2 pi
differ, but no profile sees them: the heights at the corners of a vertex agree, and the mean of them moves it.
"""

import math
from numbers import Integral

import bpy
import numpy as np

from ...core.errors import SettingError, SynchError, quote_value
from ...core.validation import convert_value
from ..blender.attributes import read_all, read_values
from ..blender.defect_empties import mean_scale
from ..blender.modifiers import RELIEFS, is_relief
from ..blender.pattern_surface import surface_of
from ..blender.phases import pattern_kind
from ..blender.transaction import assign
from ..nodes.canvas import Expression, GeometryCanvas, Socket, add_modifier, group_tree, set_inputs
from ..nodes.materials import kept_spacing
from ..nodes.quads import PROFILES as QUAD_PROFILES
from ..nodes.quads import phase_groups, profile_shapes
from ..nodes.stripe_profiles import PROFILES as STRIPE_PROFILES
from ..nodes.stripe_profiles import THREAD_TIP, choose_profile, place_in_stripe, profile_heights
from ..nodes.stripes import VERSION

# Edges that a period should have, and the faces up to which the mesh is subdivided for them.
_EDGES_PER_PERIOD = 12
_MOST_FACES = 1_500_000
_DEEPEST = 6
PROFILES = {"stripes": STRIPE_PROFILES, "quads": QUAD_PROFILES}
_OUTPUTS = (Socket("Geometry", "Geometry", "The mesh with its relief"),)


def _inputs(kind, profiles):
    sockets = (
        Socket("Geometry", "Geometry", "A mesh with a pattern"),
        Socket("Height", "Float", "Height of the pattern above the surface; below 0 it is cut in", 0.05),
        Socket("Width", "Float", "Part of a period, or of the area of quads, that is raised", 0.5, (0.0, 1.0)),
        Socket(
            "Profile",
            "Int",
            ", ".join(f"{number}: {name}" for number, name in enumerate(profiles)),
            0,
            (0, len(profiles) - 1),
        ),
        Socket("Level", "Int", "How often the mesh is subdivided: each time, edges are halved", 2, (0, _DEEPEST)),
        Socket("Smooth", "Bool", "Round the surface while it is subdivided", False),
    )
    return sockets if kind == "quads" else (*sockets, Socket("Strands", "Int", THREAD_TIP, 2, (0, 64)))


def relief_group(kind) -> bpy.types.GeometryNodeTree:
    """The group "Synch Relief" of stripes or "Synch Quad Relief", built when missing, rebuilt when outdated."""
    tree, canvas = group_tree(RELIEFS[kind], f"{VERSION}", _inputs(kind, PROFILES[kind]), _OUTPUTS, GeometryCanvas)
    phases = phase_groups(kind, "Synch Relief Phase", GeometryCanvas)
    if canvas is None:
        return tree
    tree.interface.items_tree["Height"].subtype = "DISTANCE"
    tree.is_modifier = True
    with canvas.band("Phase"):
        inputs = canvas.inputs()
        phases = [canvas.group(phase) for phase in phases]
    height = _stripe_height(canvas, phases, inputs) if kind == "stripes" else _quad_height(canvas, phases, inputs)
    with canvas.band("Relief"):
        canvas.outputs(Geometry=_raise_mesh(canvas, inputs, canvas.on_corners(height)))
    return tree


def _stripe_height(canvas, phases, inputs):
    """Heights from 0 to 1."""
    with canvas.band("Profiles"):
        place = place_in_stripe(canvas, phases[0]["Phase"])
        return choose_profile(inputs["Profile"], profile_heights(place, inputs["Width"], inputs["Strands"]))


def _quad_height(canvas, phases, inputs):
    with canvas.band("Pattern"):
        x, y = (phase["Phase"] for phase in phases)
        pattern = (phases[0]["Cosine"] * phases[1]["Cosine"]).named("cos x cos y")
    shapes = profile_shapes(canvas, x, y, pattern, inputs["Width"])
    with canvas.band("Chosen profile"):
        return choose_profile(inputs["Profile"], [shape.height for shape in shapes], QUAD_PROFILES)


def _raise_mesh(canvas, inputs, height):
    """The subdivided mesh, moved along its normals.

    Subdividing leaves faces flat, and the normals of the given mesh are carried over to round the relief; a mesh that
    is rounded has normals of its own.
    """
    capture = canvas.node("GeometryNodeCaptureAttribute", 1, "smooth normals", domain="POINT")
    capture.capture_items.new("VECTOR", "Normal")
    normal = canvas.value("GeometryNodeInputNormal", "Normal")
    canvas.connect(inputs["Geometry"], capture.inputs["Geometry"])
    canvas.connect(normal, capture.inputs["Normal"])
    captured = Expression(canvas, capture.outputs["Geometry"], 1)

    def chosen(input_type, flat, smooth):
        values = {"Switch": inputs["Smooth"], "False": flat, "True": smooth}
        return canvas.value("GeometryNodeSwitch", "Output", "smooth?", values, input_type=input_type)

    values = {"Mesh": captured, "Level": inputs["Level"]}
    flat = canvas.value("GeometryNodeSubdivideMesh", "Mesh", "", values)
    smooth = canvas.value("GeometryNodeSubdivisionSurface", "Mesh", "", values)
    mesh = chosen("GEOMETRY", flat, smooth)
    unit = canvas.vector("NORMALIZE", chosen("VECTOR", Expression(canvas, capture.outputs["Normal"], 1), normal))
    length = (height * inputs["Height"]).named("way")
    offset = canvas.vector("SCALE", unit.named("unit normal"), Scale=length).named("offset")
    return canvas.value("GeometryNodeSetPosition", "Geometry", "", {"Geometry": mesh, "Offset": offset})


def add_relief(obj, height, width, profile, level, smooth):
    """Give an object a modifier with the relief of its pattern, or set the one that it has.

    Arguments as :func:`api.relief`. Returns the modifier's name and what its inputs are set to, for the report.
    """
    kind = _kind_of(obj)
    spacing = kept_spacing(obj) / mean_scale(obj)
    values = {
        "Height": _number("height", height, -math.inf, math.inf) * spacing,
        "Width": _number("width", width, 0, 1),
        "Profile": _profile(kind, profile),
        "Level": _level_for(obj, spacing) if level is None else _whole("level", level, _DEEPEST),
        "Smooth": convert_value("smooth", bool, smooth),
    }
    group = relief_group(kind)
    modifier = next(filter(is_relief, obj.modifiers), None)
    if modifier is None:
        modifier = add_modifier(obj, group, values)
    else:
        if modifier.node_group != group:
            assign(modifier, "node_group", group)
        set_inputs(modifier, values)
    named = PROFILES[kind][values["Profile"]]
    return {"modifier": modifier.name, **{name.lower(): value for name, value in values.items()}, "profile": named}


def _number(name, value, least, most):
    value = convert_value(name, float, value)
    if not (math.isfinite(value) and least <= value <= most):
        between = f" from {least:g} to {most:g}" if math.isfinite(least) else ""
        raise SettingError(f"the {name} is {value!r}: give a number{between}")
    return value


def _whole(name, value, most):
    value = convert_value(name, int, value)
    if not 0 <= value <= most:
        raise SettingError(f"the {name} is {quote_value(value)}: give a whole number from 0 to {most}")
    return value


def _profile(kind, profile):
    """The number of a profile that is given by its name or number."""
    names = PROFILES[kind]
    if isinstance(profile, str) and profile in names:
        return names.index(profile)
    if isinstance(profile, Integral) and not isinstance(profile, bool) and 0 <= profile < len(names):
        return int(profile)
    raise SettingError(f"the profile {quote_value(profile)} is unknown: use one of {', '.join(names)}")


def _kind_of(obj):
    kind = pattern_kind(obj)
    if kind is None or kept_spacing(obj) is None:
        raise SynchError(f"{obj.name} has no stripes or quads: solve one of them first")
    return kind


def _level_for(obj, spacing):
    """How often edges have to be halved for a period to have enough of them, within the limit of faces."""
    surface = surface_of(obj)
    data = surface.data
    ends, places = read_all(data.edges, "vertices", 2), read_values(surface, "position", "POINT")
    edge = np.median(np.linalg.norm(places[ends[:, 0]] - places[ends[:, 1]], axis=1))
    wanted = math.ceil(math.log2(max(_EDGES_PER_PERIOD * edge / spacing, 1)))
    # The first level gives a face to each corner.
    carried = 1 + math.floor(math.log(max(_MOST_FACES / len(data.loops), 1), 4))
    return min(wanted, carried, _DEEPEST)
