# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``batch`` of the command line: many commands in warm processes of this machine or of a Dask cluster."""

import os
import re
import sys
import time
from contextlib import chdir
from pathlib import Path
from typing import NamedTuple

import bpy

from ...core.algebra.workers import MOST_WORKERS
from ...core.batch import child_loop
from ...core.batch.records import Records
from ...core.batch.rows import Row, read_rows, share_of
from ...core.batch.run import plan, run_rows
from ...core.batch.sheet import write_sheet
from ...core.batch.table import figures, write_tables
from ...core.errors import SettingError, SynchError
from ...core.files.whole import is_whole_image, write_whole
from ..jobs.report import count_text, versions
from .flags import Made, add_number, add_quiet
from .process_exit import leave_now

# Arguments of a Python that has Blender as a module that start a warm process.
_SERVE = "-m", __package__.removesuffix(".synch_addon.command"), "batch", "-"
# Pixels across a picture of the contact sheet, and its quality.
_SMALL, _QUALITY = 320, 82
# Flags that do not change what a row gives.
_UNSAID = "command", "quiet"


class Way(NamedTuple):
    """How one command line is understood and carried out, which all commands share.

    Attributes
    ----------
    parse : callable(arguments) -> options; raises SettingError
    files : callable(options) -> the :class:`DeclaredFile` of all that is read and written
    carry_out : callable(options) -> Made, its files written; raises SynchError
    """

    parse: object
    files: object
    carry_out: object


def add_parser(commands):
    """Add the command to the parser's."""
    command = commands.add_parser(
        "batch",
        help="many commands, by many processes",
        description="Run the commands of a JSON Lines file, or one for each file that a pattern matches: "
        "batch 'meshes/*.obj' -- stripes --render 'out/{stem}.png'. Rows that are done already are skipped.",
    )
    command.add_argument("rows", metavar="JOBS", help="file of rows, pattern of files, or - for a warm process's tasks")
    command.add_argument("--folder", help="of records, summary.csv, summary.json and sheet.html; default: out/NAME")
    add_number(command, "--jobs", os.cpu_count() or 1, "processes on this machine", "N")
    command.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster, which does the rows instead")
    add_number(command, "--threads", 1, f"of each solve, up to {MOST_WORKERS}", "N")
    add_number(command, "--retries", 1, "how often a row that fails is tried again", "N")
    command.add_argument(
        "--limit", type=float, metavar="SECONDS", help="after which a row has failed, its process's start included"
    )
    command.add_argument("--working-folder", default=".", metavar="FOLDER", help="that all paths start from")
    command.add_argument("--share", metavar="K/N", help="only the Kth of N parts, and no summary: for arrays of jobs")
    add_quiet(command)


def run(options, way, shared, progress):
    """Run the command; ``shared`` is what stands after two dashes."""
    with chdir(options.working_folder):
        return _run(options, way, shared, progress)


def _cluster(*arguments):
    """The :class:`Cluster` of a Dask scheduler; the packed extension, which uses no network, has no such module."""
    try:
        from ...core.batch.cluster import Cluster
    except ImportError:
        raise SettingError("the extension uses no network: run this from a checkout, or without --scheduler") from None
    return Cluster(*arguments)


def _run(options, way, shared, progress):
    """Run the rows that are not done, then write tables and the contact sheet, unless it is a share of a batch."""
    for name, least in (("jobs", 1), ("threads", 1), ("retries", 0)):
        if getattr(options, name) < least:
            raise SettingError(f"--{name} is {getattr(options, name)}: give a number from {least} on")
    if options.limit is not None and not options.limit > 0:
        raise SettingError(f"--limit is {options.limit:g}: give seconds above 0")
    started = time.monotonic()
    options.folder = options.folder or str(Path("out", _name(options.rows)))
    folder = Path(options.folder)
    own = way.files(options)
    rows = plan(read_rows(options.rows, shared), lambda line: _row_of(line, way), versions(), own)
    rows = share_of(rows, options.share) if options.share else rows
    records = Records(folder)
    records.make_folders()
    if options.scheduler:
        pool = _cluster(options.scheduler, _SERVE, options.threads)
    else:
        pool = child_loop.ProcessPool(_command(), options.jobs, options.threads)
    try:
        before, now = run_rows(rows, records, pool, options.retries, versions(), progress, options.limit)
    finally:
        pool.end()
    lines = [f"{count_text(len(rows), 'row')}: {now} done in {time.monotonic() - started:.1f} s, {before} before"]
    if options.share:
        return Made({}, lines, [])
    written, done = write_tables(folder, rows, records)
    sheet = folder / "sheet.html"
    write_sheet(sheet, f"{Path(options.rows).name}: {count_text(len(rows), 'row')}", rows, records)
    lost = f"{len(rows) - done} of {count_text(len(rows), 'row')} failed, see {written[0]}" if done < len(rows) else ""
    return Made({}, lines, [*written, str(sheet)], failed=lost)


def _name(rows):
    """Name of a batch, from its file or its pattern."""
    name = re.sub(r"[^\w.-]+", "_", Path(rows).stem).strip("_.")
    return f"{name or 'rows'}.batch"


def _command():
    """The command that starts a warm process."""
    if bpy.app.module:
        return [sys.executable, *_SERVE]
    return [bpy.app.binary_path, "--background", "--command", "synch", "batch", "-"]


def _row_of(arguments, way):
    """The :class:`Row` of a command line."""
    options = way.parse(arguments)
    if options.command == "batch":
        raise SettingError("a row cannot be a batch: write its rows here")
    shown = {name: value for name, value in vars(options).items() if name not in _UNSAID}
    return Row(tuple(arguments), shown, tuple(way.files(options)))


# The other side


def serve(way):
    """Carry out rows that come by standard input, until it is closed."""
    child_loop.serve(lambda task: _answer(task, way), leave_now)


def _answer(task, way):
    """Do a task; returns {}, or why it failed."""
    try:
        here = versions()
        for name, wanted in task["versions"].items():
            found = here.get(name)
            if found != wanted:
                raise SettingError(f"{name} is {found} here and {wanted} where the batch began: install the same")
        os.chdir(task["working_folder"])
        records = Records(task["folder"])
        if records.done(task["key"]) is None:
            _do(task, way, records)
        return {}
    except SynchError as error:
        return {"failed": str(error)}
    except OSError as error:
        return {"failed": f"{error.filename or 'a file'}: {error.strerror or error}"}
    except Exception as error:  # a bug of ours is reported too, and the other rows continue
        return {"failed": f"{type(error).__name__}: {' '.join(str(error).split())}"}


def _do(task, way, records):
    started = time.monotonic()
    options = way.parse(task["arguments"])
    made = way.carry_out(options)
    picture = getattr(options, "render", None)
    if picture:
        _make_small(picture, records.thumbnail(task["key"]))
    records.keep_done(task["key"], figures(made.report, time.monotonic() - started), made.written)


def _make_small(picture, path):
    image = bpy.data.images.load(str(Path(picture).resolve()))
    try:
        image.scale(_SMALL, max(round(_SMALL * image.size[1] / image.size[0]), 1))
        image.file_format = "JPEG"
        with write_whole(path, is_whole_image) as made:
            image.save(filepath=str(made), quality=_QUALITY)
    finally:
        bpy.data.images.remove(image)
