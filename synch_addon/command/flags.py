# SPDX-License-Identifier: GPL-3.0-or-later
"""Flags that commands of the command line share, and what a command has made."""

from typing import NamedTuple

import bpy

from ...core.errors import SettingError
from ...core.solve import METHODS, ROUNDINGS
from ...core.solve.solution import SMALLEST_GAP
from ...core.tasks.settings import SolverSettings
from ..blender import files
from ..settings.solver import RANGE


class Made(NamedTuple):
    """What a command has made.

    Attributes
    ----------
    report : dict
    lines : of text to print; those of warnings and files are added
    written : paths of files
    shown : bpy.types.Object of the picture, where one is asked for
    look : how the picture shows it, as :func:`render.render_picture` takes it
    failed : why the exit status is not 0 although all this was made
    """

    report: dict
    lines: list[str]
    written: list[str]
    shown: bpy.types.Object | None = None
    look: dict = {}
    failed: str = ""


def add_number(command, flag, default, tip, metavar="X", **more):
    """Add a flag for a number of the default's type, which its help tells."""
    kind = type(default)
    command.add_argument(flag, type=kind, default=default, metavar=metavar, help=f"{tip} (%(default)s)", **more)


def add_choice(command, flag, choices, default, tip=""):
    """Add a flag for one of some choices, whose help tells the default."""
    command.add_argument(flag, choices=choices, default=default, help=f"{tip} (%(default)s)".lstrip())


def add_input(command):
    command.add_argument("input", nargs="?", help=".blend, .obj, .ply, .stl or .glb; default: the file that is open")
    command.add_argument("--object", metavar="NAME", help="which mesh object, where the file has several")


def add_view(command):
    command.add_argument(
        "--view",
        nargs=2,
        type=float,
        default=(-25.0, 14.0),
        metavar=("AZIMUTH", "ELEVATION"),
        help="where the picture is taken from, degrees from the front view (default: -25 14)",
    )


def add_outputs(command, told, picture="", mesh=""):
    """Flags of files: ``told`` is what the report holds, ``picture`` and ``mesh`` what they show, "" for none."""
    command.add_argument("--output", metavar="FILE.blend", help="save the scene with the result")
    if picture:
        command.add_argument("--render", metavar="FILE.png", help=f"render a picture of {picture}")
        add_view(command)
    if mesh:
        suffixes = ", ".join(files.MESH_SUFFIXES)
        command.add_argument("--export-mesh", metavar="FILE.obj", help=f"write {mesh} ({suffixes})")
    command.add_argument("--report", metavar="FILE.json", help=f"write {told}")
    add_quiet(command)


def add_quiet(command):
    command.add_argument("--quiet", action="store_true", help="no progress on stderr")


def add_strict(command):
    command.add_argument("--strict", action="store_true", help="refuse meshes that are no surface as they are")


def add_solver(command):
    """Flags of :class:`SolverSettings`."""
    default = SolverSettings()
    add_choice(command, "--method", METHODS, default.method, "sdp proves a bound, spectral is fast")
    rounded = "how sdp comes to a field: svd and random as they are, polish and continuation go on to less energy"
    add_choice(command, "--rounding", ROUNDINGS, default.rounding, rounded)
    add_number(command, "--seed", default.seed, "of every random choice", "N")
    bracketed = f"how closely the relaxation's optimum is bracketed, from {SMALLEST_GAP:g}"
    add_number(command, "--target-gap", default.target_gap, bracketed)
    command.add_argument("--time-limit", type=float, metavar="SECONDS", help="for each solve")


def add_spacing(command, between):
    """Flags of a spacing between two of what is named, as :func:`spacing_of` reads them."""
    command.add_argument("--spacing", type=float, metavar="LENGTH", help=f"{between}; default: automatic")
    command.add_argument(
        "--spacing-map",
        default="",
        metavar="NAME",
        help="float attribute, a factor on the spacing, or vertex group, which takes it from 1 to the range",
    )
    command.add_argument(
        "--spacing-range",
        type=float,
        metavar="X",
        help=f"factor where the vertex group's weight is 1 ({RANGE:g})",
    )


def solver_of(options):
    """The settings of the solver, as a dict."""
    return {name: getattr(options, name) for name in SolverSettings.__annotations__}


def spacing_of(options):
    """The settings of the spacing, as a dict."""
    if options.spacing_range is not None and not options.spacing_map:
        raise SettingError("the spacing range belongs to a spacing map: add --spacing-map NAME")
    factor = {} if options.spacing_range is None else {"spacing_range": options.spacing_range}
    return {"spacing": options.spacing, "spacing_map": options.spacing_map} | factor


def saved(options):
    """The path of the scene that was saved, where that is asked for."""
    return [files.save_blend(options.output)] if options.output else []
