# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``layers`` of the command line: layers in the solid of a mesh, or in a file of tetrahedra."""

from pathlib import Path

import bpy

from ..core.tet_files import read_tets
from . import api, cli_layer_files, files
from .layer_report import summary
from .layer_settings import KINDS, WISHES, LayerSettings

_DEFAULT = LayerSettings()
SOLID_SUFFIXES = (".mesh", ".vtu")


def add_parser(commands, add_input, add_view):
    """Add the command to the parser's."""
    command = commands.add_parser(
        "layers",
        help="evenly spaced layers in a solid",
        description="Solve layers in the solid that a closed mesh encloses, or in one of tetrahedra (.mesh, .vtu).",
    )
    add_input(command)
    command.add_argument(
        "--guidance",
        default=_DEFAULT.guidance,
        metavar="KIND:NAME",
        help=f"what the layers follow; kinds: {', '.join(KINDS)}; harmonic:LOW:HIGH (%(default)s)",
    )
    command.add_argument(
        "--groups",
        default=_DEFAULT.groups,
        metavar="NAME=WISH,...",
        help=f"what is asked on vertex groups' faces or on the boundary: {' or '.join(WISHES)}",
    )
    command.add_argument("--spacing", type=float, metavar="LENGTH", help="between layers; default: automatic")
    command.add_argument(
        "--spacing-map",
        default="",
        metavar="NAME",
        help="float attribute, a factor on the spacing, or vertex group, which takes it from 1 to the range",
    )
    command.add_argument(
        "--spacing-range",
        type=float,
        default=_DEFAULT.spacing_range,
        metavar="X",
        help="factor where the vertex group's weight is 1 (%(default)s)",
    )
    command.add_argument(
        "--size", type=float, metavar="LENGTH", help="longest edge of the tetrahedra; default: automatic"
    )
    command.add_argument("--method", choices=("sdp", "spectral", "diffusion"), default=_DEFAULT.method)
    command.add_argument("--seed", type=int, default=_DEFAULT.seed)
    command.add_argument("--target-gap", type=float, default=_DEFAULT.target_gap, metavar="X")
    command.add_argument("--time-limit", type=float, metavar="SECONDS")
    command.add_argument("--output", metavar="FILE.blend", help="save the scene with the result")
    suffixes = ", ".join(files.MESH_SUFFIXES)
    command.add_argument("--export-mesh", metavar="FILE.stl", help=f"write all layers as one mesh ({suffixes})")
    cli_layer_files.add_arguments(command)
    command.add_argument("--render", metavar="FILE.png", help="render a picture of the layers")
    add_view(command)
    command.add_argument("--report", metavar="FILE.json", help="write energies, spacings, curves and times")
    command.add_argument("--quiet", action="store_true", help="no progress on stderr")


def run(options, open_object, progress):
    """Run the command; the report and the lines to print."""
    settings = LayerSettings(**{name: getattr(options, name) for name in LayerSettings.__dataclass_fields__})
    files.check_outputs(options.output, options.render, options.report, mesh=options.export_mesh)
    cli_layer_files.check(options)
    if options.input and Path(options.input).suffix.lower() in SOLID_SUFFIXES:
        obj, solid = _open_solid(options.input)
    else:
        obj, solid = open_object(), None
    job = api.layer_job(obj, settings, solid)
    job.solve(progress)
    report = job.write(obj)
    layers, written = bpy.data.objects[report["layers_object"]], []
    # Before anything else can fail, and once more with the curves and the volume that exports make.
    if options.output:
        written.append(files.save_blend(options.output))
    if options.export_mesh:
        files.export_mesh(layers, options.export_mesh, z_up=True)
        written.append(options.export_mesh)
    paths, warned = cli_layer_files.write(options, obj)
    written += paths
    report["warnings"] += warned
    if options.output and (options.export_paths or options.export_volume):
        files.save_blend(options.output)
    if options.render:
        from .render import render_picture

        written.append(render_picture(layers, options.render, view=options.view))
    written += [options.report] if options.report else []
    warnings = [f"warning: {line}" for line in report["warnings"]]
    return report, summary(report) + warnings + [f"wrote {path}" for path in written]


def _open_solid(path):
    """An object of the boundary of the tetrahedra in a file, in an empty scene, and these."""
    solid = read_tets(path)
    bpy.ops.wm.read_homefile(use_empty=True)
    boundary, _ = solid.boundary_surface
    name = Path(path).stem
    data = bpy.data.meshes.new(name)
    data.from_pydata(boundary.vertices.tolist(), [], boundary.triangles.tolist())
    data.shade_smooth()
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    return obj, solid
