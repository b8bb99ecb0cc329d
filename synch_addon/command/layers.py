# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``layers`` of the command line: layers in the solid of a mesh, or in a file of tetrahedra."""

from pathlib import Path

import bpy
import numpy as np

from ...core.files.obj_files import centre_of_far
from ...core.files.tets import SUFFIXES, read_marked_tets
from ...core.geometry.tet_mesh import TetMesh
from ...core.settings.layers import LayerSettings
from .. import api
from ..blender import files
from ..blender.new_geometry import new_mesh
from ..jobs.job import run as run_job
from ..solids.report import summary
from . import intake, layer_outputs
from .flags import Made, add_input, add_outputs, save_scene
from .settings import add_settings, settings_of


def add_parser(commands):
    """Add the command to the parser's."""
    command = commands.add_parser(
        "layers",
        help="evenly spaced layers in a solid",
        description="Solve layers in the solid that a closed mesh encloses, or in one of tetrahedra (.mesh, .vtu).",
    )
    add_input(command)
    command.add_argument(
        "--up", choices=intake.UPS, help="axis of a mesh file that is turned up; default: as the file is read"
    )
    add_settings(command, LayerSettings, "layers", smallest_height=None, largest_height=None)
    layer_outputs.add_arguments(command)
    add_outputs(command, "energies, spacings, curves and times", "the layers", "all layers as one mesh")


def run(options, open_object, progress):
    """Run the command."""
    settings = settings_of(options, LayerSettings, **layer_outputs.heights_of(options))
    files.check_outputs(options.output, options.render, options.report, mesh=options.export_mesh)
    layer_outputs.check(options)
    if options.input and Path(options.input).suffix.lower() in SUFFIXES:
        obj, solid = _open_solid(options.input)
    else:
        obj, solid = open_object(), None
    mended = []
    if solid is None and options.input and not options.input.lower().endswith(".blend"):
        if options.up:
            intake.turn_up(obj, options.up, options.input.lower().endswith(".glb"))
        mended = intake.mend(obj)
    report = run_job(api.layer_job(obj, settings, solid), progress)
    layers = bpy.data.objects[report["layers_object"]]
    # Before anything else can fail, and once more with the curves and the volume that exports make.
    written = save_scene(options)
    if options.export_mesh:
        files.export_mesh(layers, options.export_mesh, z_up=True)
        written.append(options.export_mesh)
    paths, warned, lines, facts = layer_outputs.write(options, obj)
    written += paths
    report["warnings"] = [*(f"{obj.name}: {line}" for line in mended), *report["warnings"], *warned]
    if facts is not None:
        report["print"] = facts
    if facts is not None or options.export_volume:
        save_scene(options)
    return Made(report, [*summary(report), *lines], written, layers)


def _open_solid(path):
    """An object of the boundary of a file's tetrahedra, in an empty scene, and the tetrahedra.

    Marks of the file's triangles become vertex groups. Far from the origin, the object is at the centre of the solid.
    """
    solid, marks = read_marked_tets(path)
    centre = centre_of_far(solid.vertices)
    if centre is not None:
        solid = TetMesh(solid.vertices - centre, solid.tets)
    bpy.ops.wm.read_homefile(use_empty=True)
    boundary, source = solid.boundary_surface
    name = Path(path).stem
    obj = bpy.data.objects.new(name, new_mesh(name, boundary.vertices, boundary.triangles, smooth=True))
    obj.location = (0, 0, 0) if centre is None else centre
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    for mark, triangles in marks.items():
        chosen = np.flatnonzero(np.isin(source, triangles))
        if 0 < len(chosen) < len(source):
            obj.vertex_groups.new(name=mark).add(chosen.tolist(), 1.0, "REPLACE")
    return obj, solid
