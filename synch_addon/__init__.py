# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything of Synch Fields that touches Blender; the mathematics is in ``core``.

Packages are rooms on floors: each imports from those below it only (docs/architecture.md).
"""

import atexit

import bpy

from . import operators, panels
from .blender import changes, left_defects, translations, undo_steps
from .blender.registration import Registration
from .command import main
from .flows import properties as flow_properties
from .jobs import lru_cache, queue
from .panels import simple
from .patterns import live
from .settings import constraint_list, favourite_list, fields, guide_list, painting, preferences, strokes
from .solids import properties as layer_properties

_MODULES = (
    translations,
    preferences,
    constraint_list,
    guide_list,
    favourite_list,
    fields,
    layer_properties,
    painting,
    strokes,
    simple,
    lru_cache,
    changes,
    left_defects,
    undo_steps,
    flow_properties,
    queue,
    live,
    operators,
    panels,
    main,
)


_registration = Registration(*((module.register, module.unregister) for module in _MODULES))


def register():
    _registration.register()
    if bpy.app.module:
        atexit.register(unregister)  # Blender as a module crashes at its exit where classes are left


def unregister():
    atexit.unregister(unregister)
    _registration.unregister()
