# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every button and every setting leads to a page of the manual that is there."""

from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest

from synch_fields.synch_addon.panels import manual
from synch_fields.synch_addon.settings import preferences

DOCS = Path(__file__).parents[3] / "docs"


def given(monkeypatch, text):
    """The preferences hold this address of the manual."""
    monkeypatch.setattr(preferences, "preferences", lambda: SimpleNamespace(manual=text))


def lookup(name):
    """Where Blender's own operator goes for a name as its menu has it; None where no map has it."""
    from bl_operators.wm import WM_OT_doc_view_manual, _wm_doc_get_id

    identifier = _wm_doc_get_id(name, do_url=False)
    if identifier is None and name.startswith("SynchPreferences."):  # older Blenders know none of add-ons' preferences
        identifier = f"bpy.types.{name}"
    return WM_OT_doc_view_manual._lookup_rna_url(identifier, verbose=False)


def settings():
    """Names of all properties of ours, as Blender's menu has them."""
    own = (*bpy.types.PropertyGroup.__subclasses__(), preferences.SynchPreferences)
    for group in own:
        if group.__name__.startswith("Synch"):
            for name in group.bl_rna.properties.keys():
                if name not in ("rna_type", "name", "bl_idname") and name in annotations(group):
                    yield f"{group.__name__}.{name}"


def annotations(group):
    return {name for base in group.__mro__ for name in getattr(base, "__annotations__", ())}


def test_every_operator_and_setting_has_a_page(monkeypatch):
    given(monkeypatch, "https://manual.example/synch")
    operators = [f"synch.{name}" for name in dir(bpy.ops.synch)]
    groups = list(settings())
    assert len(operators) > 30 and len(groups) > 80
    for name in (*operators, *groups):
        found = lookup(name) or ""
        assert found.startswith("https://manual.example/synch/"), name
        assert (DOCS / found.rpartition("/")[2].replace(".html", ".md")).exists(), found


def test_no_page_is_listed_for_what_is_not_there():
    operators = {f"bpy.ops.synch.{name}" for name in dir(bpy.ops.synch)}
    assert {pattern for pattern, _ in manual.PAGES if pattern.startswith("bpy.ops")} == operators
    groups = {f"bpy.types.{name.lower()}" for name in settings()}
    for pattern, _ in manual.PAGES:
        if pattern.startswith("bpy.types"):
            assert any(name.startswith(pattern.rstrip("*")) for name in groups), pattern


@pytest.mark.parametrize(
    "text, address",
    [
        ("", ""),
        ("  ", ""),
        ("https://manual.example/", "https://manual.example/"),
        ("/manual/site", "file:///manual/site/"),
    ],
)
def test_an_address_is_a_folder_or_of_the_web(monkeypatch, text, address):
    given(monkeypatch, text)
    assert preferences.manual_address() == address
    assert (lookup("synch.stripes") or "") == (f"{address}patterns.html" if address else "")


def test_the_map_goes_with_the_extension():
    assert manual.pages in [entry for entry in bpy.utils._manual_map]
    manual.unregister()
    assert manual.pages not in bpy.utils._manual_map
    manual.register()
