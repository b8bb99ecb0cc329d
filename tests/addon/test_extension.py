# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension as a user gets it: a valid zip that installs into a fresh Blender and works there on its own."""

import ast
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = "bl_ext.user_default.synch_fields"

# Blender 4.5 and 5.0 run Python 3.11; 5.1 and later run Python 3.13 and no longer exist for macOS on x64.
SUPPORTED_PLATFORMS = {
    (3, 11): {"windows-x64", "macos-arm64", "macos-x64", "linux-x64"},
    (3, 13): {"windows-x64", "macos-arm64", "linux-x64"},
}

INSTALL = """
import sys, bpy
result = bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
assert result == {"FINISHED"}, result
"""

USE = f"""
import sys, bpy
import addon_utils  # on the path once bpy is loaded
module = addon_utils.enable("{MODULE}", default_set=False)
assert module is not None, "the extension cannot be enabled"
bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4)
assert "synch_phase" not in bpy.context.object.data.attributes
assert bpy.ops.synch.stripes(spacing=0.8) == {{"FINISHED"}}
from pathlib import Path
for library in Path(module.__file__).parent.rglob("synch_fields.blend"):
    with bpy.data.libraries.load(str(library), assets_only=True) as (there, _):
        assert len(there.materials) == 6 and len(there.node_groups) == 4
assert bpy.ops.synch.asset_library() == {{"FINISHED"}}
assert bpy.utils.preset_paths("synch_fields"), "the shipped settings are missing"
phase = bpy.context.object.data.attributes["synch_phase"]
values = [element.value for element in phase.data]
assert max(values) - min(values) > 1, "the phase is constant"
assert "synch_fields" not in sys.modules, "the extension imports the pip package instead of itself"
{{IMPORT}}
assert api.stripes(bpy.context.object, spacing=0.8)["command"] == "stripes" and api.__name__.startswith("{MODULE}.")
print(phase.domain, phase.data_type, module.__file__)
"""
# The manual says how the functions are imported from the zip and from the package.
IMPORT = re.search(r"^try:\n.*\nexcept .*\n.*\n", (ROOT / "docs" / "scripting.md").read_text("utf-8"), re.MULTILINE)[0]
USE = USE.replace("{IMPORT}", IMPORT)


def run(*arguments, **environment):
    """Standard output of a Python process of its own, which must succeed."""
    result = subprocess.run(
        [sys.executable, *map(str, arguments)], capture_output=True, text=True, env=os.environ | environment
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """The zip that `make extension` builds, without wheels."""
    folder = tmp_path_factory.mktemp("archive")
    return Path(run(ROOT / "tools/extension.py", "--output-dir", folder).strip())


@pytest.fixture(scope="module")
def build_tool():
    """tools/extension.py as a module."""
    return load(ROOT / "tools/extension.py")


def load(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def manifest():
    return tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))


def test_zip_is_valid_for_blender(archive, build_tool):
    tags = build_tool.blender_file("scripts/modules/_bpy_internal/extensions/tags.py")
    build_tool.blender_ext("validate", "--valid-tags", tags, archive)


def test_manifest_says_what_the_program_touches_and_every_licence(archive):
    code = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "synch_addon").rglob("*.py"))
    assert ("clipboard" in manifest()["permissions"]) == ("window_manager.clipboard" in code)
    with zipfile.ZipFile(archive) as content:
        notices = [name for name in content.namelist() if name.endswith("/LICENSE.txt")]
        assert {name.split("/")[2] for name in notices} == {"library", "thumbnails"}
        assert all(b"CC0 1.0 Universal" in content.read(name) for name in notices)
    assert manifest()["license"] == ["SPDX:GPL-3.0-or-later", "SPDX:CC0-1.0"]


def test_zip_holds_the_program_and_nothing_else(archive):
    with zipfile.ZipFile(archive) as content:
        names = set(content.namelist())
        packed_manifest = tomllib.loads(content.read("blender_manifest.toml").decode())
    sources = [path for part in ("core", "synch_addon") for path in (ROOT / part).rglob("*.py")]
    code = {path.relative_to(ROOT).as_posix() for path in sources} - {"core/batch/cluster.py"}
    assert len(code) == len(sources) - 1
    assert {name for name in names if name.endswith(".py")} == code | {"__init__.py", "__main__.py"}
    assert {name for name in names if "/" not in name and not name.endswith(".py")} == {
        "LICENSE",
        "blender_manifest.toml",
    }
    assert not [name for name in names if "__pycache__" in name]
    found = [path for part in ("core", "synch_addon") for path in (ROOT / part).rglob("*")]
    files = [path for path in found if path.suffix not in ("", ".py", ".pyc")]
    data = {path.relative_to(ROOT).as_posix() for path in files}
    assert {Path(name).suffix for name in data} == {".blend", ".png", ".po", ".toml", ".txt"}
    assert names - code - {"__init__.py", "__main__.py", "LICENSE", "blender_manifest.toml"} == data
    expected = manifest()
    del expected["wheels"], expected["platforms"], expected["build"]
    assert {key: packed_manifest[key] for key in expected} == expected
    assert not {"wheels", "platforms"} & packed_manifest.keys()


def test_two_builds_are_the_same_to_the_last_byte(archive, tmp_path):
    """Of another checkout, whose files are of another time and for nobody else."""
    source = tmp_path / "checkout"
    source.mkdir()
    for name in ("core", "synch_addon", "tools"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("__init__.py", "__main__.py", "LICENSE", "blender_manifest.toml"):
        shutil.copyfile(ROOT / name, source / name)
    for path in source.rglob("*"):
        path.chmod(0o700)
        os.utime(path, (2e9, 2e9))
    built = Path(run(source / "tools/extension.py", "--output-dir", tmp_path, TZ="Asia/Tokyo").strip())
    assert built.parent == tmp_path and built.read_bytes() == archive.read_bytes()


def test_installed_extension_makes_stripes(archive, tmp_path):
    run("-c", INSTALL, archive, BLENDER_USER_RESOURCES=str(tmp_path))
    printed = run("-c", USE, BLENDER_USER_RESOURCES=str(tmp_path))
    assert f"CORNER FLOAT {tmp_path}" in printed


def test_build_failure_is_one_line(tmp_path):
    """An environment without bpy has no extension tool."""
    result = subprocess.run(
        [sys.executable, "-S", ROOT / "tools/extension.py", "--output-dir", tmp_path], capture_output=True, text=True
    )
    assert result.returncode == 1
    assert result.stderr.startswith("extension: ") and result.stderr.count("\n") == 1
    assert "bpy" in result.stderr
    assert not list(tmp_path.iterdir())


def test_every_wheel_covers_every_supported_blender(build_tool):
    """Blender checks the fit on the union of all wheels: a package missing for one Python would install silently."""
    blender_ext = load(build_tool.blender_file("scripts/addons_core/bl_pkg/cli/blender_ext.py"))
    wheels = [Path(wheel).name for wheel in manifest()["wheels"]]
    fits_platform = blender_ext.blender_platform_compatible_with_wheel_platform_from_filepath
    releases = {tuple(wheel.split("-")[:2]) for wheel in wheels}
    packages = {package for package, _ in releases}
    assert "scipy" in packages and "numpy" not in packages
    assert len(releases) == len(packages), f"one version of each package: {sorted(releases)}"
    fitting = [
        [
            wheel
            for wheel in wheels
            if wheel.startswith(f"{package}-")
            and {python, python[:1]} & blender_ext.python_versions_from_wheel(wheel)
            and fits_platform(platform, wheel)
        ]
        for package in packages
        for python, platforms in SUPPORTED_PLATFORMS.items()
        for platform in platforms
    ]
    assert [len(found) for found in fitting] == [1] * len(fitting), fitting
    assert sorted({wheel for found in fitting for wheel in found}) == sorted(wheels)
    assert set(manifest()["platforms"]) == set.union(*SUPPORTED_PLATFORMS.values())


def test_core_never_imports_blender():
    forbidden = {"bpy", "bmesh", "mathutils", "gpu", "addon_utils", "synch_addon"}
    files = sorted((ROOT / "core").rglob("*.py"))
    assert files
    for path in files:
        imported = set()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                imported |= {part for alias in node.names for part in alias.name.split(".")}
            elif isinstance(node, ast.ImportFrom):
                imported |= set((node.module or "").split(".")) | {alias.name for alias in node.names}
        assert not imported & forbidden, f"{path.relative_to(ROOT)} imports {imported & forbidden}"


def test_importing_the_package_does_not_load_blender():
    run("-c", "import sys, synch_fields, synch_fields.core; assert 'bpy' not in sys.modules")
