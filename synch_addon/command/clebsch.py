# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``clebsch`` of the command line: vortices of a flow."""

import bpy

from ...core.errors import SettingError
from ...core.files.flows import SUFFIXES as FLOW_SUFFIXES
from ...core.settings.flow import FlowSettings
from .. import api
from ..blender import files
from ..blender.modifiers import is_of_filaments
from ..flows.files import SUFFIXES
from ..flows.job import job_for
from ..flows.report import summary
from ..jobs.job import run as run_job
from .flags import Made, add_outputs, save_scene
from .settings import add_settings, settings_of


def add_parser(commands):
    """Add the command to the parser's."""
    command = commands.add_parser(
        "clebsch", help="vortex filaments or tubes of a flow", description="Show the vortices of a flow."
    )
    command.add_argument(
        "input", help=f"file with a velocity ({', '.join(FLOW_SUFFIXES)}), or a .blend file with curves or meshes"
    )
    command.add_argument(
        "--object", nargs="+", metavar="NAME", help="volume, mesh, or curves that stand for filaments, of a .blend file"
    )
    add_settings(command, FlowSettings, "clebsch")
    command.add_argument(
        "--export-filaments", metavar="FILE.vtp", help=f"write filaments in one piece each ({', '.join(SUFFIXES)})"
    )
    add_outputs(command, "energies, bounds, filaments and times")


def _only(attribute):
    """The only flow in the scene: a volume, a mesh with the attribute, or all curves except filaments shown before.

    Raises SettingError without a flow, and names them if there are several.
    """
    objects = list(bpy.context.scene.objects)
    curves = [obj for obj in objects if obj.type == "CURVE" and not any(map(is_of_filaments, obj.modifiers))]
    alone = [
        obj for obj in objects if obj.type == "VOLUME" or (obj.type == "MESH" and attribute in obj.data.attributes)
    ]
    choices = [[obj] for obj in alone] + [curves] * bool(curves)
    if len(choices) == 1:
        return choices[0]
    names = ", ".join(obj.name for obj in (alone + curves if choices else objects)) or "nothing"
    reason = f"the file has several flows ({names})" if choices else f"nothing in the file is a flow (it has {names})"
    raise SettingError(f"{reason}: name an object with --object, and a mesh's velocity with --attribute")


def run(options, _open_object, progress):
    """Run the command."""
    files.check_outputs(options.output, report=options.report)
    if options.export_filaments:
        files.check_output(options.export_filaments, SUFFIXES)
        if options.show == "tubes" or options.frames:
            raise SettingError("--export-filaments writes the filaments of one frame: give --show filaments or both")
    settings = settings_of(options, FlowSettings)
    source = options.input
    if str(options.input).lower().endswith(".blend"):
        files.open_input(options.input)
        source = [files.named_object(name) for name in options.object] if options.object else _only(options.attribute)
        source = source[0] if len(source) == 1 else source
    else:
        bpy.ops.wm.read_homefile(use_empty=True)
    report = run_job(job_for(source, settings), progress)
    written = save_scene(options)
    if options.export_filaments:
        written += api.filament_export(bpy.data.objects[report["object"]], options.export_filaments)["files"]
    return Made(report, summary(report), written)
