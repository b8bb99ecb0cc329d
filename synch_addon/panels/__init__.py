# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn in the window: sidebar, menus and overlay."""

from ..blender.registration import Registration
from . import (
    bakes,
    constraints,
    dots,
    early_view,
    frames,
    guides,
    jobs,
    layer_outputs,
    layers,
    look,
    manual,
    menus,
    overlay_view,
    presets,
    result,
    setting_presets,
    sidebar,
    solid_view,
    strokes,
    thumbnails,
    variation_slider,
    vortices,
)

# In the order in which they are drawn.
_MODULES = (
    variation_slider,
    menus,
    setting_presets,
    guides,
    sidebar,
    strokes,
    constraints,
    look,
    thumbnails,
    result,
    presets,
    solid_view,
    early_view,
    overlay_view,
    dots,
    bakes,
    vortices,
    layers,
    frames,
    layer_outputs,
    jobs,
    manual,
)


_registration = Registration(*((module.register, module.unregister) for module in _MODULES))
register, unregister = _registration.register, _registration.unregister
