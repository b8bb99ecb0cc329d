# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes in another Blender without a window, so that this one's window stays free."""

import os
import sys
from contextlib import suppress
from pathlib import Path
from subprocess import DEVNULL

import bpy
import numpy as np

from ...core.errors import SynchError
from ...core.process.ipc import start_child

_PROGRAM = Path(__file__).with_name("cycles_bake.py")


class OtherProcess:
    """A bake that has begun elsewhere; on leaving the context, it ends.

    Parameters
    ----------
    scene : what is baked, see :func:`.cycles_bake.baked`; it is written to a file, and not needed any more
    folder : Path, for the files
    """

    def __init__(self, scene, kind, margin, folder):
        source, self._target = folder / "bake.blend", folder / "bake.npy"
        bpy.data.libraries.write(str(source), {scene}, path_remap="ABSOLUTE")
        with suppress(FileNotFoundError):
            self._target.unlink()
        given = [str(source), kind, str(margin), str(self._target)]
        try:
            self._child = start_child([*_command(), *given], dict(os.environ), pipes=DEVNULL)
        except OSError as error:
            raise SynchError(
                f"the process that bakes cannot be started: {error.strerror}: bake from a script"
            ) from None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._child.kill()
        self._child.wait()

    @property
    def is_running(self):
        """Whether it goes on."""
        return self._child.poll() is None

    def values(self):
        """What :func:`.cycles_bake.baked` returned there; SynchError if it failed."""
        try:
            return np.load(self._target)
        except (OSError, ValueError, EOFError):
            raise SynchError(
                f"the process that bakes ended without an image (code {self._child.returncode}): bake a smaller one, "
                "or bake from a script, which says why it fails"
            ) from None


def can_be_stored(scene):
    """Whether another process can read a scene from a file: a file lacks unsaved changes of images."""
    waiting, users, found = [image for image in bpy.data.images if image.is_dirty], bpy.data.user_map(), set()
    while waiting:
        block = waiting.pop()
        if block not in found:
            found.add(block)
            waiting += users.get(block, ())
    return scene not in found


def _command():
    """Command that starts the program, with Blender or with the Python that has it as a module."""
    if bpy.app.binary_path:
        options = ["--background", "--factory-startup", "--python-exit-code", "1", "--python", str(_PROGRAM), "--"]
        return [bpy.app.binary_path, *options]
    return [sys.executable, "-P", str(_PROGRAM)]  # no module of this folder in place of another
