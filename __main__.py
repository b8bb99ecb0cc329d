# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: python -m synch_fields."""

import os
import signal
import sys
import traceback
from importlib.util import find_spec
from pathlib import Path

try:
    import resource
except ImportError:  # Windows
    resource = None

# Bytes of address space below which Blender ends in a crash, or the first small mesh in an error. Most of it is never
# used.
LEAST_SPACE = 1.75 * 2**30


def run():
    """Run the command line and end this process.

    A signal that comes while Blender is imported is handled afterwards: an exception there could be lost, or crash it.
    """
    heard = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, _frame: heard.append(number))
    _open_what_is_closed()
    if not _has_blender() or not _has_space():
        sys.exit(1)
    _mark_temporary_folder()
    from . import register
    from .core.interrupts import report_signal
    from .synch_addon.command.main import main
    from .synch_addon.command.process_exit import leave

    status = 1
    try:
        register()  # a .blend keeps the object's constraints in properties of ours
        status = report_signal("synch", heard[0]) if heard else main(sys.argv[1:])
    except Exception:  # a fault of ours
        traceback.print_exc()
    finally:
        leave(status)


def _mark_temporary_folder():
    """Let a later process remove Blender's temporary folder, should this one be killed: before the second that the
    imports of ours take."""
    import bpy

    from .core.files.leftovers import mark

    mark(Path(bpy.app.tempdir))


def _has_blender():
    """Whether Blender's module is installed; a line says how to install it where it is not."""
    if find_spec("bpy") is not None:
        return True
    print('synch: Blender is missing: pip install "synch_fields[blender]", on Python 3.11 or 3.13', file=sys.stderr)
    return False


def _has_space():
    """Whether Blender can be loaded; a line says why not."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0] if resource else -1
    if limit < 0 or limit >= LEAST_SPACE:
        return True
    print(
        f"synch: the address space is limited to {limit / 2**30:.2g} GB and Blender needs {LEAST_SPACE / 2**30:.3g}: "
        "raise the limit (ulimit -v)",
        file=sys.stderr,
    )
    return False


def _open_what_is_closed():
    """Give a process without a stdin, stdout or stderr empty ones: files that Blender opens would take their places."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)


run()
