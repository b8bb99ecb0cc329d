# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command batch: rows of the command line in warm processes, as they are without it."""

import json
import os
from pathlib import Path

import bpy
import pytest

from synch_fields.core.batch.rows import Row
from synch_fields.synch_addon.command import batch, main
from synch_fields.synch_addon.command.declared_files import declared_files

from ..run_commands import run
from ..scenes import sphere

SUMMARY = "out/rows.batch/summary.csv"


@pytest.fixture(scope="module")
def ball(tmp_path_factory, extension):
    """A sphere in a file."""
    bpy.ops.wm.read_homefile(use_empty=True)
    sphere()
    path = tmp_path_factory.mktemp("ball") / "ball.obj"
    bpy.ops.wm.obj_export(filepath=str(path), export_triangulated_mesh=True)
    return path


def written(path, *rows):
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    return path


def figures(path):
    """A report without what differs from run to run."""
    report = json.loads(Path(path).read_text())
    return {name: value for name, value in report.items() if name not in ("times", "peak_memory_mb")}


@pytest.mark.any_surface
@pytest.mark.full_search
def test_rows_are_done_as_alone_whatever_came_before_and_once(ball, tmp_path, monkeypatch, capfd):
    """By a warm process; alone in this one."""
    monkeypatch.chdir(tmp_path)
    one = {"command": "directions", "input": str(ball), "symmetry": "cross"}
    other = {"command": "stripes", "input": str(ball), "spacing": 0.4, "report": "new/{stem}.json"}
    rows = written(
        tmp_path / "rows.jsonl",
        one | {"report": "one.json", "export_field": "one.rosy"},
        other,
        {"command": "stripes", "input": "absent.obj"},
        {"command": "batch", "input": "rows.jsonl"},
        one | {"report": "two.json", "export_field": "two.rosy"},
    )
    status, out, err = run(capfd, "batch", rows, "--jobs", 1)
    assert status == 1 and "2 of 5 rows failed, see out/rows.batch/summary.csv" in err and "rows 0%" in err
    assert out.startswith("5 rows: 3 done in ")
    assert figures("one.json") == figures("two.json")
    assert Path("one.rosy").read_bytes() == Path("two.rosy").read_bytes()
    table = json.loads(Path("out/rows.batch/summary.json").read_text())
    assert [row["state"] for row in table] == ["done", "done", "failed", "failed", "done"]
    assert table[2]["reason"] == "absent.obj: no such file" and "cannot be a batch" in table[3]["reason"]
    report = json.loads(Path("new/ball.json").read_text())
    assert table[1]["energy"] == report["energy"] and table[1]["dislocations"] == len(report["dislocations"])
    assert table[1]["files"] == {"new/ball.json": Path("new/ball.json").stat().st_size}
    assert run(capfd, "stripes", ball, "--spacing", 0.4, "--report", "alone.json")[0] == 0
    assert figures("alone.json") == figures("new/ball.json")
    _, out, _ = run(capfd, "batch", rows, "--jobs", 1)
    assert out.startswith("5 rows: 0 done in ") and " 3 before" in out


def test_a_pattern_with_a_shared_command_and_shares_of_it(ball, tmp_path, monkeypatch, capfd):
    """Planned and answered in this process: what a warm one is told, and what it does with it."""
    monkeypatch.chdir(tmp_path)
    for name in ("a", "b", "c"):
        (tmp_path / f"{name}.obj").write_bytes(ball.read_bytes())
    monkeypatch.setattr(batch.child_loop, "ProcessPool", Here)
    flags = ["--folder", "done"]
    rows = ["--", "info", "--report", "{stem}.json"]
    status, out, _ = run(capfd, "batch", "*.obj", *flags, "--share", "1/2", *rows)
    assert status == 0 and out.startswith("1 row: 1 done") and not (tmp_path / "done" / "summary.csv").exists()
    status, out, _ = run(capfd, "batch", "*.obj", *flags, *rows)
    assert status == 0 and out.startswith("3 rows: 2 done") and "1 before" in out
    assert [json.loads((tmp_path / f"{name}.json").read_text())["vertices"] for name in "abc"]
    (tmp_path / "b.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    status, out, _ = run(capfd, "batch", "*.obj", *flags, *rows)
    assert out.startswith("3 rows: 1 done"), "the file has changed"
    assert json.loads((tmp_path / "b.json").read_text())["vertices"] == 3


class Here:
    """A pool that is this process."""

    capacity = 1

    def __init__(self, *_):
        self._answers = []
        self._way = batch.Way(
            lambda line: main._parse_row(main._parser(False), line), main.declared_files, main._carry_out_row
        )

    def start(self, task):
        self._answers.append((task, batch._answer(task, self._way)))

    def answer(self, _seconds):
        return self._answers.pop()

    def end(self):
        pass


def test_pictures_come_small_on_the_sheet(ball, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(batch.child_loop, "ProcessPool", Here)
    monkeypatch.setattr(
        main, "_write_outputs", lambda made, options, _progress: draw(made, getattr(options, "render", None))
    )
    rows = written(
        tmp_path / "rows.jsonl",
        {"command": "info", "input": str(ball)},
        {"command": "stripes", "input": str(ball), "spacing": 0.5, "render": "p.png"},
    )

    def draw(made, path):
        if path:
            image = bpy.data.images.new("picture", 640, 480)
            image.filepath_raw, image.file_format = str(tmp_path / path), "PNG"
            image.save()
        return made._replace(written=[path] if path else [])

    status, _, err = run(capfd, "batch", rows)
    assert status == 0, err
    (small,) = (tmp_path / "out" / "rows.batch" / "thumbnails").iterdir()
    image = bpy.data.images.load(str(small))
    assert tuple(image.size) == (320, 240) and image.file_format == "JPEG"
    assert "data:image/jpeg;base64," in (tmp_path / "out" / "rows.batch" / "sheet.html").read_text()


def test_another_version_of_a_process_is_refused(monkeypatch):
    monkeypatch.setattr(batch, "versions", lambda: {"numpy": "2.0"})
    task = {"versions": {"numpy": "1.9"}, "key": "0", "arguments": [], "working_folder": ".", "folder": "."}
    answer = batch._answer(task, None)
    assert answer == {"failed": "numpy is 2.0 here and 1.9 where the batch began: install the same"}


@pytest.mark.parametrize(
    "flags, reason",
    [
        (["absent.jsonl"], "absent.jsonl: no such file of rows"),
        (["x", "--jobs", 0], "--jobs is 0"),
        (["x", "--retries", -1], "--retries is -1"),
        (["x", "--limit", 0], "--limit is 0"),
        (["*.none", "--", "stripes"], "no file matches"),
        (["rows.jsonl", "--share", "5/4"], "the share is '5/4'"),
        (["same.jsonl"], "rows 1 and 2 both write a.json"),
    ],
)
def test_a_batch_that_cannot_be_is_one_line(flags, reason, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "rows.jsonl", {"command": "info"})
    written(tmp_path / "same.jsonl", *[{"command": "info", "report": "a.json", "object": name} for name in "ab"])
    status, out, err = run(capfd, "batch", *flags)
    assert status == 1 and out == "" and reason in err and err.count("\n") == 1


def test_all_files_that_a_row_reads_count(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for number in (1, 2):
        (tmp_path / f"smoke_{number:04}.vdb").touch()
    parser = main._parser(False)

    def inputs(*line):
        return [file.path for file in declared_files(parser.parse_args(line)) if not file.is_written]

    guidance = 'axis:Y=2,file:"b, c.rosy"=3,file:d.rosy'
    found = inputs("stripes", "a.obj", "--guidance", guidance, "--constraints", "e.json")
    assert found == ["a.obj", "e.json", "b, c.rosy", "d.rosy"]
    assert inputs("clebsch", "smoke_####.vdb") == ["smoke_0001.vdb", "smoke_0002.vdb"]


def test_what_a_row_says_aloud_does_not_count():
    way = batch.Way(lambda line: main._parse_row(main._parser(False), line), main.declared_files, None)
    rows = [batch._row_of(["stripes", "a.obj", *more], way) for more in ([], ["--quiet"], ["--spacing=1"])]
    assert isinstance(rows[0], Row) and rows[0].options == rows[1].options != rows[2].options


# Rows that no batch can do, as they stand in a file.
POISON = [
    b'{"command": "=cmd|\' /C calc\'!A0", "input": "@SUM(1)"}',
    b'{"command": "stripes", "input": "<script>alert(1)</script>.obj"}',
    b'{"command":',
    b"[1, 2]",
    b"null",
    b"[" * 100_000,
    b'{"command": "info", "input": "' + b"9" * 10_000 + b'.obj"}',
    b'{"command": "info", "input": {"a": 1}}',
    b'{"command": "batch", "input": "-"}',
    b'{"command": "info", "help": true}',
    b'{"command": ""}',
    b'{"command": "--help"}',
    b'{"command": "info", "input": "ball.obj", "": "x"}',
    b'{"command": "info", "input": "ball\\u0000.obj"}',
    b'{"command": "info", "input": "ball\\ud800.obj"}',
    b'{"command": "info", "input": "ball.obj", "object": "\\udfff"}',
    b'{"command": "info", "input": "ball.obj", "report": "a\\u0000b.json"}',
    b'{"command": "info", "input": "a\\nb.obj"}',
    b'{"command": "info", "input": "ball\xff.obj"}',
    b'{"command": "info", "input": "pipe.obj"}',
    b'{"command": "stripes", "input": "ball.obj", "constraints": "pipe.obj"}',
    b'{"command": "stripes", "input": "ball.obj", "guidance": "file:/dev/zero"}',
    b'{"command": "layers", "input": "ball.obj", "machine": "/dev/zero"}',
    b'{"command": "info", "input": "ball.obj", "report": "ball.obj/r.json"}',
    b'{"command": "stripes", "input": "ball.obj", "spacing": NaN}',
    b'{"command": "stripes", "input": "ball.obj", "method": "spectral", "seed": 1' + b"0" * 300 + b"}",
    b'{"command": "animate", "input": "ball.obj", "frames": [1, 2], "chunk": 0}',
]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_rows_of_every_bad_kind_fail_alone(ball, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(batch.child_loop, "ProcessPool", Here)
    Path("ball.obj").write_bytes(ball.read_bytes())
    os.mkfifo("pipe.obj")
    good = b'{"command": "info", "input": "ball.obj", "report": "new/%d.json"}'
    Path("rows.jsonl").write_bytes(b"\n".join([good % 1, *POISON, good % 2]))
    status, out, err = run(capfd, "batch", "rows.jsonl", "--retries", 0, "--quiet")
    assert status == 1 and err.strip().endswith(f"{len(POISON)} of {len(POISON) + 2} rows failed, see {SUMMARY}")
    assert out.startswith(f"{len(POISON) + 2} rows: 2 done")
    table = json.loads(Path("out/rows.batch/summary.json").read_text())
    assert [row["state"] for row in table] == ["done", *["failed"] * len(POISON), "done"]
    for row in table[1:-1]:
        assert row["reason"] and row["reason"].isprintable() and row["label"].isprintable(), row
        assert "Error" not in row["reason"].split(":")[0], row
    assert sorted(os.listdir("new")) == ["1.json", "2.json"]
    sheet = Path("out/rows.batch/sheet.html").read_text()
    assert "<script" not in sheet and sheet.count("<tr><td>") == len(POISON)
    assert "\n'=cmd" not in Path(SUMMARY).read_text() and ",'=cmd" in Path(SUMMARY).read_text()
