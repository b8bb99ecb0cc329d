# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One record declares a setting: in a copy of the program with one record more, all that is made of it is there."""

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
BEFORE = "    assign_material: bool = setting("
RECORD = """    glow: float = setting(
        0.25,
        "Glow",
        "How strongly the lines glow",
        least=0,
        most=8,
        commands=PATTERNS,
        group="pattern",
    )
"""
LOOK = """
import bpy, sys
import synch_fields
from synch_fields.core.errors import SettingError
from synch_fields.core.settings.keywords import SurfaceKeywords
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon.command.main import _parser
from synch_fields.synch_addon.command.settings import settings_of
from synch_fields.synch_addon.panels.setting_rows import draw_settings
from synch_fields.synch_addon.settings.fields import stored_settings

synch_fields.register()
bpy.ops.mesh.primitive_cube_add()
obj = bpy.context.object


class Layout:
    drawn = []

    def __getattr__(self, name):
        return lambda *given, **more: self

    def prop(self, owner, name, **more):
        self.drawn.append(name)


draw_settings(Layout(), obj.synch, SurfaceSettings, "pattern")
assert "glow" in Layout.drawn, Layout.drawn
shown = obj.synch.bl_rna.properties["glow"]
assert (shown.name, shown.description, shown.hard_max) == ("Glow", "How strongly the lines glow", 8), shown
obj.synch.glow = 0.5
assert stored_settings(obj).glow == 0.5
assert bpy.ops.synch.stripes.get_rna_type().properties["glow"].default == 0.25

options = _parser(False).parse_args(["quads", "x.obj", "--glow", "3"])
assert settings_of(options, SurfaceSettings).glow == 3
assert not hasattr(_parser(False).parse_args(["directions", "x.obj"]), "glow")

assert SurfaceKeywords.__annotations__["glow"] is float or "float" in str(SurfaceKeywords.__annotations__["glow"])
try:
    SurfaceSettings(glow=9)
except SettingError as error:
    print(error)
synch_fields.unregister()
"""


def test_a_setting_is_added_by_one_record(tmp_path):
    tree = tmp_path / "synch_fields"
    for name in ("core", "synch_addon", "tools"):
        # With the compiled modules, which are those of files of the same time and size.
        shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("library"))
    for name in ("__init__.py", "__main__.py", "blender_manifest.toml"):
        shutil.copy(ROOT / name, tree)
    (tree / "docs").mkdir()
    declared = tree / "core" / "settings" / "surface.py"
    text = declared.read_text(encoding="utf-8")
    assert text.count(BEFORE) == 1
    declared.write_text(text.replace(BEFORE, RECORD + BEFORE), encoding="utf-8")
    link = tree / "out" / "tree" / "synch_fields"
    link.parent.mkdir(parents=True)
    link.symlink_to(tree, target_is_directory=True)
    subprocess.run([sys.executable, "tools/settings.py"], cwd=tree, check=True)
    assert "| `glow` | Glow | number from 0 to 8 | 0.25 | How strongly the lines glow |" in (
        tree / "docs" / "reference.md"
    ).read_text(encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", LOOK],
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path), "PATH": "", "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert "the glow is 9.0: give a number from 0 to 8" in done.stdout, done.stderr
