# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The interface in German: nothing of it is left out, and parts to be filled in are the same."""

import ast
import re
from pathlib import Path

import bpy
import pytest

from synch_fields.synch_addon.blender import translations
from synch_fields.synch_addon.operators.picking import PickingOperator

SOURCES = Path(translations.__file__).parents[2]
GERMAN = translations.LANGUAGES["de_DE"]
# Blender's own helpers bring labels of their own, which it translates itself.
BLENDERS = {
    "check_existing",
    "filepath",
    "align",
    "location",
    "rotation",
    "remove_name",
    "remove_active",
    "filter_glob",
}
# Internal, or about to be replaced by names.
UNSEEN = {"about", "finding"}
# What is shown by the parts of the interface that are held complete.
GROUPS = (
    "SynchSettings SynchOverlay SynchConstraint SynchGuide SynchBake SynchFavourite SynchAnimation SynchFlush "
    "SynchLayering SynchVortices SynchVortexLook SynchBrush SynchStrokes SynchLook SynchSimple"
).split()
OPERATORS = (
    "stripes quads directions quad_mesh trace_quads refine add_sample isolines bake animate variation draw_variation "
    "place_defect keep_favourite show_favourite remove_favourite select_defects next_defect copy_report cancel "
    "carry pin unpin select_places show_loop preset number_stripes asset_library "
    "import_field export_field add_preset constraint_add constraint_remove constraint_move guide_add guide_remove "
    "paint_map draw_stroke erase_strokes smooth_strokes "
    "layers layer_group_add layer_group_remove layer_export layer_toolpaths layer_path_export layer_volume "
    "clebsch best_vortices filament_export"
).split()


def texts_of(properties):
    for found in properties:
        if found.identifier in BLENDERS | UNSEEN | {"rna_type"}:
            continue
        yield from (found.name, found.description)
        if found.type == "ENUM":
            for item in found.enum_items:
                yield from (item.name, item.description)


def untranslated(texts):
    return sorted({text for text in texts if text and text not in GERMAN and not re.fullmatch("[XYZ]", text)})


@pytest.mark.parametrize("name", OPERATORS)
def test_operators_are_translated(name):
    rna = getattr(bpy.ops.synch, name).get_rna_type()
    texts = [rna.name, rna.description, *texts_of(rna.properties)]
    if name == "add_preset":
        texts = [rna.name, rna.description]
    assert untranslated(texts) == []


@pytest.mark.parametrize("name", GROUPS)
def test_settings_are_translated(name):
    (group,) = [cls for cls in bpy.types.PropertyGroup.__subclasses__() if cls.__name__ == name]
    own = [p for p in group.bl_rna.properties if p.identifier in _annotated(group) - {"name"}]
    assert own and untranslated(texts_of(own)) == []


def _annotated(cls):
    return {name for base in cls.__mro__ for name in getattr(base, "__annotations__", {})}


def test_panels_and_menus_are_translated():
    own = [getattr(bpy.types, name) for name in dir(bpy.types) if re.match("SYNCH_(PT|MT)_", name)]
    shown = [cls for cls in own if cls.__name__ in dict.fromkeys(_panels())]
    assert len(shown) >= 8
    assert untranslated(text for cls in shown for text in (cls.bl_label, cls.__doc__)) == []


def _panels():
    """Names of the panels and menus in the files that are held complete."""
    for path in sorted((SOURCES / "panels").glob("*.py")):
        yield from re.findall(r"class (SYNCH_\w+)", path.read_text(encoding="utf-8"))


def said_texts():
    """Every literal that the sources pass to said()."""
    for path in SOURCES.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "said":
                if isinstance(node.args[0], ast.Constant):
                    yield node.args[0].value


def test_what_is_put_together_is_translated():
    texts = list(said_texts())
    assert len(texts) > 15 and untranslated(texts) == []


def test_hints_in_the_status_bar_are_translated():
    hints = [cls.hint for cls in PickingOperator.__subclasses__()]
    assert len(hints) == 3 and all(hints) and untranslated(hints) == []


def test_menu_entries_are_translated():
    from synch_fields.synch_addon.panels.menus import _ENTRIES

    assert untranslated(text for group in _ENTRIES for _, text, _ in group) == []


@pytest.mark.parametrize("language", translations.LANGUAGES)
def test_parts_to_be_filled_in_are_the_same(language):
    for text, other in translations.LANGUAGES[language].items():
        assert other.strip() and re.findall("{[^}]*}", text) == re.findall("{[^}]*}", other), text
        assert text.endswith(":") == other.endswith(":") and not other.endswith("."), text


def test_words_that_blender_means_otherwise_are_looked_up_apart():
    """Blender's German for a boundary is of sounds."""
    stored = bpy.data.objects.new("Any", None).synch
    for group, name in ((stored, "boundary"), (stored.constraints.add(), "where")):
        assert group.bl_rna.properties[name].translation_context == translations.OURS in translations._CONTEXTS


def test_texts_are_filled_in(monkeypatch):
    assert translations.said("Energy {energy:.4g}", energy=2.5) == "Energy 2.5"
    assert translations.counted(1, "dislocation") == "1 dislocation"
    monkeypatch.setattr(translations, "pgettext_iface", GERMAN.get)
    assert translations.said("Energy {energy:.4g}", energy=2.5) == "Energie 2.5"
    assert [translations.counted(count, "vertex") for count in (0, 1, 2)] == ["0 Punkte", "1 Punkt", "2 Punkte"]


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
