# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything of Synch Fields that touches Blender; the mathematics is in ``core``."""

from . import (
    animation_panel,
    bake_panel,
    cli,
    constraint_list,
    constraint_panel,
    favourite_list,
    guide_list,
    guide_panel,
    jobs,
    layer_file_panel,
    layer_panel,
    layer_properties,
    memory,
    menus,
    operators,
    overlay_view,
    panels,
    preset_panel,
    preview,
    refine,
    result_panel,
    setting_presets,
    settings,
    translations,
    vortex_panel,
    vortex_settings,
)

_MODULES = (
    translations,
    constraint_list,
    guide_list,
    favourite_list,
    settings,
    layer_properties,
    memory,
    refine,
    vortex_settings,
    jobs,
    preview,
    operators,
    menus,
    setting_presets,
    guide_panel,
    panels,
    result_panel,
    preset_panel,
    constraint_panel,
    overlay_view,
    bake_panel,
    vortex_panel,
    layer_panel,
    animation_panel,
    layer_file_panel,
    cli,
)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    for module in reversed(_MODULES):
        module.unregister()
