# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands of fields and patterns on a mesh: ``stripes``, ``quads``, ``quad_mesh`` and ``directions``."""

import bpy

from ...core.settings.surface import QUADS, SurfaceSettings
from .. import api
from ..blender import files
from ..blender.field_files import check_triangles
from ..blender.meshes import read_polygons
from ..jobs.report import summary
from .flags import Made, add_input, add_outputs, save_scene
from .settings import add_settings, settings_of

COMMANDS = {
    "stripes": "evenly spaced stripes along a direction field",
    "quads": "a pattern of quads along a cross field",
    "quad_mesh": "a mesh of quads along a cross field",
    "directions": "a direction field",
}


def add_parsers(commands):
    """Add the commands to the parser's."""
    for name, tip in COMMANDS.items():
        command = commands.add_parser(name, help=tip, description=f"Solve {tip} on a mesh.")
        add_input(command)
        add_settings(command, SurfaceSettings, name)
        makes_mesh = name == "quad_mesh"
        if not makes_mesh:  # which writes no directions on the mesh
            command.add_argument(
                "--export-field", metavar="FILE.rawfield", help="write the directions on triangles, also as .rosy"
            )
        quads = "the quads as a file" if makes_mesh else ""
        add_outputs(command, "energies, bounds, defects and times", "the result", quads)


def _cross(command):
    """The symmetry of quads, which have no flag for it."""
    return {"symmetry": "cross"} if command in QUADS else {}


def run(options, open_object, progress):
    """Run one of the commands."""
    settings = settings_of(options, SurfaceSettings, assign_material=True, **_cross(options.command))
    mesh, field = (getattr(options, name, None) for name in ("export_mesh", "export_field"))
    files.check_outputs(options.output, options.render, options.report, field, mesh)
    obj = open_object()
    if field:
        check_triangles(read_polygons(obj))
    report = api.run(options.command, obj, settings, progress)
    made = bpy.data.objects[report["quad_mesh"]["object"]] if "quad_mesh" in report else obj
    written = []
    if mesh:
        files.export_mesh(made, mesh)
        written.append(mesh)
    written += save_scene(options)
    if field:
        api.export_field(obj, field, settings.symmetry)
        written.append(field)
    return Made(report, summary(report), written, made, {"edges": "quad_mesh" in report})
