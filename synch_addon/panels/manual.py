# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of the manual that each button and setting has: *Online Manual* in its menu leads there."""

import bpy

from ..settings.preferences import manual_address

# Pages by names of operators, and by property groups, with single properties before the rest of theirs.
_OPERATORS = {
    "patterns": "stripes quads directions",
    "background": "cancel keep",
    "result": "variation draw_variation find_variations place_defect keep_favourite show_favourite remove_favourite "
    "select_defects next_defect drag_defect select_places copy_report pin unpin",
    "quads": "quad_mesh quad_mesh_again trace_quads",
    "overlay": "show_loop",
    "looks": "preset plain_look asset_library number_stripes",
    "lines": "isolines relief carry",
    "bake": "bake",
    "layers": "layers layer_group_add layer_group_remove",
    "printing": "layer_export layer_toolpaths layer_path_export layer_volume",
    "vortices": "clebsch best_vortices filament_export",
    "animation": "animate",
    "constraints": "constraint_add constraint_remove constraint_move",
    "guides": "draw_stroke erase_strokes smooth_strokes guide_add guide_remove import_field export_field",
    "settings": "paint_map done_painting",
    "comfort": "refine add_sample add_preset copy_settings",
}
_SETTINGS = {
    "synchsettings.constraints": "constraints",
    "synchsettings.active_constraint": "constraints",
    "synchsettings.favourites": "result",
    "synchsettings.result": "result",
    "synchsettings.guid*": "guides",
    "synchsettings.*": "settings",
    "synchbrush.*": "settings",
    "synchconstraint.*": "constraints",
    "synchguide.*": "guides",
    "synchlook.*": "looks",
    "synchstrokes.*": "guides",
    "synchfavourite.*": "result",
    "synchshown.*": "result",
    "synchoverlay.*": "overlay",
    "synchloop.*": "overlay",
    "synchbake.*": "bake",
    "synchanimation.*": "animation",
    "synchlayering.*": "layers",
    "synchflush.*": "layers",
    "synchvortices.*": "vortices",
    "synchvortexlook.*": "vortices",
    "synchsimple.*": "settings",
    "synchpreferences.panel": "settings",
    "synchpreferences.*": "background",
}
PAGES = (
    *((f"bpy.ops.synch.{name}", f"{page}.html") for page, names in _OPERATORS.items() for name in names.split()),
    *((f"bpy.types.{pattern}", f"{page}.html") for pattern, page in _SETTINGS.items()),
)


def pages():
    """What Blender asks for: the manual's address, and patterns of names with their pages; none without an address."""
    address = manual_address()
    return (address, PAGES) if address else ("", ())


def register():
    bpy.utils.register_manual_map(pages)


def unregister():
    bpy.utils.unregister_manual_map(pages)
