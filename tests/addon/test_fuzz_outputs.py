# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that commands have written, as inputs of commands and in their places: read or refused, never replaced."""

import sys
import tempfile
from contextlib import chdir
from functools import cache
from pathlib import Path

import pytest

from synch_fields.synch_addon.blender import files

from .fuzz_cases import command_line, empty_scene, mostly, st, tried
from .scenes import sphere
from .solid_objects import block
from .vortex_scenes import write_npz

# Names that files of a suffix are called by: some of them are one file, or belong to one numbered set.
CALLED = ("a{}", "./a{}", "sub/../a{}", "link{}", "part{}", "part_000{}", "./part_0001{}", "new/b{}", "new/../new/b{}")
MESHES = (".obj", ".stl", ".ply")
# Suffixes of the files that a command reads and writes, by their flags; "" is the input.
FILES = {
    "info": {"": MESHES, "--report": [".json"]},
    "stripes": {
        "": MESHES,
        "--constraints": [".json"],
        "--guidance": [".rosy"],
        "--report": [".json"],
        "--output": [".blend"],
        "--export-field": [".rosy"],
    },
    "quad_mesh": {"": MESHES, "--constraints": [".json"], "--export-mesh": MESHES, "--report": [".json"]},
    "layers": {
        "": MESHES,
        "--export-layers": MESHES,
        "--export-mesh": MESHES,
        "--export-paths": [".csv", ".obj", ".gcode"],
        "--export-gcode": [".gcode"],
        "--report": [".json"],
    },
}
# Flags of files that are read, and what makes a command quick.
READ = ("", "--constraints", "--guidance")
QUICK = {
    "stripes": ["--method", "spectral", "--spacing", "0.7"],
    "quad_mesh": ["--method", "spectral", "--spacing", "0.7", "--smoothing", "0"],
    "layers": ["--method", "spectral", "--spacing", "1.5", "--size", "0.7"],
}


@st.composite
def commands(draw):
    """A command, and the name of a file for some of its flags."""
    command = draw(st.sampled_from(sorted(FILES)))
    named = {}
    for flag, suffixes in FILES[command].items():
        if not flag or draw(st.booleans()):
            named[flag] = draw(st.sampled_from(CALLED)).format(draw(st.sampled_from(suffixes)))
    return command, named


@cache
def given_files():
    """What is in a folder before a command runs: contents by names."""
    empty_scene()
    obj = sphere(1)
    found = {"a.json": b"[]\n", "a.rosy": b"20\n2\n" + 20 * b"1 0 0\n", "a.csv": b"table", "a.gcode": b"G28"}
    with tempfile.TemporaryDirectory() as folder:
        for suffix in MESHES:
            files.export_mesh(obj, Path(folder) / f"a{suffix}")
            found[f"a{suffix}"] = found[f"part_000{suffix}"] = (Path(folder) / f"a{suffix}").read_bytes()
    return found


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
@tried(commands())
def test_no_command_writes_over_a_file_of_its_own(case):
    command, named = case
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        Path("sub").mkdir()
        for name, content in given_files().items():
            Path(name).write_bytes(content)
            if name.startswith("a."):
                Path(f"link.{name[2:]}").symlink_to(name)
        read = {flag: Path(name) for flag, name in named.items() if flag in READ and Path(name).exists()}
        before = {path: path.read_bytes() for path in read.values()}
        guided = {flag: f"file:{name}=1" if flag == "--guidance" else name for flag, name in named.items()}
        flags = [part for flag, name in guided.items() if flag for part in (flag, name)]
        status = command_line(f"files of {command}", command, named[""], *flags, *QUICK.get(command, ()))
        assert all(path.read_bytes() == content for path, content in before.items())
        if status:
            return
        written = [Path(name) for flag, name in named.items() if flag not in (*READ, "--export-layers")]
        layers = Path(named.get("--export-layers", "none"))
        written += layers.parent.glob(f"{layers.stem}_[0-9][0-9][0-9]*{layers.suffix}")
        places = {path.resolve(strict=True) for path in written}
        assert len(places) == len(written) and ("--export-layers" not in named or layers.parent.exists())
        assert not places & {path.resolve() for path in before}


# Command lines that write files of all kinds, from ball.obj, cube.stl and ring.npz.
WRITING = [
    "info ball.obj --report info.json",
    "stripes ball.obj --spacing 0.7 --output stripes.blend --report stripes.json --export-field stripes.rosy",
    "directions ball.obj --export-field directions.rawfield",
    "quad_mesh ball.obj --spacing 0.7 --export-mesh quads.obj --output quads.blend",
    "quad_mesh ball.obj --spacing 0.7 --export-mesh quads.ply",
    "isolines ball.obj --spacing 0.7 --radius 0.1 --export-mesh lines.stl",
    "layers cube.stl --spacing 0.6 --size 0.3 --export-layers part.obj --export-paths paths.csv --export-volume v.vdb",
    "layers cube.stl --spacing 0.6 --size 0.3 --export-gcode part.gcode --output layers.blend --report layers.json",
    "layers cube.stl --spacing 0.6 --size 0.3 --export-paths paths.obj",
    "clebsch ring.npz --quantum 1 --target-gap 0.05 --show filaments --export-filaments ring.vtp --output ring.blend",
    "clebsch ring.npz --quantum 1 --target-gap 0.05 --show filaments --export-filaments ring.csv",
    "bake stripes.blend --folder baked --size 16 --maps mask,height",
    "batch info.json --folder rows",
]
# Command lines that read a file, and the suffixes that they take; FILE stands for it.
READING = [
    ("info FILE", ".blend .obj .ply .stl .glb"),
    ("stripes FILE --spacing 0.7", ".blend .obj .ply .stl"),
    ("quad_mesh FILE --spacing 0.7", ".blend .obj .ply .stl"),
    ("layers FILE --spacing 0.6 --size 0.3", ".blend .stl .mesh .vtu"),
    ("clebsch FILE --quantum 1 --target-gap 0.05", ".blend .npz .vdb"),
    ("animate FILE --spacing 0.7 --frames 1 2", ".blend"),
    ("bake FILE --folder baked --size 16", ".blend"),
    ("stripes ball.obj --spacing 0.7 --constraints FILE", ".json"),
    ("stripes ball.obj --spacing 0.7 --guidance file:FILE=1", ".rosy .rawfield"),
    ("layers cube.stl --spacing 0.6 --size 0.3 --export-gcode part.gcode --machine FILE", ".toml"),
    ("layers cube.stl --spacing 0.6 --size 0.3 --guidance file:FILE", ".sol .vtu .csv"),
    ("layers cube.stl --spacing 0.6 --size 0.3 --guidance lines:FILE:circulation", ".vtu .vtp"),
    ("batch FILE --folder again", ".json .jsonl"),
]


@cache
def inputs():
    """Contents of ball.obj, cube.stl and ring.npz."""
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        for made, name in ((sphere, "ball.obj"), (block, "cube.stl")):
            empty_scene()
            files.export_mesh(made(), name)
        write_npz("ring.npz")
        return {str(path): path.read_bytes() for path in Path().iterdir()}


def write_inputs():
    """Write ball.obj, cube.stl and ring.npz where we are."""
    for name, content in inputs().items():
        Path(name).write_bytes(content)


@cache
def written_files():
    """Contents of all files that the commands write, by their names."""
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        write_inputs()
        for line in WRITING:
            command_line("written to be read", *line.split())
        return {str(path): path.read_bytes() for path in sorted(Path().rglob("*")) if path.is_file()}


@st.composite
def readings(draw):
    """A command line, the number of a written file, and the suffix that it gets; "" for its own."""
    line, suffixes = draw(st.sampled_from(READING))
    return line, draw(st.integers(0, 99)), draw(mostly(st.sampled_from(suffixes.split()), st.just("")))


@tried(readings())
def test_any_written_file_is_read_or_refused_and_stays_as_it_is(case):
    line, number, suffix = case
    written = written_files()
    name = sorted(written)[number % len(written)]
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        write_inputs()
        path = Path(f"given{suffix or Path(name).suffix}")
        path.write_bytes(written[name])
        command, *arguments = line.replace("FILE", str(path)).split()
        command_line(f"own files for {command}", command, *arguments)
        assert path.read_bytes() == written[name]


def test_what_is_written_covers_all_kinds():
    suffixes = {Path(name).suffix for name in written_files()}
    assert suffixes >= {".blend", ".json", ".rosy", ".rawfield", ".obj", ".ply", ".stl", ".csv", ".gcode", ".vdb"}
    assert suffixes >= {".vtp", ".png", ".html"}
