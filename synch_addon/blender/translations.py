# SPDX-License-Identifier: GPL-3.0-or-later
"""Other languages of the interface: labels, tooltips, menus, and what panels say.

Each file of ``synch_addon/locale`` holds one language in gettext's .po format and is named for it, such as ``de.po``.
A text without a translation stays English, as errors and warnings do everywhere. Blender looks up labels and tooltips
by itself; a text that is put together from parts goes through :func:`translate`.
"""

import json
import re
from pathlib import Path

import bpy
from bpy.app.translations import pgettext_iface, pgettext_rpt

from ...core.errors import plural

LOCALE = Path(__file__).parents[1] / "locale"
# The context of properties whose words Blender translates in another sense.
OURS = "Synch"
# Contexts of an entry without msgctxt: Blender looks up labels of operators in one of their own.
_CONTEXTS = ("*", "Operator", OURS)
# An entry of a .po file. Lines of a text follow one another, each in quotation marks.
_TEXT = r'((?:".*"\n)+)'
_ENTRY = re.compile(rf"^(?:msgctxt {_TEXT})?msgid {_TEXT}msgstr {_TEXT}", re.MULTILINE)


def translate(text, **parts):
    """A text in the interface's language, with the parts filled in that it names in braces."""
    return pgettext_iface(text).format(**parts)


def translate_count(count, noun):
    """Such as "1 dislocation" or "2 dislocations", in the interface's language."""
    return f"{count} {pgettext_iface(noun if count == 1 else plural(noun))}"


def operator_error(error):
    """The text of an error of one of Blender's operators, without "Error:" in the interface's language."""
    return str(error).strip().removeprefix(f"{pgettext_rpt('Error')}: ").strip()


def read_catalogue(path):
    """The translations in a .po file, by context and English text, as Blender takes them."""
    catalogue = {}
    for entry in _ENTRY.findall(path.read_text(encoding="utf-8") + "\n"):
        context, text, translation = ("".join(map(json.loads, lines.splitlines())) for lines in entry)
        if text and translation:  # an entry without a text is the file's header
            catalogue |= {(name, text): translation for name in ([context] if context else _CONTEXTS)}
    return catalogue


def register():
    catalogues = {path.stem: read_catalogue(path) for path in sorted(LOCALE.glob("*.po"))}
    bpy.app.translations.register(__name__, catalogues)


def unregister():
    bpy.app.translations.unregister(__name__)
