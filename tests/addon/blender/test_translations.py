# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The interface in other languages: each file is read whole, fits the interface, and Blender finds what it says.

A label without a translation is not an error: it stays English.
"""

import ast
import re
from pathlib import Path

import bpy
import pytest

from synch_fields.core.errors import plural
from synch_fields.synch_addon.blender import translations

ROOT = Path(translations.__file__).parents[2]
FILES = sorted(translations.LOCALE.glob("*.po"))
TABLES = {path.stem: translations.read_catalogue(path) for path in FILES}


@pytest.fixture(scope="module")
def interface():
    """Every text that the interface may show: those in the sources, their plurals, and what is registered."""
    texts = {path.stem.replace("_", " ") for path in (ROOT / "synch_addon/panels/shipped").rglob("*.py")}
    for folder in ("core", "synch_addon"):
        for path in (ROOT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Constant) and isinstance(node.value, str):
                    texts |= {node.value, plural(node.value)}
    groups = [
        cls.bl_rna for cls in bpy.types.PropertyGroup.__subclasses__() if cls.__module__.startswith("synch_fields")
    ]
    for rna in groups + [getattr(bpy.ops.synch, name).get_rna_type() for name in dir(bpy.ops.synch)]:
        for found in [rna, *rna.properties, *(item for p in rna.properties for item in getattr(p, "enum_items", ()))]:
            texts |= {found.name, found.description}
    return texts


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_no_entry_of_a_file_is_left_out(path):
    text = path.read_text(encoding="utf-8")
    entries = len(re.findall("^msgid ", text, re.MULTILINE))
    assert len(TABLES[path.stem]) == (entries - 1) * len(translations._CONTEXTS) > 1000  # the header is no text


@pytest.mark.parametrize("language", TABLES)
def test_texts_that_the_interface_no_longer_has_are_removed(language, interface):
    assert sorted({text for _, text in TABLES[language]} - interface) == []


@pytest.mark.parametrize("language", TABLES)
def test_parts_to_be_filled_in_are_the_same(language):
    for (_, text), other in TABLES[language].items():
        assert sorted(re.findall("{[^}]*}", text)) == sorted(re.findall("{[^}]*}", other)), text
        assert text.endswith(":") == other.endswith(":") and not other.endswith("."), text


def test_texts_on_several_lines_and_of_one_context_are_read(tmp_path):
    path = tmp_path / "xx.po"
    path.write_text(
        '# a note\nmsgid ""\nmsgstr "Language: xx\\n"\n\nmsgctxt "Operator"\nmsgid ""\n"two "\n"lines\\n"\n'
        'msgstr "\\"zwei\\""\n\nmsgid "not yet"\nmsgstr ""\n\n#, fuzzy\nmsgid "last"\nmsgstr "letzte"',
        encoding="utf-8",
    )
    last = {(context, "last"): "letzte" for context in translations._CONTEXTS}
    assert translations.read_catalogue(path) == {("Operator", "two lines\n"): '"zwei"'} | last


def test_words_that_blender_means_otherwise_are_looked_up_apart():
    """Blender's German for a boundary is of sounds, for to hold is to stop; layers are its own ones."""
    obj = bpy.data.objects.new("Any", None)
    assert bpy.types.SYNCH_PT_layers.bl_translation_context == translations.OURS
    for kind, name in (
        (obj.synch.bl_rna, "boundary"),
        (obj.synch.constraints.add().bl_rna, "where"),
        (obj.synch_animation.bl_rna, "hold"),
        (bpy.ops.synch.preset.get_rna_type(), "solve"),
    ):
        assert kind.properties[name].translation_context == translations.OURS in translations._CONTEXTS


def test_texts_are_filled_in(monkeypatch):
    german = {text: other for (_, text), other in TABLES["de"].items()}
    assert translations.translate("Energy {energy:.4g}", energy=2.5) == "Energy 2.5"
    assert translations.translate_count(1, "dislocation") == "1 dislocation"
    monkeypatch.setattr(translations, "pgettext_iface", german.get)
    assert translations.translate("Energy {energy:.4g}", energy=2.5) == "Energie 2.5"
    assert [translations.translate_count(count, "vertex") for count in (0, 1, 2)] == ["0 Punkte", "1 Punkt", "2 Punkte"]


@pytest.mark.skipif(not bpy.app.build_options.international, reason="this Blender has been built without languages")
def test_blender_finds_german_labels_while_the_extension_is_there():
    view, search = bpy.context.preferences.view, bpy.app.translations.pgettext
    before, view.language = view.language, "de_DE"
    try:
        assert search("Place Defects", "Operator") == "Defekte setzen"
        translations.unregister()
        assert search("Place Defects", "Operator") == "Place Defects"
        translations.register()
        assert search("Place Defects", "Operator") == "Defekte setzen"
    finally:
        view.language = before
