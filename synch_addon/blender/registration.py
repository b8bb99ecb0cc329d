# SPDX-License-Identifier: GPL-3.0-or-later
"""Registering classes, settings that Blender's data keeps, and other parts: all of them or none, as often as called."""

from contextlib import ExitStack
from functools import partial

import bpy
from bpy.props import PointerProperty


class Registration:
    """Steps that register something, each with the step that takes it out again.

    Blender calls ``unregister`` of an extension twice where a script has asked for it at the end of the process, too;
    the second call does nothing, as does registering again. ``steps``: (register, unregister) pairs of functions
    without arguments.
    """

    def __init__(self, *steps):
        self._steps, self._undo = steps, None

    def register(self):
        """Take the steps in order; where one fails, those before it are undone and its error is raised."""
        if self._undo is not None:
            return
        with ExitStack() as undo:
            for register, unregister in self._steps:
                register()
                undo.callback(unregister)
            self._undo = undo.pop_all()

    def unregister(self):
        """Undo the steps, the last first; where one fails, the others are undone before its error is raised."""
        undo, self._undo = self._undo, None
        if undo is not None:
            undo.close()


def class_steps(*classes):
    """The steps that register classes of bpy.types."""
    return [(partial(bpy.utils.register_class, each), partial(bpy.utils.unregister_class, each)) for each in classes]


def register_handlers(*handlers):
    """The functions that add (list of bpy.app.handlers, function) pairs to these lists and take them out again."""
    steps = [(partial(event.append, handler), partial(event.remove, handler)) for event, handler in handlers]
    registration = Registration(*steps)
    return registration.register, registration.unregister


def register_all(classes, *kept):
    """The functions that register classes of bpy.types, a property group before what uses it, and take them out again.

    ``kept`` are (owner, name, group) for each property group that data of a type keeps, such as bpy.types.Object.
    """
    properties = [
        (partial(setattr, owner, name, PointerProperty(type=group)), partial(delattr, owner, name))
        for owner, name, group in kept
    ]
    registration = Registration(*class_steps(*classes), *properties)
    return registration.register, registration.unregister
