# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``isolines`` of the command line: a pattern solved, and its lines made into curves or tubes."""

from dataclasses import asdict

import bpy

from ...core.errors import SettingError
from ...core.settings.lines import LineSettings
from ...core.settings.surface import SurfaceSettings
from .. import api
from ..blender import files
from ..jobs.report import summary
from ..patterns.lines import summary_line
from .flags import Made, add_choice, add_input, add_outputs, save_scene
from .settings import add_settings, settings_of


def add_parser(commands):
    """Add the command to the parser's."""
    command = commands.add_parser(
        "isolines",
        help="curves or tubes along stripes or quads",
        description="Solve stripes or quads on a mesh and make a curve object of their lines.",
    )
    add_input(command)
    add_choice(command, "--pattern", ("stripes", "quads"), "stripes", "whose lines")
    add_settings(command, SurfaceSettings, "isolines")
    add_settings(command, LineSettings, "isolines")
    add_outputs(command, "energies, bounds, defects, lines and times", "the tubes", "the tubes as a mesh")


def run(options, open_object, progress):
    """Run the command."""
    settings = settings_of(options, SurfaceSettings, assign_material=True)
    lines = settings_of(options, LineSettings)
    if lines.radius == 0 and (options.render or options.export_mesh):
        raise SettingError("lines without a radius have no faces to show or write: give --radius a part of the spacing")
    if lines.width and options.pattern == "quads":
        raise SettingError("quads are drawn by their grid lines, which have no width: leave --width out")
    files.check_outputs(options.output, options.render, options.report, mesh=options.export_mesh)
    obj = open_object()
    report = api.run(options.pattern, obj, settings, progress)
    made = api.isolines(obj, **asdict(lines))
    report |= {"command": "isolines", "pattern": options.pattern, "isolines": made}
    tubes, written = bpy.data.objects[made["object"]], []
    if options.export_mesh:
        _export(tubes, options.export_mesh)
        written.append(options.export_mesh)
    return Made(
        report, [*summary(report), summary_line(made)], written + save_scene(options), tubes, {"markers": False}
    )


def _export(tubes, path):
    """Write the tubes as a mesh, which not every exporter makes of a curve by itself."""
    evaluated = tubes.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = bpy.data.meshes.new_from_object(evaluated)
    copy = bpy.data.objects.new(tubes.name, mesh)
    copy.matrix_world = tubes.matrix_world
    bpy.context.scene.collection.objects.link(copy)
    files.export_mesh(copy, path)
    bpy.data.objects.remove(copy)
    bpy.data.meshes.remove(mesh)
