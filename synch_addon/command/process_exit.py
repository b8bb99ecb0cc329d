# SPDX-License-Identifier: GPL-3.0-or-later
"""The only exit of the command line's processes, whatever ran in them.

Blender's own exit as a module waits for ever after a file with drivers, may abort while threads of what was interrupted
still run, and crashes where classes are left. Inside a Blender program that program ends the process itself, except
where a signal has interrupted a command.
"""

import atexit
import os
import shutil
import sys
from contextlib import suppress
from pathlib import Path

import bpy

from ...core.files.leftovers import mark, remove_own, sweep_marked

# Of the names of Blender's temporary folders.
_PREFIX = "blender_"


def begin():
    """Mark Blender's temporary folder as this process's, and remove the folders of our killed processes."""
    folder = Path(bpy.app.tempdir)
    if folder.name.startswith(_PREFIX):
        mark(folder)
        sweep_marked(folder.parent, _PREFIX)


def leave(status):
    """End this process after the exit handlers of other modules, such as one that saves test coverage."""
    with suppress(BaseException):  # what is raised there has been printed
        atexit._run_exitfuncs()
    leave_now(status)


def leave_now(status):
    """End this process at once, from any of its threads."""
    for stream in filter(None, (sys.stdout, sys.stderr)):
        with suppress(OSError, ValueError):
            stream.flush()
    shutil.rmtree(bpy.app.tempdir, ignore_errors=True)
    remove_own()
    os._exit(status)
