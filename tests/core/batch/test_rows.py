# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of a batch: what a line or a pattern stands for, keys, and shares."""

import json

import pytest

from synch_fields.core.batch.rows import Keys, Row, read_rows, share_of
from synch_fields.core.errors import SettingError
from synch_fields.core.files.declared import DeclaredFile


def written(path, *rows):
    path.write_text("".join(f"{row if isinstance(row, str) else json.dumps(row)}\n" for row in rows))
    return path


def test_a_line_is_a_command_with_a_flag_for_each_key(tmp_path):
    row = {"command": "stripes", "input": "a/spot.obj", "spacing": 0.05, "strict": True, "quiet": False, "seed": None}
    row |= {"view": [40, -5], "export_field": "{stem}.rosy"}
    (line,) = read_rows(written(tmp_path / "rows.jsonl", row, ""))
    assert line == [
        "stripes",
        "a/spot.obj",
        "--spacing=0.05",
        "--strict",
        "--view",
        "40",
        "-5",
        "--export-field=spot.rosy",
    ]


def test_negative_numbers_stay_values_of_their_flags(tmp_path):
    (line,) = read_rows(written(tmp_path / "rows.jsonl", {"command": "stripes", "angle": -30.5}))
    assert line == ["stripes", "--angle=-30.5"]


def test_a_pattern_gives_a_row_for_each_file_in_order(tmp_path):
    for name in ("b.obj", "a.obj", "c.ply"):
        (tmp_path / name).touch()
    lines = list(read_rows(str(tmp_path / "*.obj"), ["directions", "--report", "{stem}.json"]))
    assert [line[3] for line in lines] == ["a.json", "b.json"]
    assert lines[0][:3] == ["directions", str(tmp_path / "a.obj"), "--report"]


def test_frames_go_out_in_contiguous_chunks_that_cover_them_once(tmp_path):
    row = {
        "command": "animate",
        "input": "walk.blend",
        "frames": [1, 10],
        "chunk": 4,
        "spacing": 1,
        "output": "w.{first}-{last}.blend",
    }
    lines = list(read_rows(written(tmp_path / "rows.jsonl", row)))
    assert [line[2:5] for line in lines] == [["--frames", "1", "4"], ["--frames", "5", "8"], ["--frames", "9", "10"]]
    assert [line[6] for line in lines] == [
        "--output=w.0001-0004.blend",
        "--output=w.0005-0008.blend",
        "--output=w.0009-0010.blend",
    ]


@pytest.mark.parametrize(
    "line, reason",
    [
        ("{", "line 2: this is not JSON"),
        ("[]", "this is not a row"),
        ('{"input": "a.obj"}', "this is not a row"),
        ('{"command": "animate", "chunk": 4}', "the frames are None"),
        ('{"command": "animate", "chunk": 0, "frames": [1, 4]}', "the chunk 0"),
        ('{"command": "animate", "chunk": 2, "frames": [1, 4]}', "a spacing of its own"),
        ('{"command": "stripes", "spacing": {}}', "spacing is {}"),
    ],
)
def test_a_line_that_is_no_row_is_told_and_the_others_stay(line, reason, tmp_path):
    first, second, third = read_rows(written(tmp_path / "rows.jsonl", {"command": "info"}, line, {"command": "demo"}))
    assert (first, third) == (["info"], ["demo"])
    assert isinstance(second, SettingError) and reason in str(second) and "rows.jsonl, line 2" in str(second)


def test_a_row_that_is_not_utf_8_is_told_and_the_others_stay(tmp_path):
    path = tmp_path / "rows.jsonl"
    path.write_bytes(b'\xef\xbb\xbf{"command": "info"}\n{"command": "\xff"}\n{"command": "demo"}\n')
    first, second, third = read_rows(path)
    assert (first, third) == (["info"], ["demo"])
    assert isinstance(second, SettingError) and "line 2: this is not UTF-8" in str(second)


@pytest.mark.parametrize(
    "jobs, shared, reason",
    [
        ("absent.jsonl", [], "no such file"),
        ("*.nothing", ["stripes"], "no file matches"),
        ("*", ["--spacing"], "where a command is needed"),
    ],
)
def test_what_gives_no_rows_is_refused(jobs, shared, reason, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SettingError, match=reason):
        list(read_rows(jobs, shared))


def test_keys_tell_contents_options_commands_and_versions_apart(tmp_path):
    mesh = tmp_path / "mesh.obj"
    mesh.write_text("v 0 0 0\n")

    def key(command="stripes", versions=("1",), **options):
        return Keys(versions).of(Row((command,), {"spacing": 1.0} | options, (DeclaredFile(str(mesh), "the input"),)))

    first = key()
    assert first == key() and len(first) == 32
    others = [key("quads"), key(spacing=2.0), key(versions=("2",))]
    mesh.write_text("v 0 0 1\n")
    others.append(key())
    mesh.unlink()
    others.append(key())
    assert len({first, *others}) == 6


@pytest.mark.parametrize("parts", [1, 3, 7, 20])
def test_shares_are_contiguous_and_cover_all_rows_once(parts):
    shares = [list(share_of(range(17), f"{part}/{parts}")) for part in range(1, parts + 1)]
    assert [row for share in shares for row in share] == list(range(17))
    assert max(map(len, shares)) - min(map(len, shares)) <= 1


@pytest.mark.parametrize("text", ["0/3", "4/3", "3", "a/b", "-1/3"])
def test_a_share_that_is_none_is_refused(text):
    with pytest.raises(SettingError, match="write 3/40"):
        share_of(range(9), text)
