# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside the Blender under test: executes the commands that the tests put into its folder.

SYNCH_UI_FOLDER names the folder. A command is a file `command` with Python source, moved into place; `answer` gets
what the source leaves in the variable `answer`, or the traceback, as JSON.
"""

import hashlib
import json
import os
import sys
import time
import traceback

import blf
import bpy
import gpu
import numpy as np
from mathutils import Matrix, Vector

_FOLDER = os.environ["SYNCH_UI_FOLDER"]
_COMMAND, _ANSWER = (os.path.join(_FOLDER, name) for name in ("command", "answer"))
# Seconds to sleep without a command: Blender sleeps as long between events, but not where it simulates them.
_SLEEP = 0.005
_PARENT = os.getppid()

bpy.context.preferences.view.show_splash = False


def event(kind, value, x, y, **modifiers):
    """Put one event into the queue of the window."""
    bpy.context.window_manager.windows[0].event_simulate(type=kind, value=value, x=x, y=y, **modifiers)


def area():
    """The 3D view."""
    return next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")


def view():
    """What the 3D view looks from."""
    return area().spaces[0].region_3d


def region(kind):
    """x, y, width and height of a region of the 3D view."""
    found = next(region for region in area().regions if region.type == kind)
    return found.x, found.y, found.width, found.height


def window_region():
    """The region of the 3D view that the scene is drawn in."""
    return next(region for region in area().regions if region.type == "WINDOW")


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


def labels(text):
    """How the interface may show a text in its language: Blender looks labels of operators up apart from others."""
    return sorted({bpy.app.translations.pgettext(text, context) for context in ("*", "Operator", "Synch")})


def part(name):
    """A module of the extension, such as "jobs.queue"."""
    return sys.modules[f"bl_ext.user_default.synch_fields.synch_addon.{name}"]


def active():
    """The active object."""
    return bpy.context.view_layer.objects.active


def state():
    """All that an operator of the extension changes of the active object: two are equal only if nothing has changed."""
    obj = active()
    mesh = part("blender.pattern_surface").surface_of(obj).data
    return {
        "attributes": {attribute.name: _digest(attribute) for attribute in mesh.attributes},
        "materials": [material and material.name for material in mesh.materials],
        "children": sorted([child.name, *map(float, child.location)] for child in obj.children),
        "collections": sorted(collection.name for collection in bpy.data.collections),
        "result": obj.synch.result,
        "variation": obj.synch_shown.variation,
    }


def _digest(attribute):
    field = {"FLOAT_VECTOR": "vector", "FLOAT_COLOR": "color", "FLOAT2": "vector"}.get(attribute.data_type, "value")
    width = {"FLOAT_VECTOR": 3, "FLOAT_COLOR": 4, "FLOAT2": 2, "INT32_2D": 2, "INT16_2D": 2}.get(attribute.data_type, 1)
    values = np.zeros(len(attribute.data) * width, np.float32 if "FLOAT" in attribute.data_type else np.int32)
    attribute.data.foreach_get(field, values)
    return hashlib.sha1(values).hexdigest()


def pixel(point):
    """Where the 3D view shows a point of the scene: x and y in the window."""
    x, y, width, height = region("WINDOW")
    seen = view().perspective_matrix @ Vector((*point, 1.0))
    return [x + width * (1 + seen.x / seen.w) / 2, y + height * (1 + seen.y / seen.w) / 2]


def time_cancelling():
    """From now on, ``seconds`` gets how long a running job's operator takes to be gone once it hears of Esc."""
    operator = part("operators.field_operator").FieldOperator
    modal = operator.untimed = getattr(operator, "untimed", operator.modal)
    _scope["seconds"].clear()

    def timed(self, context, heard):
        start = time.monotonic()
        result = modal(self, context, heard)
        if heard.type == "ESC" and part("jobs.queue").queue.running is None:
            _scope["seconds"].append(time.monotonic() - start)
        return result

    operator.modal = timed


_scope = {"bpy": bpy, "os": os, "seconds": []}
_helpers = event, labels, area, view, region, window_region, drawn_text, part, active, state, pixel, time_cancelling
_scope |= {helper.__name__: helper for helper in _helpers}


def _poll():
    if os.getppid() != _PARENT:  # the tests were killed
        os._exit(1)
    if not os.path.exists(_COMMAND):
        time.sleep(_SLEEP)
        return 0
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
    return 0


bpy.app.timers.register(_poll, first_interval=0.5, persistent=True)
