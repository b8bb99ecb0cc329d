# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hostile names, rows, settings and special files: each is taken or refused in one line, and shows as text only."""

import csv
import json
import os
import re
import socket
import sys
import tempfile
from contextlib import chdir, contextmanager, suppress
from html.parser import HTMLParser
from pathlib import Path

import bpy
import pytest

from synch_fields.core.batch.records import Records
from synch_fields.core.batch.rows import read_rows
from synch_fields.core.batch.run import plan, run_rows
from synch_fields.core.batch.sheet import write_sheet
from synch_fields.core.batch.table import write_tables
from synch_fields.core.errors import SettingError
from synch_fields.core.files.json_text import json_text
from synch_fields.core.printing.machine import Machine, read_machine
from synch_fields.synch_addon import api
from synch_fields.synch_addon.command import batch, main
from synch_fields.synch_addon.command.declared_files import declared_files
from synch_fields.synch_addon.jobs.report import summary

from .fuzz_cases import (
    COUNTS,
    check_line,
    command_line,
    empty_scene,
    mostly,
    read_or_refused,
    solved_or_refused,
    st,
    tried,
)
from .fuzz_texts import hostile_texts, json_values, numbers
from .scenes import add_attribute, add_group, grid
from .test_fuzz_outputs import write_inputs

SOLVED = {"spacing": 0.7, "method": "spectral"}
FLAGS = ["--spacing", "0.7", "--method", "spectral"]


def named(holder, text):
    """Give something in Blender a name, where Blender takes it."""
    with suppress(UnicodeError, ValueError, TypeError):
        holder.name = text


@tried(st.lists(hostile_texts, min_size=7, max_size=7), st.sampled_from(["stripes", "quads", "quad_mesh"]))
def test_any_names_in_a_scene_are_taken_and_told_in_one_line(texts, command):
    empty_scene()
    obj = grid(6)
    material = bpy.data.materials.new("Mine")
    obj.data.materials.append(material)
    add_group(obj, "some", range(9))
    add_attribute(obj.data, "mine", "FLOAT_VECTOR", "FACE", 1)
    group, attribute = obj.vertex_groups["some"], obj.data.attributes["mine"]
    layer = obj.data.uv_layers.new(name="UV")
    for holder, text in zip((obj, obj.data, material, group, attribute, layer, bpy.context.scene), texts, strict=True):
        named(holder, text)
    guide = f"{'offset' if len(texts[0]) % 2 else 'attribute'}:{obj.vertex_groups[0].name}"
    for guidance in ("smooth", guide):
        report = solved_or_refused("names", lambda given=guidance: getattr(api, command)(obj, guidance=given, **SOLVED))
        if report is not None:
            assert json.loads(json_text(report))["status"]
            for line in (*report["warnings"], *summary(report)):
                assert "\n" not in line.strip()
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        Path("in").mkdir()
        with chdir("in"):
            arguments = ["--object", obj.name, *FLAGS, "--export-mesh", "a.obj"]
            with main_with_open_file():
                command_line("named objects", "quad_mesh", *arguments)
        assert os.listdir() == ["in"]


@contextmanager
def main_with_open_file():
    """Let command lines work on the file that is open."""
    from . import fuzz_cases

    kept = fuzz_cases.main
    fuzz_cases.main = lambda arguments: main.main(arguments, loaded=True)
    try:
        yield
    finally:
        fuzz_cases.main = kept


@tried(st.tuples(hostile_texts, hostile_texts, hostile_texts))
def test_any_names_of_files_are_taken_or_refused(texts):
    source, report, mesh = texts
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        write_inputs()
        Path("deep/er").mkdir(parents=True)
        Path("ball.obj").rename("deep/ball.obj")
        with chdir("deep/er"):
            name = f"{source.replace('/', '')}.obj"
            with suppress(OSError, ValueError):
                Path(name).write_bytes(Path("../ball.obj").read_bytes())
            outputs = ["--report", f"{report.lstrip('/')}.json", "--export-mesh", f"{mesh.lstrip('/')}.ply"]
            status = command_line("file names", "quad_mesh", name, *FLAGS, *outputs)
            written = [Path(name) for name in outputs[1::2]]
            if status == 0:
                assert all(path.stat().st_size for path in written)
                json.loads(written[0].read_text())


@tried(
    st.sampled_from(["guidance", "boundary", "mirror", "spacing_map", "symmetry", "other"]),
    hostile_texts | numbers,
    st.sampled_from(["", "axis:X,", "offset:", "file:", "attribute:", "strokes:"]),
)
def test_any_text_of_a_setting_is_taken_or_refused(name, value, before):
    empty_scene()
    obj = grid(6)
    given = before + value if isinstance(value, str) else value
    solved_or_refused("texts of settings", lambda: api.stripes(obj, **(SOLVED | {name: given})))


@tried(st.sampled_from(sorted({"--guidance", "--mirror", "--spacing", "--object", "--seed"})), hostile_texts)
def test_any_text_of_a_flag_is_taken_or_refused(flag, text):
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        write_inputs()
        command_line("texts of flags", "stripes", "ball.obj", *FLAGS, f"{flag}={text}")


# Rows of batches.

KEYS = ["command", "input", "spacing", "method", "report", "frames", "chunk", "constraints", "guidance", "object"]
ROWS = st.fixed_dictionaries(
    {"command": mostly(st.sampled_from(["info", "stripes"]), hostile_texts)},
    optional={
        "input": mostly(st.sampled_from(["ball.obj", "absent.obj"]), hostile_texts | json_values(KEYS)),
        "report": hostile_texts.map(lambda text: f"{text.lstrip('/')}.json"),
        "object": hostile_texts,
        "chunk": numbers,
        "frames": st.lists(numbers, max_size=3),
    },
)


@st.composite
def row_files(draw):
    """Lines of a file of rows as bytes: JSON, now and then not, and now and then not UTF-8."""
    lines = draw(st.lists(ROWS | json_values(KEYS), min_size=1, max_size=4))
    encoded = [_dumped(line).encode(draw(st.sampled_from(["utf-8", "utf-16"]))) for line in lines]
    odd = st.sampled_from([b"\xff\xfe{", b"\0", b"[" * 5000, b'{"command": ' + b"1" * 5000 + b"}", b"\xed\xa0\x80"])
    return b"\n".join([*encoded, *draw(st.lists(odd | st.binary(max_size=40), max_size=2))])


def _dumped(line):
    try:
        return json.dumps(line)
    except ValueError:  # a number of thousands of digits
        return "1" * 5000


class OneAfterTheOther:
    """Does the rows of a batch in this process."""

    capacity = 1

    def __init__(self, way):
        self._way, self._task = way, None

    def start(self, task):
        self._task = task

    def answer(self, _seconds):
        return self._task, batch._answer(self._task, self._way)


class _Tags(HTMLParser):
    """Collects the tags of a page."""

    def __init__(self, text):
        super().__init__()
        self.found = set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.add(tag)


@tried(row_files())
def test_any_rows_are_done_or_fail_alone(content):
    parser = main._parser(False)
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        write_inputs()
        Path("rows.jsonl").write_bytes(content + b'\n{"command": "info", "input": "cube.stl"}\n')
        Path("out").mkdir()
        way = batch.Way(lambda line: main._parse_row(parser, line), declared_files, main._carry_out_row)
        try:
            rows = plan(read_rows("rows.jsonl"), lambda line: batch._row_of(line, way), batch.versions())
        except SettingError as error:  # two rows that write one file
            check_line(str(error))
            COUNTS["files of rows refused"] += 1
            return
        records = Records("out")
        records.make_folders()
        run_rows(rows, records, OneAfterTheOther(way), 0, batch.versions(), lambda *_: None)
        Path("ball.obj").unlink()  # rows have left the folder as it was
        (table, listed), done = write_tables(Path("out"), rows, records)
        write_sheet("out/sheet.html", f"rows {rows[0].label}", rows, records)
        entries = json.loads(Path(listed).read_text(), parse_constant=pytest.fail)
        assert entries[-1]["state"] == "done" and done >= 1
        for entry in entries:
            COUNTS[f"rows {entry['state']}"] += 1
            if entry["state"] == "failed":
                check_line(entry["reason"])
        with open(table, newline="", encoding="utf-8") as file:
            cells = [cell for row in csv.reader(file) for cell in row]
        assert not [cell for cell in cells if re.match(r"[=+@\t\r]|-\D", cell)]
        assert not _Tags(Path("out/sheet.html").read_text()).found & {"script", "b2"}


# Machine files.

MACHINE_KEYS = sorted(Machine.__dataclass_fields__)


def _toml(value):
    """A value in TOML, or nearly."""
    try:
        if isinstance(value, list):
            return f"[{', '.join(map(_toml, value))}]"
        if isinstance(value, dict):
            return "{" + ", ".join(f"{json.dumps(key)} = {_toml(item)}" for key, item in value.items()) + "}"
        return json.dumps(value, ensure_ascii=False)
    except ValueError:
        return "1" * 5000


@tried(
    st.dictionaries(mostly(st.sampled_from(MACHINE_KEYS), hostile_texts), json_values(MACHINE_KEYS), max_size=4),
    st.binary(max_size=3) | st.just(b""),
    often=True,
)
def test_any_machine_file_is_read_or_refused(values, more):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "machine.toml"
        lines = [f"{key} = {_toml(value)}\n" for key, value in values.items()]
        path.write_bytes("".join(lines).encode("utf-8", "surrogatepass") + more)
        read_or_refused("machine files", lambda: read_machine(path) and "read")


# What files and objects have kept as JSON.

CONSTRAINT_KEYS = ["kind", "vertices", "vertex", "angle", "degrees", "object", "weight", "group", "value", "direction"]


@tried(json_values(CONSTRAINT_KEYS))
def test_any_constraints_are_taken_or_refused(value):
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        write_inputs()
        Path("rows.json").write_text(_dumped(value))
        command_line("constraints", "stripes", "ball.obj", *FLAGS, "--constraints", "rows.json")


RESULT_KEYS = ["command", "energy", "lower_bound", "warnings", "spacing", "settings", "status", "symmetry", "format"]


@tried(json_values(RESULT_KEYS).filter(lambda value: value != {}), st.sampled_from(["result", "guides", "none"]))
def test_any_result_that_an_object_keeps_is_taken_or_refused(value, kind):
    empty_scene()
    obj = grid(6)
    api.stripes(obj, **SOLVED)
    text = _dumped(value)
    with suppress(UnicodeError, ValueError, TypeError):
        obj.synch.result = text
    # After halves of characters Blender leaves an error behind that shows anywhere.
    if isinstance(value, int | float) or (isinstance(value, str) and value.isprintable()):
        with suppress(UnicodeError, ValueError, OverflowError, TypeError):
            obj["synch_extra"] = value
    for work in (lambda: api.isolines(obj), lambda: api.vary(obj, 1), lambda: api.stripes(obj, **SOLVED)):
        read_or_refused("kept results", lambda given=work: given() and "made")


# Devices, pipes, sockets and links in the place of files.

FILES = {"FILE": "", "--constraints FILE": ".json", "--guidance file:FILE": ".rosy", "--report FILE": ".json"}
FILES |= {"--output FILE": ".blend", "--export-field FILE": ".rosy"}
KINDS = ["fifo", "null", "zero", "full", "socket", "folder", "nowhere", "loop", "unreadable", "deep"]


@contextmanager
def special(path, kind):
    """Put something that is not a file in a place."""
    with socket.socket(socket.AF_UNIX) as bound:
        match kind:
            case "fifo":
                os.mkfifo(path)
            case "socket":
                bound.bind(str(path))
            case "folder":
                path.mkdir()
            case "unreadable":
                path.touch(0)
            case "deep":
                path.symlink_to("/".join(["x" * 200] * 15))
            case "nowhere":
                path.symlink_to("absent")
            case "loop":
                path.symlink_to(path.name)
            case _:
                path.symlink_to(f"/dev/{kind}")
        yield


@pytest.mark.skipif(sys.platform == "win32", reason="these are files of Unix")
@tried(st.sampled_from(sorted(FILES)), st.sampled_from(KINDS), st.sampled_from(["info", "stripes", "clebsch", "batch"]))
def test_any_device_or_pipe_is_refused_at_once(flag, kind, command):
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        write_inputs()
        suffix = {"clebsch": ".npz", "batch": ".jsonl"}.get(command, ".obj") if flag == "FILE" else FILES[flag]
        path = Path(f"given{suffix}")
        with special(path, kind):
            line = flag.replace("FILE", str(path)).split()
            if flag != "FILE":
                command, line = "stripes", ["ball.obj", *FLAGS, *line]
            status = command_line(f"special files: {kind}", command, *line)
        is_output = flag.split()[0] in ("--report", "--output", "--export-field")
        assert status or (is_output and kind in ("null", "zero", "nowhere", "unreadable", "deep", "loop"))
