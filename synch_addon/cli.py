# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line, inside Blender and from the bpy wheel.

    blender -b file.blend --command synch stripes --object Body --spacing 0.05 --output out.blend
    python -m synch_fields stripes mesh.obj --spacing 0.05 --output out.blend --render out.png --report out.json

Progress goes to stderr, nothing but the result to stdout. The exit status is 0 only when everything that
was asked for has been written; every failure is one line.
"""

import argparse
import json
import math
import sys
from pathlib import Path

import bpy

from ..core.errors import SettingError, SynchError
from . import api, cli_animate, cli_bake, cli_clebsch, cli_layers, cli_lines, files
from .constraints import from_plain
from .demo import add_demo_object
from .field_io import check_triangles
from .guidance import KINDS
from .info import describe
from .quiet import quiet_stdout
from .report import failure, summary
from .scene_io import read_polygons
from .settings import BOUNDARIES, METHODS, SYMMETRIES, Settings

_command = None


def main(arguments, loaded=False):
    """Run a command line; ``loaded`` tells that Blender has opened the file already. Exit status."""
    parser = _parser(loaded)
    try:
        options = parser.parse_args(arguments)
    except SystemExit as stop:
        return stop.code or 0
    with quiet_stdout() as out:
        try:
            report, lines = _COMMANDS[options.command](options, loaded)
            if getattr(options, "report", None):
                _write_json(options.report, report)
        except SynchError as error:
            return _fail(options, str(error))
        except OSError as error:
            return _fail(options, f"{error.filename or 'a file'}: {error.strerror or error}")
        except RuntimeError as error:  # what an importer or exporter of Blender reports
            return _fail(options, " ".join(str(error).split()))
        print("\n".join(lines), file=out)
    return 0


def _fail(options, line):
    path = getattr(options, "report", None)
    if path and files.is_report(path):
        settings = {k: v for k, v in vars(options).items() if isinstance(v, str | int | float | None)}
        try:
            _write_json(path, failure(options.command, settings, line))
        except OSError as error:
            line += "" if path in line else f" (and no report: {path}: {error.strerror})"
    print(f"synch {options.command}: {line}", file=sys.stderr)
    return 1


# Commands


def _run_field(options, loaded):
    settings = _settings(options)
    export_mesh = getattr(options, "export_mesh", None)
    export_field = getattr(options, "export_field", None)
    files.check_outputs(options.output, options.render, options.report, export_field, export_mesh)
    obj = _open(options, loaded)
    if export_field:
        check_triangles(read_polygons(obj))
    report = api.run(options.command, obj, settings, None if options.quiet else _show_progress)
    made = bpy.data.objects[report["quad_mesh"]["object"]] if "quad_mesh" in report else obj
    if export_mesh:
        files.export_mesh(made, export_mesh)
    return _deliver(obj, made, report, options)


def _run_demo(options, loaded):
    folder = Path(options.folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name, suffix in (("output", ".blend"), ("render", ".png"), ("report", ".json")):
        setattr(options, name, str(folder / f"demo{suffix}"))
    bpy.ops.wm.read_homefile(use_empty=True)
    obj = add_demo_object()
    report = api.run("stripes", obj, Settings(symmetry="line"), None if options.quiet else _show_progress)
    return _deliver(obj, obj, report, options)


def _run_info(options, loaded):
    files.check_outputs(report=options.report)
    return describe(_open(options, loaded))


def _run_clebsch(options, _loaded):
    return cli_clebsch.run(options, None if options.quiet else _show_progress)


def _run_bake(options, loaded):
    return cli_bake.run(options, lambda: _open(options, loaded), None if options.quiet else _show_progress)


def _run_isolines(options, loaded):
    progress = None if options.quiet else _show_progress
    return cli_lines.run(options, lambda: _open(options, loaded), _settings(options), progress)


def _run_layers(options, loaded):
    return cli_layers.run(options, lambda: _open(options, loaded), None if options.quiet else _show_progress)


def _run_animate(options, loaded):
    progress = None if options.quiet else _show_progress
    return cli_animate.run(options, lambda: _open(options, loaded), _settings(options), progress)


_FIELDS = ("stripes", "directions", "quads", "quad_mesh")
_OTHERS = {
    "animate": _run_animate,
    "bake": _run_bake,
    "clebsch": _run_clebsch,
    "demo": _run_demo,
    "info": _run_info,
    "isolines": _run_isolines,
    "layers": _run_layers,
}
_COMMANDS = dict.fromkeys(_FIELDS, _run_field) | _OTHERS


def _open(options, loaded):
    if options.input:
        files.open_input(options.input)
    elif not loaded:
        raise SettingError("no input: name a .blend, .obj, .ply, .stl or .glb file")
    return files.choose_object(options.object)


def _deliver(obj, shown, report, options):
    """What was asked for goes to files, with a picture of the object that shows the result."""
    written = [options.export_mesh] if getattr(options, "export_mesh", None) else []
    if options.output:
        written.append(files.save_blend(options.output))
    if options.report:  # a picture may take minutes, and what was solved should not be lost with it
        _write_json(options.report, report)
    if options.render:
        from .render import render_picture

        if not options.quiet:
            _show_progress("rendering", 0.0)

        render_picture(shown, options.render, view=options.view, edges="quad_mesh" in report)
        written.append(options.render)
    if getattr(options, "export_field", None):
        api.export_field(obj, options.export_field, getattr(options, "symmetry", "cross"))
        written.append(options.export_field)
    if options.report:
        written.append(options.report)
    warnings = [f"warning: {line}" for line in report["warnings"]]
    return report, summary(report) + warnings + [f"wrote {path}" for path in written]


def _settings(options):
    if options.vertex_group and options.boundary == "free":
        raise SettingError(
            f"the vertex group {options.vertex_group!r} restricts the boundary, which is free: "
            "add --boundary along, across or phase"
        )
    return Settings(
        symmetry=getattr(options, "symmetry", "cross"),
        guidance=options.guidance,
        angle=math.radians(options.angle),
        angle_attribute=options.angle_attribute,
        boundary=options.boundary,
        vertex_group=options.vertex_group,
        mirror=options.mirror.upper(),
        constraints=_read_constraints(options.constraints) if options.constraints else None,
        **_spacing(options),
        method=options.method,
        seed=options.seed,
        target_gap=options.target_gap,
        time_limit=options.time_limit,
        assign_material=True,
    )


def _spacing(options):
    """The settings that only some commands have."""
    if options.command == "directions":
        return {}
    if options.spacing_range is not None and not options.spacing_map:
        raise SettingError("the spacing range belongs to a spacing map: add --spacing-map NAME")
    factor = Settings().spacing_range if options.spacing_range is None else options.spacing_range
    more = {name: getattr(options, name) for name in ("aspect", "smoothing") if hasattr(options, name)}
    return {"spacing": options.spacing, "spacing_map": options.spacing_map, "spacing_range": factor} | more


def _read_constraints(path):
    try:
        return from_plain(json.loads(Path(path).read_text(encoding="utf-8")))
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise SettingError(f"{path}: {error}: write a JSON list of rows") from None
    except SettingError as error:
        raise SettingError(f"{path}: {error}") from None


def _show_progress(stage, fraction):
    line = f"{stage} {fraction:.0%}"
    if sys.stderr.isatty():
        print(f"\r{line:<40}", end="", file=sys.stderr, flush=True)
    elif line != _show_progress.last:
        print(line, file=sys.stderr)
    _show_progress.last = line
    return True


_show_progress.last = ""


def _write_json(path, report):
    Path(path).write_text(json.dumps(report, indent=2) + "\n")


# Parser


class _Parser(argparse.ArgumentParser):
    def error(self, message):
        self.exit(2, f"{self.prog}: {message} (see --help)\n")


def _parser(loaded):
    parser = _Parser(
        prog="blender --command synch" if loaded else "python -m synch_fields",
        description="Stripes, quads and direction fields with a proved optimality gap.",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="command")
    for name, tip in (
        ("stripes", "evenly spaced stripes along a direction field"),
        ("quads", "a pattern of quads along a cross field"),
        ("quad_mesh", "a mesh of quads along a cross field"),
        ("directions", "a direction field"),
    ):
        command = commands.add_parser(name, help=tip, description=f"Solve {tip} on a mesh.")
        _add_input(command)
        _add_settings(command, name)
        command.add_argument("--output", metavar="FILE.blend", help="save the scene with the result")
        command.add_argument("--render", metavar="FILE.png", help="render a picture of the result")
        _add_view(command)
        command.add_argument("--report", metavar="FILE.json", help="write energies, bounds, defects and times")
        if name != "quad_mesh":  # which writes no directions on the mesh
            command.add_argument(
                "--export-field", metavar="FILE.rawfield", help="write the directions on triangles, also as .rosy"
            )
        if name == "quad_mesh":
            suffixes = ", ".join(files.MESH_SUFFIXES)
            command.add_argument("--export-mesh", metavar="FILE.obj", help=f"write the quads as a file ({suffixes})")
        command.add_argument("--quiet", action="store_true", help="no progress on stderr")
    cli_lines.add_parser(commands, _add_input, _add_settings, _add_view)
    cli_animate.add_parser(commands, _add_input, _add_settings)
    cli_clebsch.add_parser(commands)
    cli_layers.add_parser(commands, _add_input, _add_view)
    cli_bake.add_parser(commands, _add_input)
    command = commands.add_parser("info", help="what a mesh can carry", description="Describe a mesh.")
    _add_input(command)
    command.add_argument("--report", metavar="FILE.json", help="write the same as JSON")
    command = commands.add_parser("demo", help="stripes on Suzanne", description="Stripes on a remeshed Suzanne.")
    _add_view(command)
    command.add_argument("--folder", default="out", help="where demo.blend, demo.png and demo.json go (%(default)s)")
    command.add_argument("--quiet", action="store_true", help="no progress on stderr")
    return parser


def _add_input(command):
    command.add_argument("input", nargs="?", help=".blend, .obj, .ply, .stl or .glb; default: the file that is open")
    command.add_argument("--object", metavar="NAME", help="which mesh object, where the file has several")


def _add_view(command):
    command.add_argument(
        "--view",
        nargs=2,
        type=float,
        default=(-25.0, 14.0),
        metavar=("AZIMUTH", "ELEVATION"),
        help="where the picture is taken from, degrees from the front view (default: -25 14)",
    )


def _add_settings(command, name):
    default = Settings()
    of_quads = name in ("quads", "quad_mesh")
    if name != "directions":
        what = "two quads' length" if of_quads else "between stripes"
        command.add_argument("--spacing", type=float, metavar="LENGTH", help=f"{what}; default: automatic")
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
            help=f"factor where the vertex group's weight is 1 ({default.spacing_range:g})",
        )
    if of_quads:
        command.add_argument(
            "--aspect",
            type=float,
            default=default.aspect,
            metavar="X",
            help="spacing along the second direction over that along the first, which is nearer to X (%(default)s)",
        )
    else:
        command.add_argument(
            "--symmetry",
            choices=tuple(SYMMETRIES),
            default=default.symmetry,
            help="what is the same at a point; cross for directions only (%(default)s)",
        )
    if name == "quad_mesh":
        command.add_argument(
            "--smoothing",
            type=int,
            default=default.smoothing,
            metavar="N",
            help="how often vertices move to the middle of their neighbours on the surface (%(default)s)",
        )
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
        "--angle-attribute", default="", metavar="NAME", help="float attribute, radians from vertex to vertex on top"
    )
    command.add_argument(
        "--boundary",
        choices=BOUNDARIES,
        default=default.boundary,
        help="what directions do at open edges; phase: a line lies exactly on them (%(default)s)",
    )
    command.add_argument("--vertex-group", default="", metavar="NAME", help="restrict the boundary to this group")
    command.add_argument(
        "--mirror", default="", metavar="AXES", help="X, Y, Z or several: the result is its own mirror image in them"
    )
    command.add_argument(
        "--constraints", metavar="ROWS.json", help="a list of rows; default: the list stored with the object"
    )
    command.add_argument(
        "--method", choices=METHODS, default=default.method, help="sdp proves a bound, spectral is fast (%(default)s)"
    )
    command.add_argument("--seed", type=int, default=default.seed, help="of every random choice (%(default)s)")
    command.add_argument(
        "--target-gap",
        type=float,
        default=default.target_gap,
        metavar="X",
        help="how closely the relaxation's optimum is bracketed (%(default)s)",
    )
    command.add_argument("--time-limit", type=float, metavar="SECONDS", help="for each solve")


def register():
    global _command
    _command = bpy.utils.register_cli_command("synch", lambda arguments: main(arguments, loaded=True))


def unregister():
    bpy.utils.unregister_cli_command(_command)
