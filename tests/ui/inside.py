# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside the Blender under test: executes the commands that the tests put into its folder.

SYNCH_UI_FOLDER names the folder. A command is a file `command` with Python source, moved into place; `answer` gets
what the source leaves in the variable `answer`, or the traceback, as JSON.
"""

import json
import os
import traceback

import blf
import bpy
import gpu
import numpy as np
from mathutils import Matrix

_FOLDER = os.environ["SYNCH_UI_FOLDER"]
_COMMAND, _ANSWER = (os.path.join(_FOLDER, name) for name in ("command", "answer"))
# Seconds between two looks for a command.
_PERIOD = 0.02

bpy.context.preferences.view.show_splash = False


def event(kind, value, x, y, **modifiers):
    """Put one event into the queue of the window."""
    bpy.context.window_manager.windows[0].event_simulate(type=kind, value=value, x=x, y=y, **modifiers)


def region(kind):
    """x, y, width and height of a region of the 3D view."""
    area = next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")
    found = next(region for region in area.regions if region.type == kind)
    return found.x, found.y, found.width, found.height


def drawn_text(text, points):
    """A text in the font of the interface, rows from the top, 0 to 255."""
    blf.size(0, points * bpy.context.preferences.system.ui_scale)
    width, height = (int(np.ceil(side)) for side in blf.dimensions(0, text))
    width, height, below = width + 4, height + 8, 5
    target = gpu.types.GPUOffScreen(width, height)
    with target.bind():
        frame = gpu.state.active_framebuffer_get()
        frame.clear(color=(0, 0, 0, 1))
        with gpu.matrix.push_pop_projection(), gpu.matrix.push_pop():
            gpu.matrix.load_identity()
            gpu.matrix.load_projection_matrix(
                Matrix(((2 / width, 0, 0, -1), (0, 2 / height, 0, -1), (0, 0, 1, 0), (0, 0, 0, 1)))
            )
            blf.color(0, 1, 1, 1, 1)
            blf.position(0, 2, below, 0)
            blf.draw(0, text)
        pixels = frame.read_color(0, 0, width, height, 4, 0, "UBYTE")
    pixels.dimensions = width * height * 4
    target.free()
    return np.array(pixels, np.uint8).reshape(height, width, 4)[::-1, :, 0].tolist()


_scope = {"bpy": bpy, "event": event, "region": region, "drawn_text": drawn_text}


def _poll():
    if not os.path.exists(_COMMAND):
        return _PERIOD
    with open(_COMMAND) as file:
        source = file.read()
    os.remove(_COMMAND)
    _scope["answer"] = None
    try:
        exec(compile(source, "command", "exec"), _scope)
        result = {"answer": _scope["answer"]}
    except BaseException:
        result = {"error": traceback.format_exc()}
    with open(_ANSWER + ".part", "w") as file:
        json.dump(result, file)
    os.rename(_ANSWER + ".part", _ANSWER)
    return _PERIOD


bpy.app.timers.register(_poll, first_interval=0.5, persistent=True)
