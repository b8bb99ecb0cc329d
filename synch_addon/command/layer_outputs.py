# SPDX-License-Identifier: GPL-3.0-or-later
"""What the command ``layers`` writes besides: a mesh for each layer, tool paths and a volume."""

from ...core.tasks.layer_outputs import FILLS, PathSettings
from .. import api
from ..blender.files import MESH_SUFFIXES, check_output
from ..solids.files import PATH_SUFFIXES
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
    command.add_argument("--path-step", type=float, metavar="LENGTH", help="between two paths; default: the spacing")
    add_choice(command, "--path-fill", FILLS, FILLS[0], "how paths fill a layer")
    command.add_argument("--export-volume", metavar="FILE.vdb", help="write the pattern as a volume")
    add_number(command, "--resolution", 128, "voxels along the longest side", "N")


def check(options):
    """Refuse, before any work, outputs that cannot be written."""
    PathSettings(options.path_step, options.path_fill)
    if options.export_layers:
        check_output(options.export_layers, MESH_SUFFIXES)
    if options.export_paths:
        check_output(options.export_paths, PATH_SUFFIXES)
    if options.export_volume:
        check_volume(options.export_volume, options.resolution)


def write(options, obj):
    """Write what is asked for of an object's layers; returns the paths, and warnings."""
    reports = []
    if options.export_layers:
        reports.append(api.layer_export(obj, options.export_layers))
    if options.export_paths:
        reports.append(api.layer_toolpaths(obj, options.path_step, options.path_fill, options.export_paths))
    if options.export_volume:
        reports.append(api.layer_volume(obj, options.export_volume, options.resolution))
    files, warnings = ([line for report in reports for line in report.get(key, ())] for key in ("files", "warnings"))
    return files, warnings
