# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `bake`: images from a .blend that holds a pattern."""

import json

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.pattern_surface import surface_of
from synch_fields.synch_addon.command import main

from ..scenes import sphere
from .test_command_line import command_line, run


@pytest.fixture(scope="module")
def striped(tmp_path_factory, extension):
    """A .blend of a striped ball without a UV map, hidden, and a plain one beside it."""
    path = tmp_path_factory.mktemp("bake") / "striped.blend"
    bpy.ops.wm.read_homefile(use_empty=True)
    for name in ("Plain", "Ball"):
        obj = sphere(2)
        obj.name = name
        while obj.data.uv_layers:
            obj.data.uv_layers.remove(obj.data.uv_layers[0])
    api.stripes(obj, spacing=0.7)
    obj.hide_set(True)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def test_maps_go_into_a_folder_and_the_report(striped, tmp_path):
    report_file = tmp_path / "out.json"
    done = command_line(
        *("bake", striped, "--object", "Ball", "--size", 32, "--maps", "colour,normal,height", "--unwrap"),
        *("--samples", 1, "--folder", tmp_path, "--report", report_file),
    )
    assert done.returncode == 0, done.stderr
    files = [tmp_path / f"Ball_{name}.png" for name in ("colour", "height", "normal")]
    assert all(path.stat().st_size > 100 for path in files)
    assert done.stdout.startswith("baked stripes of Ball: 32 pixels")
    assert all(f"wrote {path}" in done.stdout for path in [*files, report_file])
    assert "Baking map" not in done.stdout and "%" in done.stderr
    report = json.loads(report_file.read_text())
    assert report["status"] == "baked" and report["uv_map"] == "Synch Bake" and report["seconds"] > 0
    assert {entry["file"] for entry in report["maps"].values()} == {str(path) for path in files}
    assert {p.name for p in tmp_path.iterdir()} == {p.name for p in files} | {"out.json"}


def test_packed_images_and_their_material_are_saved(striped, tmp_path, capfd):
    flags = ["--size", 16, "--samples", 1, "--unwrap", "--material", "--format", "EXR", "--quiet"]
    out = tmp_path / "out.blend"
    status, printed, err = run(capfd, "bake", striped, "--object", "Ball", "--output", out, *flags)
    assert status == 0, err
    assert f"wrote {out}" in printed and [p.name for p in tmp_path.iterdir()] == ["out.blend"]
    bpy.ops.wm.open_mainfile(filepath=str(out))
    obj = bpy.data.objects["Ball"]
    (material,) = surface_of(obj).data.materials
    images = {node.image.name for node in material.node_tree.nodes if node.type == "TEX_IMAGE"}
    assert images == {"Ball_colour.exr", "Ball_normal.exr", "Ball_height.exr"}
    assert np.ptp(np.array(bpy.data.images["Ball_colour.exr"].pixels[:])) > 0.3
    # A bake of the saved file shows the pattern again.
    flags = ["--uv-map", "Synch Bake", "--size", 32, "--samples", 1, "--maps", "mask", "--folder", tmp_path]
    assert run(capfd, "bake", out, "--object", "Ball", *flags)[0] == 0
    assert (tmp_path / "Ball_mask.png").exists()


FAILURES = {
    "no pattern": (["--object", "Plain", "--folder", "."], "Plain has no pattern: solve stripes or quads on it first"),
    "no UV map": (["--object", "Ball", "--folder", "."], "has no UV map: choose one of its maps (none yet)"),
    "folder": (["--object", "Ball", "--unwrap", "--folder", "/dev/null"], "no folder can be made"),
    "nowhere": (["--object", "Ball", "--unwrap"], "the images have nowhere to go: add --folder"),
    "map": (["--object", "Ball", "--maps", "colour,smell", "--folder", "."], "the map 'smell' is unknown"),
    "size": (["--object", "Ball", "--size", "3", "--folder", "."], "the size is 3: give a whole number from 16"),
    "output": (["--object", "Ball", "--unwrap", "--output", "out.obj"], "must end in .blend"),
    "object": (["--object", "Third", "--folder", "."], "there is no mesh object 'Third'"),
}


@pytest.mark.parametrize("name", FAILURES)
def test_failures_are_one_line_and_write_nothing(name, striped, tmp_path, capfd, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arguments, reason = FAILURES[name]
    status, out, err = run(capfd, "bake", striped, *arguments, "--quiet")
    assert status == 1 and out == ""
    (line,) = [line for line in err.splitlines() if line.startswith("synch bake: ")]
    assert reason in line
    assert not list(tmp_path.iterdir())


def test_the_open_file_is_baked_by_blenders_command(tmp_path):
    obj = sphere(2)
    api.stripes(obj, spacing=0.7)
    flags = ["--unwrap", "--size", "16", "--samples", "1", "--maps", "index", "--folder", str(tmp_path)]
    assert main.main(["bake", *flags], loaded=True) == 0
    assert [p.name for p in tmp_path.iterdir()] == [f"{obj.name}_index.png"]
