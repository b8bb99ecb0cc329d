# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What reviews of the extension platform refuse, and lookups by translated names, are not in the zip: each rule is read
from the zip itself.

SYNCH_ARCHIVES names a folder with the zips of a release and their wheels; without it, the one without wheels is built.
"""

import ast
import hashlib
import io
import os
import subprocess
import sys
import tomllib
import zipfile
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDER = os.environ.get("SYNCH_ARCHIVES")
PLATFORMS = {"linux-x64": "manylinux", "macos-arm64": "macosx", "macos-x64": "macosx", "windows-x64": "win_amd64"}
THREADS = "core/threads.py"
# Where arrays become meshes and curves, and the calls that make them.
DOOR = "synch_addon/blender/new_geometry.py"
MAKING = (
    "from_pydata", "meshes.new", "vertices.add", "edges.add", "loops.add", "polygons.add", "splines.new", "points.add",
    "bezier_points.add", "pointclouds.new", "hair_curves.new", "add_curves",
)  # fmt: skip
# Modules that begin threads or open connections, and the standard library's that change where modules come from.
BESIDE = {"threading", "_thread", "concurrent", "multiprocessing", "asyncio"}
NETWORK = {"socket", "ssl", "http", "urllib", "ftplib", "smtplib", "xmlrpc", "webbrowser", "requests", "distributed"}
IMPORTING = {"imp", "site", "runpy", "pip", "ensurepip"}
RUNNING = {"eval", "exec", "compile", "__import__"}
# Collections of Blender's data whose new members get names in the user's language; nodes are looked for apart.
NAMED = {"objects", "materials", "meshes", "collections", "children", "worlds", "scenes", "modifiers", "constraints"}
NAMED |= {"uv_layers", "vertex_groups", "key_blocks", "color_attributes", "brushes", "workspaces", "screens", "layers"}
BINARIES = {".so", ".pyd", ".dll", ".dylib", ".exe", ".pyc", ".bat", ".sh"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    if FOLDER:
        return Path(FOLDER)
    built = tmp_path_factory.mktemp("built")
    command = [sys.executable, ROOT / "tools/extension.py", "--output-dir", built]
    subprocess.run(command, check=True, capture_output=True)
    return built


@pytest.fixture(scope="module")
def zips(folder):
    """The zips, each as its entries' names and bytes."""
    found = {}
    for path in sorted(folder.glob("*.zip")):
        with zipfile.ZipFile(path) as content:
            found[path.name] = {name: content.read(name) for name in content.namelist()}
    assert len(found) == (len(PLATFORMS) if FOLDER else 1)
    return found


@pytest.fixture(scope="module")
def trees(zips):
    """The programs in the zips: trees by names; the same in all."""
    codes = [{name: data for name, data in content.items() if name.endswith(".py")} for content in zips.values()]
    assert len(codes[0]) > 300 and all(code == codes[0] for code in codes)
    return {name: ast.parse(data) for name, data in codes[0].items()}


@cache
def nodes_of(tree):
    return [*ast.walk(tree)]


def imported(tree):
    """First parts of the names of modules that a program imports, its own left out."""
    names = set()
    for node in nodes_of(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names.add(node.module.split(".")[0])
    return names


def dotted(node):
    """``a.b.c`` of an expression, "" of another one."""
    if isinstance(node, ast.Attribute):
        return f"{dotted(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


def refused(tree):
    """What a program does that an extension must not: runs text, or changes where modules come from."""
    found = []
    for node in nodes_of(tree):
        if isinstance(node, ast.Call):
            name = dotted(node.func)
            if name in RUNNING or (name.endswith(".reload") and name.startswith(("importlib", "imp"))):
                found.append(name)
            if name.startswith(("sys.path.", "sys.modules.", "sys.meta_path.", "site.")):
                found.append(name)
        targets = node.targets if isinstance(node, ast.Assign | ast.Delete) else [getattr(node, "target", None)]
        for target in targets:
            whole = target.value if isinstance(target, ast.Subscript) else target
            if dotted(whole) in ("sys.path", "sys.modules", "sys.meta_path"):
                found.append(dotted(whole))
    return found


def found_by_name(tree):
    """Lookups of what Blender names in the user's language: nodes by any name, other data by a literal one."""
    found = []
    for node in nodes_of(tree):
        match node:
            case ast.Subscript(value=ast.Attribute(attr=owner), slice=key):
                pass
            case ast.Call(func=ast.Attribute(attr="get" | "find", value=ast.Attribute(attr=owner)), args=[key, *_]):
                pass
            case ast.Compare(left=key, ops=[ast.In() | ast.NotIn()], comparators=[ast.Attribute(attr=owner)]):
                pass
            case _:
                continue
        kind = type(getattr(key, "value", None))
        if (owner == "nodes" and kind is not int and not isinstance(key, ast.Slice)) or (
            owner in NAMED and kind is str
        ):
            found.append(ast.unparse(node))
    return found


@pytest.mark.parametrize(
    "code",
    [
        "tree.nodes['Material Output']",
        "tree.nodes[name]",
        "tree.nodes.get(name)",
        "'Principled BSDF' in tree.nodes",
        "bpy.data.objects['Cube']",
        "obj.data.uv_layers.get('UVMap')",
        "obj.modifiers['Remesh']",
    ],
)
def test_lookups_by_translated_names_would_be_found(code):
    assert found_by_name(ast.parse(code))


def test_nothing_is_found_by_a_name_that_blender_translates(trees):
    addon = {name: tree for name, tree in trees.items() if name.startswith("synch_addon/")}
    assert {name: found for name, tree in addon.items() if (found := found_by_name(tree))} == {}


@pytest.mark.parametrize(
    "code",
    [
        "eval(text)",
        "exec(text)",
        "__import__('os')",
        "importlib.reload(module)",
        "sys.path.append(folder)",
        "sys.path[:0] = [folder]",
        "sys.path += [folder]",
        "sys.modules['numpy'] = None",
        "del sys.modules['numpy']",
    ],
)
def test_what_is_refused_would_be_found(code):
    assert refused(ast.parse(code))


def test_threads_are_in_one_file_which_says_where_they_run(zips, trees):
    for content in zips.values():
        naming = {name for name, data in content.items() if name.endswith(".py") and b"threading" in data}
        assert naming == {THREADS}
    assert {name for name, tree in trees.items() if imported(tree) & BESIDE} == {THREADS}
    said = ast.get_docstring(trees[THREADS])
    assert "No thread runs beside Blender" in said and "child process" in said


def test_no_text_is_run_and_no_module_is_changed_or_looked_for_elsewhere(trees):
    assert {name: refused(tree) for name, tree in trees.items() if refused(tree)} == {}
    assert not [name for name, tree in trees.items() if imported(tree) & IMPORTING]


def test_the_network_is_neither_used_nor_asked_for(zips, trees):
    assert {name: imported(tree) & NETWORK for name, tree in trees.items() if imported(tree) & NETWORK} == {}
    for content in zips.values():
        assert "network" not in manifest_of(content)["permissions"]


def manifest_of(content):
    return tomllib.loads(content["blender_manifest.toml"].decode())


def made(tree):
    """Calls of a program that make meshes' or curves' data of numbers."""
    names = [dotted(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)]
    return [name for name in names if name.endswith(tuple(f".{call}" for call in MAKING))]


def test_arrays_become_meshes_and_curves_at_one_door(trees):
    assert made(ast.parse("data.from_pydata(points, [], faces)")) and made(ast.parse("bpy.data.meshes.new(name)"))
    assert {name for name, tree in trees.items() if made(tree)} == {DOOR}


def test_permissions_are_those_that_the_program_uses(zips, trees):
    uses = {
        "files": any(
            dotted(node.func) == "open" or dotted(node.func).endswith((".write_bytes", ".write_text"))
            for tree in trees.values()
            for node in ast.walk(tree)
            if isinstance(node, ast.Call)
        ),
        "clipboard": any(
            isinstance(node, ast.Attribute) and node.attr == "clipboard"
            for tree in trees.values()
            for node in ast.walk(tree)
        ),
    }
    for content in zips.values():
        stated = manifest_of(content)["permissions"]
        assert set(stated) == {name for name, is_used in uses.items() if is_used}
        assert all(text and len(text) <= 64 and text[-1] not in ".!?" for text in stated.values())


def test_wheels_are_unmodified_for_the_platform_and_without_numpy(zips):
    lines = (ROOT / "tools/wheels.sha256").read_text(encoding="utf-8").splitlines()
    known = dict(reversed(line.split()) for line in lines)
    named = {Path(wheel).name for wheel in tomllib.loads((ROOT / "blender_manifest.toml").read_text())["wheels"]}
    assert named == known.keys() and not [name for name in named if name.startswith("numpy")]
    seen = set()
    for content in zips.values():
        wheels = {name for name in content if name.endswith(".whl")}
        fit = manifest_of(content)["build"].get("generated", {"platforms": [], "wheels": []})
        assert {f"./{name}" for name in wheels} == set(fit["wheels"])
        for name in wheels:
            file = Path(name).name
            assert hashlib.sha256(content[name]).hexdigest() == known[file], file
            (platform,) = fit["platforms"]
            assert PLATFORMS[platform] in file or file.endswith("-none-any.whl"), (platform, file)
            with zipfile.ZipFile(io.BytesIO(content[name])) as wheel:
                assert not [path for path in wheel.namelist() if path.startswith("numpy/")]
            seen.add(file)
    assert seen == (named if FOLDER else set())


def test_nothing_compiled_lies_outside_of_wheels(zips):
    for content in zips.values():
        outside = [name for name in content if not name.endswith(".whl")]
        assert not [name for name in outside if Path(name).suffix in BINARIES or "numpy" in name.split("/")]
