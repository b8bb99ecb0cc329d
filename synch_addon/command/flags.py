# SPDX-License-Identifier: GPL-3.0-or-later
"""Flags shared by several commands, and the results of a command."""

from typing import NamedTuple

import bpy

from ..blender import files


class Made(NamedTuple):
    """Results of a command.

    Attributes
    ----------
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
    """Add a flag for a number of the default's type, which its help states."""
    kind = type(default)
    command.add_argument(flag, type=kind, default=default, metavar=metavar, help=f"{tip} (%(default)s)", **more)


def add_choice(command, flag, choices, default, tip="", **more):
    """Add a flag for one of some choices, whose help states the default."""
    command.add_argument(flag, choices=choices, default=default, help=f"{tip} (%(default)s)".lstrip(), **more)


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


def add_outputs(command, report, picture="", mesh=""):
    """Flags of files, with help that says what the report, the picture and the mesh hold; "" for no such flag."""
    command.add_argument("--output", metavar="FILE.blend", help="save the scene with the result")
    if picture:
        command.add_argument("--render", metavar="FILE.png", help=f"render a picture of {picture}")
        add_view(command)
    if mesh:
        suffixes = ", ".join(files.MESH_SUFFIXES)
        command.add_argument("--export-mesh", metavar="FILE.obj", help=f"write {mesh} ({suffixes})")
    command.add_argument("--report", metavar="FILE.json", help=f"write {report}")
    add_quiet(command)


def add_quiet(command):
    command.add_argument("--quiet", action="store_true", help="no progress on stderr")


def save_scene(options):
    """The path of the scene that was saved, where that is asked for."""
    return [files.save_blend(options.output)] if options.output else []
