# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Menus and presets: every entry is an operator that says what it does, and why it cannot be run where it cannot."""

import ast
from pathlib import Path

import bpy
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.panels import menus, setting_presets
from synch_fields.synch_addon.settings.fields import STORED_NAMES
from synch_fields.synch_addon.settings.guide_list import stored_guidance

from ..scenes import sphere, tube

# Settings that Blender's own helpers give to an operator.
_BLENDERS = {"rna_type", "align", "location", "rotation", "check_existing", "name"}
PRESETS = sorted((Path(menus.__file__).parent / "shipped" / "presets" / setting_presets.FOLDER).glob("*.py"))


@pytest.fixture(autouse=True)
def labels(monkeypatch):
    """Blender calls the presets by the one that was used last."""
    panel = setting_presets.SYNCH_PT_presets
    monkeypatch.setattr(panel, "bl_label", panel.bl_label)


class Layout:
    """Collects what a menu draws."""

    def __init__(self):
        self.operators, self.menus, self.shapes = [], [], []

    def operator(self, name, **_):
        self.operators.append(name)
        self.shapes.append(self)
        return self

    def menu(self, name, **_):
        self.menus.append(name)

    def separator(self):
        pass


class Menu:
    def __init__(self):
        self.layout = Layout()


def described(name):
    """What Blender knows of an operator."""
    return getattr(bpy.ops.synch, name.removeprefix("synch.")).get_rna_type()


def test_every_entry_of_the_object_menu_is_an_operator_with_a_tooltip():
    menu = Menu()
    menus.SYNCH_MT_object.draw(menu, bpy.context)
    assert len(menu.layout.operators) > 10 and menu.layout.operator_context == "INVOKE_DEFAULT"
    for name in menu.layout.operators:
        assert len(described(name).description) > 20


def test_samples_menu_offers_every_shape():
    menu = Menu()
    menus.SYNCH_MT_samples.draw(menu, bpy.context)
    assert menu.layout.operators == ["synch.add_sample"] * 3


def test_object_menus_have_the_entry_for_meshes_alone():
    for name, draw in menus._ADDED:
        assert draw in getattr(bpy.types, name)._dyn_ui_initialize()
    menu = Menu()
    bpy.ops.object.empty_add()
    menus._draw_object(menu, bpy.context)
    assert not menu.layout.menus
    sphere()
    menus._draw_object(menu, bpy.context)
    assert menu.layout.menus == ["SYNCH_MT_object"]


def test_every_operator_and_its_settings_have_tooltips():
    names = dir(bpy.ops.synch)
    assert len(names) > 20
    for name in names:
        found = described(name)
        assert found.description and not found.description.endswith("."), name
        own = [p for p in found.properties if not p.is_hidden and p.identifier not in _BLENDERS]
        assert all(p.description for p in own), (name, [p.identifier for p in own if not p.description])


@pytest.mark.parametrize("path", PRESETS, ids=lambda path: path.stem)
def test_preset_solves_as_it_says(path):
    obj = tube(12, 5)
    bpy.ops.script.execute_preset(filepath=str(path), menu_idname="SYNCH_PT_presets")
    settings = obj.synch
    expected = {"Smoothest": "smooth", "Line_on_the_Boundary": "smooth", "Rings_around_Z": "axis:Z"}
    assert stored_guidance(settings).startswith(expected.get(path.stem, "curvature-"))
    chosen = {name: getattr(settings, name).lower() for name in ("symmetry", "boundary")}
    report = api.stripes(obj, guidance=stored_guidance(settings), angle=settings.angle, spacing=0.8, **chosen)
    assert report["energy"] is not None


def test_presets_are_found_by_blender():
    folders = bpy.utils.preset_paths(setting_presets.FOLDER)
    assert str(PRESETS[0].parent) in [str(Path(folder)) for folder in folders] and len(PRESETS) == 5


def test_own_preset_keeps_all_settings(tmp_path, monkeypatch):
    monkeypatch.setattr(bpy.utils, "user_resource", lambda kind, path="", create=False: str(tmp_path))
    obj = sphere()
    changed = {"angle": 0.5, "spacing": 0.25, "automatic_spacing": False, "seed": 7, "guidance": "AXIS"}
    changed |= {"branching": 30.0, "singularities": 50.0, "mesh_branching": 20.0, "mesh_singularities": 40.0}
    for name, value in changed.items():
        setattr(obj.synch, name, value)
    obj.synch.guide.axis = "X"
    assert bpy.ops.synch.add_preset(name="My Own") == {"FINISHED"}
    (path,) = tmp_path.glob("*.py")
    other = sphere()
    bpy.ops.script.execute_preset(filepath=str(path), menu_idname="SYNCH_PT_presets")
    assert other.synch.guide.axis == "X"
    for name in STORED_NAMES:
        now, then = getattr(other.synch, name), getattr(obj.synch, name)
        assert (list(now) if name == "mirror" else now) == (list(then) if name == "mirror" else then)
    assert all(getattr(other.synch, name) == pytest.approx(value) if isinstance(value, float)
               else getattr(other.synch, name) == value for name, value in changed.items())  # fmt: skip


def test_operators_keep_presets_of_their_own():
    for name in ("stripes", "quads", "quad_mesh", "directions", "isolines", "bake", "add_sample"):
        assert "PRESET" in getattr(bpy.types, f"SYNCH_OT_{name}").bl_options


def test_every_icon_is_one_of_blenders():
    known = set(bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items.keys())
    used = {}
    for path in Path(menus.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.keyword) and node.arg == "icon" and isinstance(node.value, ast.Constant):
                used[node.value.value] = path.name
    used |= {icon: "menus.py" for group in menus._ENTRIES for *_, icon in group}
    assert len(used) > 20 and {icon: where for icon, where in used.items() if icon not in known} == {}
