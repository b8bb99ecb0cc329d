# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line, inside Blender and from the bpy wheel.

    blender -b file.blend --command synch stripes --object Body --spacing 0.05 --output out.blend
    python -m synch_fields stripes mesh.obj --spacing 0.05 --output out.blend --render out.png --report out.json

Progress goes to stderr, nothing but the result to stdout. The exit status is 0 only when everything that
was asked for has been written; every failure is one line.
"""

import argparse
import io
import os
import sys
import time
from contextlib import redirect_stderr, suppress
from pathlib import Path

import bpy

from ...core.errors import SettingError, SynchError, WriteError, one_line
from ...core.files.declared import check_clashes, check_inputs, make_folders
from ...core.files.json_text import json_text
from ...core.files.whole import write_text
from ...core.interrupts import SIGNALLED, Interrupted, catch_interrupts, raise_interrupts, report_signal
from ...core.monitor import seconds_left
from ...core.settings.surface import SurfaceSettings
from ...core.validation import check_text
from .. import api
from ..blender import files
from ..blender.quiet import quiet_stdout
from ..jobs.report import failure, summary
from ..looks.demo import add_demo_object
from ..patterns.info import describe
from . import animate, bake, batch, clebsch, fields, layers, process_exit
from . import lines as cli_lines
from .declared_files import DEMO, declared_files
from .flags import Made, add_input, add_quiet, add_view, save_scene

# Errors that are reported in one line.
_REFUSALS = SynchError, MemoryError, OSError, RuntimeError


def main(arguments, loaded=False):
    """Run a command line; ``loaded`` if Blender has opened the file already. Returns the exit status."""
    process_exit.begin()
    parser = _parser(loaded)
    own, shared = _at_dashes(arguments)
    try:
        options = parser.parse_args(own)
    except SystemExit as stop:
        return stop.code or 0
    of_rows = batch.Way(lambda line: _parse_row(parser, line), declared_files, _carry_out_row)
    if options.command == "batch" and options.rows == "-":
        return _serve(of_rows)
    try:
        _check_files(options)
    except SettingError as error:
        print(f"synch {options.command}: {error}", file=sys.stderr)
        return 1
    with quiet_stdout() as out:
        try:
            with catch_interrupts():
                progress = _Progress(getattr(options, "quiet", True))
                if options.command == "batch":
                    made = batch.run(options, of_rows, shared, progress)
                else:
                    made = _carry_out(options, lambda: _open(options, loaded), progress)
        except Interrupted as stop:
            return report_signal(f"synch {options.command}", *stop.args)
        except _REFUSALS as error:
            print(f"synch {options.command}: {_reason(error)}", file=sys.stderr)
            return 1
        try:
            print("\n".join(_lines(made)), file=out, flush=True)
        except OSError as error:
            print(f"synch {options.command}: the result cannot be printed ({error.strerror})", file=sys.stderr)
            return 1
    if made.failed:
        print(f"synch {options.command}: {made.failed}", file=sys.stderr)
    return 1 if made.failed else 0


def _serve(of_rows):
    """Be a warm process until standard input is closed, or a signal comes; exit status."""
    try:
        with catch_interrupts():
            batch.serve(of_rows)
    except Interrupted as stop:
        return report_signal("synch batch", *stop.args)
    return 0


def _at_dashes(arguments):
    """Split a command line of ``batch`` at two dashes: its own arguments, and the command for its rows. Others stay
    whole."""
    if arguments[:1] != ["batch"] or "--" not in arguments:
        return arguments, []
    place = arguments.index("--")
    return arguments[:place], arguments[place + 1 :]


def _carry_out(options, open_object, progress):
    """Run a command and write its report and picture, if asked for; returns what was made, with the paths.

    Errors are SynchError; a report that is asked for has them, too.
    """
    declared = declared_files(options)
    try:
        with make_folders(declared):
            for name, value in vars(options).items():
                if isinstance(value, str):
                    check_text(value, f"the {name.replace('_', ' ')}")
            made = _COMMANDS[options.command](options, open_object, progress)
            raise_interrupts()
            return _write_outputs(made, options, progress)
    except _REFUSALS as error:
        raise SynchError(_report_error(options, declared, error)) from None


def _carry_out_row(options):
    """Carry a command out as a row of a batch; errors are SynchError."""
    with quiet_stdout(), catch_interrupts():
        return _carry_out(options, lambda: _open(options, False), _Progress(True))


def _parse_row(parser, arguments):
    """The options of a row; raises SettingError if they cannot be parsed."""
    messages = io.StringIO()
    try:
        with redirect_stderr(messages):
            options = parser.parse_args(arguments)
    except SystemExit:
        raise SettingError(" ".join(messages.getvalue().split()) or "this asks for help, not for a result") from None
    _check_files(options)
    return options


def _check_files(options):
    """Refuse files that would overwrite one another, and devices as inputs; a batch checks its own files."""
    if options.command != "batch":
        declared = declared_files(options)
        check_clashes(declared)
        check_inputs(declared)


def _reason(error):
    """An error as one line."""
    if isinstance(error, SynchError):
        return str(error)
    if isinstance(error, MemoryError):
        return "there is too little memory for this: allow more, or ask for less on a coarser mesh"
    if isinstance(error, OSError):
        return one_line(f"{error.filename or 'a file'}: {error.strerror or error}")
    return one_line(" ".join(str(error).split()))  # what an importer or exporter of Blender reports


def _report_error(options, declared, error):
    """Write an error into the report, if one is asked for, and return it as one line.

    If a file could not be written, older files stay, including an older report.
    """
    line = _reason(error)
    path = getattr(options, "report", None)
    is_kept = isinstance(error, WriteError) and path and os.path.exists(path)
    if path and Path(path).suffix.lower() == ".json" and not is_kept:  # no other file is overwritten with a report
        settings = {k: v for k, v in vars(options).items() if isinstance(v, str | int | float | None)}
        try:
            with make_folders(file for file in declared if file.flag == "--report"):
                _write_json(path, failure(options.command, settings, line))
        except SettingError as error:
            line += "" if path in line else f" (and no report: {error})"
    return line


def _write_outputs(made, options, progress):
    """Write the report and picture, if asked for; returns what was made, with the paths."""
    report, picture = (getattr(options, name, None) for name in ("report", "render"))
    if report:  # a picture may take minutes, and what was solved should not be lost with it
        _write_json(report, made.report)
    if picture:
        from ..looks.render import render_picture

        progress("rendering", 0.0)
        render_picture(made.shown, picture, view=options.view, **made.look)
    return made._replace(written=[*made.written, *(path for path in (picture, report) if path)])


def _lines(made):
    """The lines that a command prints about its results."""
    warnings = [f"warning: {line}" for line in made.report.get("warnings", ())]
    return map(one_line, [*made.lines, *warnings, *(f"wrote {path}" for path in made.written)])


# Commands


def _run_demo(options, _open_object, progress):
    for name, file in DEMO.items():
        setattr(options, name, str(Path(options.folder) / file))
    bpy.ops.wm.read_homefile(use_empty=True)
    obj = add_demo_object()
    report = api.run("stripes", obj, SurfaceSettings(), progress)
    return Made(report, summary(report), save_scene(options), obj)


def _run_info(options, open_object, _progress):
    files.check_outputs(report=options.report)
    report, lines = describe(open_object())
    return Made(report, lines, [])


_COMMANDS = dict.fromkeys(fields.COMMANDS, fields.run) | {
    "animate": animate.run,
    "bake": bake.run,
    "clebsch": clebsch.run,
    "demo": _run_demo,
    "info": _run_info,
    "isolines": cli_lines.run,
    "layers": layers.run,
}


def _open(options, loaded):
    if options.input:
        return files.open_object(options.input, options.object)
    if not loaded:
        raise SettingError("no input: name a .blend, .obj, .ply, .stl or .glb file")
    return files.choose_object(options.object)


class _Progress:
    """Prints how far a command is: in a terminal over what it printed before, elsewhere each line once.

    Parameters
    ----------
    is_quiet : nothing is printed
    """

    def __init__(self, is_quiet):
        self._is_quiet, self._last = is_quiet, ""
        self._start, self._expected = time.monotonic(), None

    def expect(self, seconds):
        """Tell in a terminal about how long it takes."""
        self._start, self._expected = time.monotonic(), seconds

    def __call__(self, stage, fraction):
        raise_interrupts()
        if self._is_quiet:
            return True
        line = f"{stage} {fraction:.0%}"
        if sys.stderr.isatty():
            left = seconds_left(time.monotonic() - self._start, fraction, self._expected)
            if left is not None and left >= 1:
                line += f", about {left:.0f} s left"
            print(f"\r{line:<60}", end="", file=sys.stderr, flush=True)
        elif line != self._last:
            print(line, file=sys.stderr)
        self._last = line
        return True


def _write_json(path, report):
    write_text(path, json_text(report, indent=2) + "\n")


# Parser


class _Parser(argparse.ArgumentParser):
    def error(self, message):
        self.exit(2, f"{self.prog}: {one_line(message)} (see --help)\n")


def _parser(loaded):
    parser = _Parser(
        prog="blender --command synch" if loaded else "python -m synch_fields",
        description="Stripes, quads and direction fields with a proved optimality gap.",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="command")
    fields.add_parsers(commands)
    for module in (cli_lines, animate, clebsch, layers, bake, batch):
        module.add_parser(commands)
    command = commands.add_parser("info", help="what a mesh can carry", description="Describe a mesh.")
    add_input(command)
    command.add_argument("--report", metavar="FILE.json", help="write the same as JSON")
    command = commands.add_parser("demo", help="stripes on Suzanne", description="Stripes on a remeshed Suzanne.")
    add_view(command)
    command.add_argument("--folder", default="out", help="where demo.blend, demo.png and demo.json go (%(default)s)")
    add_quiet(command)
    return parser


class _BlenderCommand:
    """The command that Blender runs for ``--command synch``."""

    def __init__(self):
        self._handle = None

    def register(self):
        self._handle = bpy.utils.register_cli_command("synch", self._run)

    def unregister(self):
        with suppress(ValueError):  # Blender has dropped it already, as it does at its end
            bpy.utils.unregister_cli_command(self._handle)

    @staticmethod
    def _run(arguments):
        status = main(arguments, loaded=True)
        if status > SIGNALLED:  # Blender's own end prints faults of the threads that a signal leaves running
            process_exit.leave(status)
        return status


blender_command = _BlenderCommand()
register, unregister = blender_command.register, blender_command.unregister
