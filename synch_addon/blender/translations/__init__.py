# SPDX-License-Identifier: GPL-3.0-or-later
"""Other languages of the interface: labels, tooltips, menus, what panels say, and why an operator cannot run.

Blender looks up labels and tooltips by itself; what is put together from parts goes through :func:`said`, and what core
and the jobs say, errors and warnings, through :func:`told` where a window shows it. In reports, in scripts and on the
command line that stays in English.
"""

import bpy
from bpy.app.translations import pgettext_iface

from ....core.errors import plural
from . import (
    german,
    german_built,
    german_drawing,
    german_layers,
    german_lists,
    german_messages_fields,
    german_messages_objects,
    german_messages_parts,
    german_messages_patterns,
    german_messages_shapes,
    german_presets,
)
from .messages import OURS, Sentences

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
# The same of errors and warnings, of which sentences have parts in braces, and of the words that may fill these.
MESSAGES = {
    "de_DE": german_messages_fields.FIELDS
    | german_messages_shapes.SHAPES
    | german_messages_objects.OBJECTS
    | german_messages_patterns.PATTERNS
    | german_messages_parts.PARTS
    | german_built.REASONS
}
WORDS = {"de_DE": german_messages_parts.WORDS}
_SENTENCES = Sentences({text for table in MESSAGES.values() for text in table}, set().union(*WORDS.values()))
# Labels of operators are looked up apart from everything else, and properties with a context of ours in that: Blender's
# own words go first elsewhere, and some mean something else.
_CONTEXTS = ("*", "Operator", OURS)


def said(text, **parts):
    """A text in the interface's language, with the parts filled in that it names in braces."""
    return pgettext_iface(text).format(**parts)


def counted(count, noun):
    """Such as "1 dislocation" or "2 dislocations", in the interface's language."""
    return f"{count} {pgettext_iface(noun if count == 1 else plural(noun))}"


def told(line):
    """An error or a warning in the interface's language; as it is where there is no sentence like it."""
    return _SENTENCES.told(line)


def register():
    tables = {
        language: {(OURS, text): other for text, other in (MESSAGES[language] | WORDS[language]).items()}
        | {(context, text): other for text, other in table.items() for context in _CONTEXTS}
        for language, table in LANGUAGES.items()
    }
    bpy.app.translations.register(__name__, tables)


def unregister():
    bpy.app.translations.unregister(__name__)
