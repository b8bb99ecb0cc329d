# SPDX-License-Identifier: GPL-3.0-or-later
"""Further outputs of the command ``layers``: a mesh for each layer, tool paths and a volume."""

import math

from ...core.printing.machine import MACHINES, USUAL
from ...core.tasks.layer_outputs import FILLS, PathSettings
from .. import api
from ..blender.files import MESH_SUFFIXES, check_output
from ..solids.beads import LOOKS
from ..solids.files import PATH_SUFFIXES, PROGRAM
from ..solids.outputs import machine_of
from ..solids.report import print_line, program_line
from ..solids.volume import check_volume
from .flags import add_choice, add_number


def add_arguments(command):
    """Add the flags to the command's parser."""
    command.add_argument(
        "--export-layers",
        metavar="FILE.stl",
        help=f"write each layer to a mesh of its own, FILE_000.stl the lowest ({', '.join(MESH_SUFFIXES)})",
    )
    command.add_argument(
        "--export-paths", metavar="FILE.csv", help=f"write tool paths on all layers ({', '.join(PATH_SUFFIXES)})"
    )
    command.add_argument("--export-gcode", metavar="FILE.gcode", help="write tool paths as a program for a printer")
    command.add_argument(
        "--machine",
        metavar="NAME",
        help=f"the printer: {', '.join(MACHINES)}, or a .toml file of one; default: {USUAL}",
    )
    command.add_argument(
        "--path-step",
        type=float,
        metavar="LENGTH",
        help="between two paths; default: the nozzle's width, or the spacing",
    )
    command.add_argument(
        "--infill", type=float, metavar="SHARE", help="of the volume between walls and skins; default: the machine's, 1"
    )
    add_choice(command, "--path-fill", FILLS, FILLS[0], "how paths fill a layer")
    command.add_argument("--beads", choices=LOOKS, help="make a mesh of the beads of the paths, in colours of this")
    command.add_argument("--export-volume", metavar="FILE.vdb", help="write the pattern as a volume")
    add_number(command, "--resolution", 128, "voxels along the longest side", "N")


def _machine(options):
    """The machine that the flag names; without one, the usual machine if there is a program to write, or None."""
    return options.machine or (USUAL if options.export_gcode else None)


def check(options):
    """Refuse outputs that cannot be written, before any work."""
    PathSettings(options.path_step, options.path_fill, machine_of(_machine(options), infill=options.infill))
    if options.export_layers:
        check_output(options.export_layers, MESH_SUFFIXES)
    if options.export_paths:
        check_output(options.export_paths, PATH_SUFFIXES)
    if options.export_gcode:
        check_output(options.export_gcode, (PROGRAM,))
    if options.export_volume:
        check_volume(options.export_volume, options.resolution)


def heights_of(options):
    """Limits of the layers' heights in scene units: from the flags, otherwise from the machine."""
    machine = machine_of(options.machine)
    largest = machine.largest_height if math.isfinite(machine.largest_height) else 0.0
    given = {"smallest_height": machine.smallest_height, "largest_height": largest}
    return {
        name: height / machine.scale if getattr(options, name) is None else getattr(options, name)
        for name, height in given.items()
    }


def write(options, obj):
    """Write the outputs of an object's layers; returns the files, warnings, lines to print and the report of the
    paths."""
    reports, lines, facts = [], [], None
    if options.export_layers:
        reports.append(api.layer_export(obj, options.export_layers))
    paths = [path for path in (options.export_paths, options.export_gcode) if path]
    for path in paths or ([None] if options.beads else []):
        asked = options.path_step, options.path_fill, path, _machine(options), options.beads, options.infill
        facts = api.layer_toolpaths(obj, *asked)
        reports.append(facts)
    if facts is not None:
        lines += [print_line(facts), *([program_line(facts)] if "program" in facts else [])]
    if options.export_volume:
        reports.append(api.layer_volume(obj, options.export_volume, options.resolution))
    files, warnings = (
        list(dict.fromkeys(line for report in reports for line in report.get(key, ()))) for key in ("files", "warnings")
    )
    return files, warnings, lines, facts
