# SPDX-License-Identifier: GPL-3.0-or-later
"""Registering classes together with the settings that Blender's data keeps of them."""

import bpy
from bpy.props import PointerProperty


def register_all(classes, *kept):
    """The functions that register classes and take them out again.

    Parameters
    ----------
    classes : of bpy.types, a property group before what uses it
    kept : (owner, name, group) for each property group that data of a type keeps, such as bpy.types.Object
    """
    register_classes, unregister_classes = bpy.utils.register_classes_factory(classes)

    def register():
        register_classes()
        for owner, name, group in kept:
            setattr(owner, name, PointerProperty(type=group))

    def unregister():
        for owner, name, _ in reversed(kept):
            delattr(owner, name)
        unregister_classes()

    return register, unregister
