# SPDX-License-Identifier: GPL-3.0-or-later
"""Other languages of the interface: labels, tooltips, menus, what panels say, and why an operator cannot run.

Blender looks up labels and tooltips by itself; what is put together from parts goes through :func:`said`. Errors,
warnings and reports stay in English, which is what the command line writes too.
"""

import bpy
from bpy.app.translations import pgettext_iface

from ....core.errors import plural
from . import german, german_built, german_drawing, german_layers, german_lists, german_presets

# Blender's name of a language: a dict of the English text to the other.
LANGUAGES = {
    "de_DE": german.PANELS
    | german.OPERATORS
    | german.SETTINGS
    | german_lists.GUIDES
    | german_lists.CONSTRAINTS
    | german_lists.OVERLAY
    | german_lists.BAKE
    | german_lists.ANIMATION
    | german_lists.VORTICES
    | german_layers.LAYERS
    | german_drawing.DRAWING
    | german_presets.PRESETS
    | german_built.PARTS
    | german_built.REASONS
}
# Labels of operators are looked up apart from everything else, and properties with a context of ours in that: Blender's
# own words go first elsewhere, and some mean something else.
OURS = "Synch"
_CONTEXTS = ("*", "Operator", OURS)


def said(text, **parts):
    """A text in the interface's language, with the parts filled in that it names in braces."""
    return pgettext_iface(text).format(**parts)


def counted(count, noun):
    """Such as "1 dislocation" or "2 dislocations", in the interface's language."""
    return f"{count} {pgettext_iface(noun if count == 1 else plural(noun))}"


def register():
    tables = {
        language: {(context, text): other for text, other in table.items() for context in _CONTEXTS}
        for language, table in LANGUAGES.items()
    }
    bpy.app.translations.register(__name__, tables)


def unregister():
    bpy.app.translations.unregister(__name__)
