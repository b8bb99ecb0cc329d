# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What README and manual show runs: Python code, rows, command lines on small meshes, make targets and links."""

import json
import re
import shlex
from functools import partial
from itertools import pairwise
from pathlib import Path

import bpy
import numpy as np
import pytest

from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.settings.constraints import from_plain
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import meshes
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.looks import render

from . import vortex_scenes

ROOT = Path(__file__).resolve().parents[2]
MANUAL = ROOT / "docs"
PATHS = {path.stem: path for path in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(MANUAL.glob("*.md")))}
PAGES = {name: path.read_text(encoding="utf-8") for name, path in PATHS.items()}
_BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
FENCED = [(name, *block) for name, page in PAGES.items() for block in _BLOCK.findall(page)]
PYTHON = [pytest.param(text, id=name) for name, language, text in FENCED if language == "python"]
JSON = [pytest.param(text, id=name) for name, language, text in FENCED if language == "json"]
SHELL = [line for _, language, text in FENCED if not language for line in text.splitlines()]
COMMANDS = dict.fromkeys(line for line in SHELL if "synch_fields " in line or "--command synch " in line)
# Baking takes its time however small the mesh is, and batches need their rows; such command lines are only parsed.
LONG = ("bake", "batch")
# Small enough that the README's spacings of 0.05 and 0.1 give some ten stripes and quads.
RADIUS = 0.35
FRAMES = 3


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, an empty one; pictures are small there, and flows narrow."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(vortex_scenes, "SHAPE", (24, 8, 6))  # 48 nodes along the longest side are few then
    set_up = render._set_up_render
    monkeypatch.setattr(render, "_set_up_render", lambda scene, path, *_: set_up(scene, path, (32, 24), 1))
    return tmp_path


def ball(radius=RADIUS):
    """A sphere of 642 vertices with vertex groups at its poles."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=radius)
    obj = bpy.context.active_object
    obj.name = "Body"
    for name, sign in (("Bottom", -1), ("Top", 1)):
        near = [vertex.index for vertex in obj.data.vertices if sign * vertex.co.z > 0.9 * radius]
        obj.vertex_groups.new(name=name).add(near, 1.0, "REPLACE")
    return obj


@pytest.fixture
def names(folder, monkeypatch):
    """The names that a block may rely on: an object in the scene, and arrays; images are small there, solids coarse."""
    obj = ball()
    mesh = meshes.read_mesh(obj).mesh
    longer = TriangleMesh(mesh.vertices * [1, 1, 1.1], mesh.triangles)
    monkeypatch.setattr(api, "bake", partial(api.bake, size=32, unwrap=True))
    monkeypatch.setattr(api, "layers", partial(api.layers, size=0.1))
    found = {"bpy": bpy, "api": api, "obj": obj, "vertices": mesh.vertices, "triangles": mesh.triangles}
    return found | {"moved_problem": direction_problem(longer, symmetry=4)}


@pytest.mark.parametrize("text", PYTHON)
def test_python_runs(text, folder, names):
    if "mpi4py" in text:  # it takes many processes: tests/bench/mpi
        pytest.importorskip("mpi4py")
    vortex_scenes.write_vdb(folder / "smoke.vdb")
    if "api.bake" in text:
        api.stripes(names["obj"], spacing=0.1)
        (folder / "out").mkdir()
    for here, small in {"range(1, 25)": "range(1, 3)", "frames=(1, 24)": "frames=(1, 2)", "[1000]": "[100]"}.items():
        text = text.replace(here, small)
    exec(text, names)
    if "cut" in names:
        assert names["solve"](names["cut"]).energy == pytest.approx(4)
        assert names["solve"](names["circle"]).phases.shape == (5,)


@pytest.mark.parametrize("text", JSON)
def test_rows_are_understood(text):
    if text.startswith("["):
        assert all(row.where for row in from_plain(json.loads(text)))
        return
    for row in map(json.loads, text.splitlines()):
        words = [row.pop("command"), row.pop("input")]
        for name, value in row.items():
            values = value if isinstance(value, list) else [value]
            words += [f"--{name.replace('_', '-')}", *map(str, values)] if name != "chunk" else []
        assert main._parser(loaded=False).parse_args(words).command == words[0]


def arguments_of(line):
    """The words of a command line that come after the program, and whether they are for a loaded file."""
    words = shlex.split(line, comments=True)
    start = words.index("synch" if "--command" in words else "synch_fields") + 1
    return words[start:], "--command" in words


@pytest.mark.parametrize("line", COMMANDS)
def test_command_line_is_understood(line):
    arguments, loaded = arguments_of(line)
    if "--" in arguments:  # what follows is one for each file of a batch
        place = arguments.index("--")
        shared = main._parser(loaded).parse_args([arguments[place + 1], "mesh.obj", *arguments[place + 2 :]])
        assert shared.command == arguments[place + 1]
        arguments = arguments[:place]
    assert main._parser(loaded).parse_args(arguments).command == arguments[0]


def prepare(path):
    """Write what a command line reads."""
    if "####" in path.name:
        for frame in range(1, FRAMES + 1):
            vortex_scenes.write_vdb(path.with_name(path.name.replace("####", f"{frame:04}")), height=0.02 * frame)
    elif path.suffix == ".npz":
        x, y, z = np.meshgrid(*[np.arange(12) / 2] * 3, indexing="ij")
        np.savez(path, velocity=np.stack([np.sin(z) + np.cos(y), np.sin(x), np.cos(x)], axis=-1), spacing=0.5)
    elif path.suffix == ".rawfield":
        assert main.main(["directions", "--symmetry=cross", f"--export-field={path}", "--quiet"], loaded=True) == 0
    else:
        ball(1.0 if path.suffix == ".stl" else RADIUS)
        if path.suffix == ".blend":
            bpy.ops.wm.save_as_mainfile(filepath=str(path))
        else:
            {".obj": bpy.ops.wm.obj_export, ".stl": bpy.ops.wm.stl_export}[path.suffix](filepath=str(path))


@pytest.mark.parametrize("line", [line for line in COMMANDS if arguments_of(line)[0][0] not in LONG])
def test_command_line_runs(line, folder, capfd):
    arguments, loaded = arguments_of(line)
    given = re.findall(r"[\w#-]+\.(?:obj|stl|blend|vdb|npz|rawfield)", line)
    asked_for = ("--output", "--render", "--report", "--export")
    written = [name for flag, name in pairwise(arguments) if flag.startswith(asked_for)]
    for name in given:
        if name not in written and not Path(name).exists():
            prepare(folder / name)
    (folder / "out").mkdir()
    if "--frames" in arguments:
        arguments[arguments.index("--frames") + 2] = str(FRAMES)
    assert main.main(arguments, loaded) == 0, capfd.readouterr().err
    assert all(list(folder.rglob(f"{Path(name).stem}*{Path(name).suffix}")) for name in written)


def test_make_targets_are_there():
    rules = re.findall(r"^([\w -]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    targets = " ".join(rules).split()
    asked_for = set(re.findall(r"(?:`|^)make ([\w-]+)", PAGES["README"] + PAGES["CONTRIBUTING"], re.MULTILINE))
    assert asked_for and asked_for <= set(targets)


@pytest.mark.parametrize("name", PAGES)
def test_links_lead_to_files_and_headings(name):
    page, here = PAGES[name], PATHS[name].parent
    named = re.findall(r"`((?:docs|bench|core|tools|tests|\.ci)/[\w./-]*)`", page)
    assert not [place for place in named if not (ROOT / place).exists()]
    for link in re.findall(r"\]\((?!https://)([^)]+)\)", page):
        target, _, heading = link.partition("#")
        path = (here / target).resolve() if target else PATHS[name]
        assert path.exists(), link
        if heading:
            titles = re.findall(r"^#+ (.*)", path.read_text(encoding="utf-8"), re.MULTILINE)
            anchors = [re.sub(r"[^\w -]", "", title).lower().replace(" ", "-") for title in titles]
            assert heading in anchors, link


def test_every_operator_has_its_row_and_its_page():
    rows = [line for line in PAGES["operators"].splitlines() if line.startswith("| **")]
    listed = {name: re.search(r"\((\w+\.md)\)", row)[1] for row in rows for name in re.findall(r"`(synch\.\w+)`", row)}
    registered = {f"synch.{name}" for name in dir(bpy.ops.synch)}
    assert listed.keys() == registered
    functions = {name for row in rows for name in re.findall(r"`api\.(\w+)`", row)}
    assert all(callable(getattr(api, name)) for name in functions)


def test_every_message_of_the_page_is_one_that_the_program_says():
    code = "".join(
        path.read_text(encoding="utf-8") for part in ("core", "synch_addon") for path in (ROOT / part).rglob("*.py")
    )
    code = re.sub(r'"\s*\n\s*f?"', "", code)
    messages = re.findall(r"^\| `([^`]+)` \|", PAGES["messages"], re.MULTILINE)
    assert len(messages) > 30
    assert not [message for message in messages if message not in code.replace("{SPACING}", "synch_spacing")]


def test_the_manual_lists_every_page():
    listed = set(re.findall(r"- (\w+\.md)", (ROOT / "mkdocs.yml").read_text(encoding="utf-8")))
    outside = {"benchmarks.md", "quad_tables.md", "changelog.md", "contributing.md"}
    assert listed == {path.name for path in PATHS.values() if path.parent == MANUAL} | outside


def test_the_readme_is_short():
    assert len(PAGES["README"].split()) <= 800
