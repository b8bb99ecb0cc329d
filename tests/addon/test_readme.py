# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the README shows runs: its Python code, its command lines on small meshes, its make targets and links."""

import re
import shlex
from itertools import pairwise
from pathlib import Path

import bpy
import pytest

from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.geometry import TriangleMesh
from synch_fields.synch_addon.blender import meshes
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.looks import render

from . import vortex_scenes

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
FENCED = [block for block in re.findall(r"^```(\w*)\n(.*?)^```", README, re.MULTILINE | re.DOTALL)]
PYTHON = [text for language, text in FENCED if language == "python"]
SHELL = [line for language, text in FENCED if not language for line in text.splitlines()]
COMMANDS = [line for line in SHELL if "synch_fields " in line or "--command synch " in line]
# Baking takes its time however small the mesh is; such command lines are only parsed.
LONG = ("bake",)
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
    """A sphere of 2562 vertices with vertex groups at its poles."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=radius)
    obj = bpy.context.active_object
    obj.name = "Body"
    for name, sign in (("Bottom", -1), ("Top", 1)):
        near = [vertex.index for vertex in obj.data.vertices if sign * vertex.co.z > 0.9 * radius]
        obj.vertex_groups.new(name=name).add(near, 1.0, "REPLACE")
    return obj


def names_in(block):
    """The names that a block may rely on: an object in the scene, and arrays."""
    mesh = meshes.read_mesh(ball()).mesh
    longer = TriangleMesh(mesh.vertices * [1, 1, 1.1], mesh.triangles)
    moved_problem = direction_problem(longer, symmetry=4)
    return {"bpy": bpy, "vertices": mesh.vertices, "triangles": mesh.triangles, "moved_problem": moved_problem}


@pytest.mark.parametrize("number", range(len(PYTHON)))
def test_python_runs(number, folder):
    vortex_scenes.write_vdb(folder / "smoke.vdb")
    names = names_in(PYTHON[number])
    exec(PYTHON[number], names)
    if "cut" in names:
        assert names["solve"](names["cut"]).energy == pytest.approx(4)
        assert names["solve"](names["circle"]).phases.shape == (5,)


def arguments_of(line):
    """The words of a command line that come after the program, and whether they are for a loaded file."""
    words = shlex.split(line)
    start = words.index("synch" if "--command" in words else "synch_fields") + 1
    return words[start:], "--command" in words


@pytest.mark.parametrize("line", COMMANDS)
def test_command_line_is_understood(line):
    arguments, loaded = arguments_of(line)
    assert main._parser(loaded).parse_args(arguments).command == arguments[0]


def prepare(path):
    """Write what a command line reads."""
    if "####" in path.name:
        for frame in range(1, FRAMES + 1):
            vortex_scenes.write_vdb(path.with_name(path.name.replace("####", f"{frame:04}")), height=0.02 * frame)
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
    given = re.findall(r"[\w#-]+\.(?:obj|stl|blend|vdb|rawfield)", line)
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
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    asked_for = set(re.findall(r"(?:`|^)make ([\w-]+)", README, re.MULTILINE))
    assert asked_for and asked_for <= set(targets)


def test_links_lead_to_files():
    links = re.findall(r"\]\(([^)#]+)\)", README) + re.findall(r"`((?:docs|bench|core|tools|\.ci)/[\w./-]*)`", README)
    missing = [link for link in links if not (ROOT / link).exists()]
    assert len(links) > 10 and not missing
