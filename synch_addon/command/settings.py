# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of fields and patterns as flags of the command line."""

import json
import math

from ...core.errors import SettingError
from ...core.files.border import SETTINGS_BYTES, border, read_text
from ..settings.constraints import from_plain
from ..settings.fields import BOUNDARIES, SYMMETRIES, Settings, default_shares
from ..settings.guidance import KINDS
from .flags import add_choice, add_number, add_solver, add_spacing, add_strict, solver_of, spacing_of


def add_settings(command, name):
    """Add the flags that a command of a name has to its parser."""
    default, shares = Settings(), default_shares(name)
    of_quads = name in ("quads", "quad_mesh")
    if name != "directions":
        add_spacing(command, "two quads' length" if of_quads else "between stripes")
    if of_quads:
        aspect = "spacing along the second direction over that along the first, which is nearer to X"
        add_number(command, "--aspect", default.aspect, aspect)
    else:
        symmetry = "what is the same at a point; cross for directions only"
        add_choice(command, "--symmetry", tuple(SYMMETRIES), default.symmetry, symmetry)
    if name == "quad_mesh":
        features = "boundaries and edges that bend by more than this stay edges; 0 for none"
        add_number(command, "--features", math.degrees(default.features), features, "DEG")
        smoothing = "how often vertices move to where faces are nearer to squares, on the surface"
        add_number(command, "--smoothing", default.smoothing, smoothing, "N")
        faces = "about how many faces, whatever the spacing; 0 for as many as that gives"
        add_number(command, "--faces", default.faces, faces, "N")
        command.add_argument("--straighten", action="store_true", help="look for shorter loops of quads")
    if name != "directions":
        tip = "share of the branches that even spacing needs, from 0 (hardly any or none) to 1"
        add_number(command, "--branching", shares["branching"], tip)
    tip = "share of the shape's unevenness answered by singular points, from 0 (as few as can be) to 1"
    add_number(command, "--singularities", shares["singularities"], tip)
    command.add_argument(
        "--guidance",
        default=default.guidance,
        metavar="SPEC",
        help=f"smooth, or sources KIND:NAME=STRENGTH separated by commas; kinds: {', '.join(KINDS)} (%(default)s)",
    )
    command.add_argument(
        "--angle", type=float, default=0.0, metavar="DEG", help="turn the directions, counterclockwise"
    )
    command.add_argument(
        "--angle-attribute",
        default="",
        metavar="NAME",
        help="float attribute, radians from vertex to vertex on top, or vertex group, which takes them to the range",
    )
    command.add_argument(
        "--angle-range", type=float, metavar="DEG", help="angle where the vertex group's weight is 1 (57.3)"
    )
    boundary = "what directions do at open edges; phase: a line lies exactly on them"
    add_choice(command, "--boundary", BOUNDARIES, default.boundary, boundary)
    command.add_argument("--vertex-group", default="", metavar="NAME", help="restrict the boundary to this group")
    command.add_argument(
        "--mirror", default="", metavar="AXES", help="X, Y, Z or several: the result is its own mirror image in them"
    )
    command.add_argument(
        "--pins",
        metavar="FACE=TURNS,...",
        help="faces around which directions turn so often, in halves for lines and quarters for crosses; default: "
        "those stored with the object",
    )
    add_strict(command)
    command.add_argument(
        "--constraints", metavar="ROWS.json", help="a list of rows; default: the list stored with the object"
    )
    add_solver(command)


def settings_of(options):
    """The :class:`Settings` that the flags stand for."""
    if options.vertex_group and options.boundary == "free":
        raise SettingError(
            f"the vertex group {options.vertex_group!r} restricts the boundary, which is free: "
            "add --boundary along, across or phase"
        )
    if options.angle_range is not None and not options.angle_attribute:
        raise SettingError("the angle range belongs to an angle attribute: add --angle-attribute NAME")
    names = ("aspect", "smoothing", "faces", "straighten", "branching")
    only_some = {name: getattr(options, name) for name in names if hasattr(options, name)}
    if hasattr(options, "features"):
        only_some["features"] = math.radians(options.features)
    if options.angle_range is not None:
        only_some["angle_range"] = math.radians(options.angle_range)
    return Settings(
        symmetry=getattr(options, "symmetry", "cross"),
        guidance=options.guidance,
        angle=math.radians(options.angle),
        angle_attribute=options.angle_attribute,
        boundary=options.boundary,
        vertex_group=options.vertex_group,
        mirror=options.mirror.upper(),
        singularities=options.singularities,
        pins=options.pins,
        constraints=_read_constraints(options.constraints) if options.constraints else None,
        **(spacing_of(options) if hasattr(options, "spacing") else {}),
        **only_some,
        **solver_of(options),
        assign_material=True,
        strict=options.strict,
    )


def _read_constraints(path):
    with border(path, "write a JSON list of rows"):
        return from_plain(json.loads(read_text(path, SETTINGS_BYTES)))
