# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything of Synch Fields that touches Blender; the mathematics is in ``core``."""

from . import operators
from .blender import translations
from .command import main
from .flows import properties as vortex_settings
from .jobs import jobs
from .panels import (
    bakes,
    constraints,
    frames,
    guides,
    layer_outputs,
    layers,
    menus,
    overlay_view,
    presets,
    result,
    setting_presets,
    sidebar,
    vortices,
)
from .patterns import memory, preview, refine
from .settings import constraint_list, favourite_list, fields, guide_list
from .solids import properties

_MODULES = (
    translations,
    constraint_list,
    guide_list,
    favourite_list,
    fields,
    properties,
    memory,
    refine,
    vortex_settings,
    jobs,
    preview,
    operators,
    menus,
    setting_presets,
    guides,
    sidebar,
    result,
    presets,
    constraints,
    overlay_view,
    bakes,
    vortices,
    layers,
    frames,
    layer_outputs,
    main,
)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    for module in reversed(_MODULES):
        module.unregister()
