# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A batch by processes of this machine: what is done is not done again, what fails is tried again, nothing is lost."""

import csv
import json
import os
import signal
import time

import pytest

from synch_fields.core.batch.child_loop import ProcessPool
from synch_fields.core.batch.rows import Row
from synch_fields.core.batch.run import Planned, plan, run_rows
from synch_fields.core.batch.sheet import write_sheet
from synch_fields.core.batch.table import entries, write_tables
from synch_fields.core.errors import SettingError
from synch_fields.core.files.declared import DeclaredFile

from .children import COMMAND, begun, rows, told


def run(wanted, records, count=1, retries=1, progress=told, limit=None):
    pool = ProcessPool(COMMAND, count, 1)
    try:
        return run_rows(wanted, records, pool, retries, {}, progress, limit)
    finally:
        pool.end()


def states(wanted, records):
    return [entry["state"] for entry in entries(wanted, records)]


def test_all_rows_are_done_once_and_not_again(records, tmp_path):
    wanted = rows(*["write"] * 12)
    assert run(wanted, records, 2) == (0, 12)
    assert sorted(begun(tmp_path)) == [row.key for row in wanted]
    assert run(wanted, records, 2) == (12, 0)
    assert len(begun(tmp_path)) == 12 and states(wanted, records) == ["done"] * 12


def test_one_process_does_many_rows(records):
    wanted = rows(*["write"] * 50)
    run(wanted, records)
    assert len({entry["pid"] for entry in entries(wanted, records)}) == 1


def test_a_row_whose_file_is_gone_or_another_is_done_again(records, tmp_path):
    wanted = rows("write", "write", "write")
    run(wanted, records)
    (tmp_path / "0.txt").unlink()
    (tmp_path / "2.txt").write_text("longer than it was")
    assert run(wanted, records) == (1, 2)
    assert (tmp_path / "2.txt").read_text() == "write"


def test_a_poisoned_row_is_tried_as_often_as_is_asked_and_only_it_is_lost(records, tmp_path):
    wanted = rows("write", "die", "write", "refuse", "die once", "write")
    assert run(wanted, records, 2, retries=2) == (0, 4)
    assert states(wanted, records) == ["done", "failed", "done", "failed", "done", "done"]
    found = list(entries(wanted, records))
    assert found[1]["tries"] == found[3]["tries"] == 3
    assert "signal 9" in found[1]["reason"] and found[3]["reason"] == "this row is refused"
    assert [begun(tmp_path).count(row.key) for row in wanted] == [1, 3, 1, 3, 2, 1]
    assert run(wanted, records, retries=2) == (4, 0), "what has failed as often as is asked is not tried again"
    run(wanted, records, retries=3)
    assert [begun(tmp_path).count(row.key) for row in wanted] == [1, 4, 1, 4, 2, 1]


def test_a_row_over_its_time_is_ended_and_told_and_the_others_go_on(records, tmp_path):
    wanted = rows("write", "hang", "write", "hang once", "write")
    started = time.monotonic()
    assert run(wanted, records, limit=4) == (0, 4)
    assert 12 <= time.monotonic() - started < 60, "three times over, by rows that would take ten minutes"
    assert states(wanted, records) == ["done", "failed", "done", "done", "done"]
    failed = list(entries(wanted, records))[1]
    assert (failed["tries"], failed["reason"]) == (2, "it took longer than 4 s")
    assert [begun(tmp_path).count(row.key) for row in wanted] == [1, 2, 1, 2, 1]


def test_a_limit_ends_nothing_that_is_in_time(records):
    wanted = rows(*["write"] * 30)
    assert run(wanted, records, limit=600) == (0, 30)
    assert len({entry["pid"] for entry in entries(wanted, records)}) == 1


def test_a_process_that_is_killed_from_outside_loses_only_its_row(records, tmp_path):
    wanted = rows(*["write"] * 3, "hang once", *["write"] * 4)
    killed = []

    def kill(*_):
        lines = (tmp_path / "begun.txt").read_text().splitlines() if (tmp_path / "begun.txt").exists() else []
        pids = [int(line.split()[1]) for line in lines if line.startswith(wanted[3].key)]
        if (tmp_path / "3.txt").exists() and pids and not killed:
            killed.append(pids[0])
            os.kill(pids[0], signal.SIGKILL)

    assert run(wanted, records, 2, progress=kill) == (0, 8)
    assert len(killed) == 1 and [begun(tmp_path).count(row.key) for row in wanted] == [1, 1, 1, 2, 1, 1, 1, 1]


def test_an_interrupted_batch_goes_on_where_it_was(records, tmp_path):
    wanted = rows(*["slow"] * 10)

    def stop(_stage, fraction):
        if fraction >= 0.4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(wanted, records, 1, progress=stop)
    done = states(wanted, records).count("done")
    assert 4 <= done < 10
    before, now = run(wanted, records)
    assert (before, now) == (done, 10 - done)
    assert all(begun(tmp_path).count(row.key) <= 2 for row in wanted)


def test_the_processes_end_with_the_batch(records):
    run(rows("write"), records)
    (entry,) = entries(rows("write"), records)
    with pytest.raises(ProcessLookupError):
        os.kill(entry["pid"], 0)


def test_a_process_ends_when_its_batch_is_killed(records, tmp_path):
    """Its pipe closes, whatever it is doing."""
    pool = ProcessPool(COMMAND, 1, 1)
    pool.start({"key": "0" * 32, "arguments": ["slow", "0.txt"], "working_folder": ".", "folder": "batch"})
    while not ((tmp_path / "begun.txt").exists() and (tmp_path / "begun.txt").read_text().strip()):
        time.sleep(0.01)
    pid = int((tmp_path / "begun.txt").read_text().split()[-1])
    pool._processes[0]._child.stdin.close()
    pool._processes[0]._child.wait(5)
    pool.end()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_a_process_has_its_threads_and_not_what_slows_its_memory(records, monkeypatch):
    """Dask sets the variable for its workers."""
    monkeypatch.setenv("MALLOC_TRIM_THRESHOLD_", "65536")
    run(rows("write"), records)
    (entry,) = entries(rows("write"), records)
    assert (entry["SYNCH_THREADS"], entry["MALLOC_TRIM_THRESHOLD_"]) == ("1", None)


def test_a_command_that_is_not_there_fails_its_rows(records):
    wanted = rows("write")
    pool = ProcessPool(["no-such-program"], 1, 1)
    try:
        run_rows(wanted, records, pool, 0, {}, told)
    finally:
        pool.end()
    assert next(entries(wanted, records))["reason"].startswith("its process cannot be started: no-such-program")


def understood(arguments):
    if arguments[0] == "wrong":
        raise SettingError("this command is wrong")
    files = [DeclaredFile(path, "--report", is_written=True) for path in arguments[2:]]
    return Row(tuple(arguments), {"n": arguments[1]}, tuple(files))


def test_a_plan_keeps_what_cannot_be_a_row_and_makes_no_folder(tmp_path):
    told = SettingError("no JSON")
    path = tmp_path / "new" / "a.txt"
    planned = plan([["info", "1", str(path)], ["wrong"], told], understood, {})
    assert not path.parent.exists()
    assert [row.key is None for row in planned] == [False, True, True]
    assert [row.content for row in planned[1:]] == ["this command is wrong", "no JSON"]


def test_two_rows_that_write_the_same_file_are_refused(tmp_path):
    lines = [["info", "1", str(tmp_path / "a")], ["info", "2", str(tmp_path / "b")], ["info", "3", f"{tmp_path}/./a"]]
    with pytest.raises(SettingError, match="rows 1 and 3 both write"):
        plan(lines, understood, {})
    with pytest.raises(SettingError, match="there are no rows"):
        plan([], understood, {})


def test_spoiled_records_count_as_not_there(records):
    wanted = rows("write", "write")
    run(wanted, records)
    for spoiled in ("[]", "5", "{}", "null", '{"files": 5, "seconds": 1}', "[" * 10**5, "{", "\ud800"):
        for kind in ("done", "failed"):
            path = records.folder / kind / wanted[0].key[:2] / f"{wanted[0].key}.json"
            path.write_text(spoiled, encoding="utf-8", errors="surrogatepass")
        assert states(wanted, records) == ["open", "done"], spoiled
    assert run(wanted, records) == (1, 1)


def test_records_of_names_that_no_file_has_count_as_not_there(records):
    key = "0" * 32
    records.keep_done(key, {"seconds": 1.0}, [])
    path = records.folder / "done" / "00" / f"{key}.json"
    assert records.done(key)
    path.write_text('{"files": {"a\\u0000b": 1}, "seconds": 1}')
    assert records.done(key) is None
    path.write_text('{"files": {}, "seconds": 1, "energy": "<b>"}')
    assert records.done(key) is None


def test_tables_and_sheets_take_any_text_and_run_none(records, tmp_path):
    """Cells that spreadsheets would take for formulas, tags, and halves of characters."""
    labels = [
        "=cmd|' /C calc'!A0",
        "@SUM(1)",
        "+1",
        "-x.blend",
        "\tx",
        "<img src=x onerror=alert(1)>",
        "\ud800",
        "plain",
    ]
    wanted = [Planned(label, None, f"=reason of {label}") for label in labels]
    (table, _), done = write_tables(records.folder, wanted, records)
    assert done == 0
    with open(table, newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert [line["label"] for line in lines[:5]] == [f"'{label}" for label in labels[:5]]
    assert [line["label"] for line in lines[5:]] == [labels[5], "\\ud800", "plain"]
    assert all(line["reason"].startswith("'=reason") for line in lines)
    write_sheet(tmp_path / "sheet.html", "<Rows>", wanted, records)
    assert "<img" not in (tmp_path / "sheet.html").read_text()


def test_numbers_below_zero_stay_numbers_in_the_table(records):
    (row,) = rows("write")
    records.keep_done(row.key, {"seconds": 1.0, "energy": -2.5, "warnings": 3}, [])
    (table, _), _ = write_tables(records.folder, [row], records)
    with open(table, newline="") as file:
        assert [line["energy"] for line in csv.DictReader(file)] == ["-2.5"]


def test_warnings_on_a_card_are_escaped(records, tmp_path):
    class Spoiled:
        """Records of a row whose warnings are no number."""

        def done(self, key):
            return {"files": {}, "seconds": 1.0, "warnings": "<em>", "certificate": "<u>", "gap": 0.1}

        def failed(self, key):
            return None

        thumbnail = records.thumbnail

    write_sheet(tmp_path / "sheet.html", "", rows("write"), Spoiled())
    text = (tmp_path / "sheet.html").read_text()
    assert "<em>" not in text and "&lt;em&gt;" in text and "<u>" not in text


def test_equal_rows_are_done_once(records, tmp_path):
    row = rows("write")[0]
    assert run([row, row], records) == (0, 1)
    assert len(begun(tmp_path)) == 1 and states([row, row], records) == ["done", "done"]


def test_tables_and_sheet_tell_what_became_of_each_row(records, tmp_path):
    wanted = [*rows("write", "refuse"), Planned("", None, "line 3: <no> JSON")]
    run(wanted, records, retries=0)
    records.thumbnail(wanted[0].key).write_bytes(b"a picture")
    (table, listed), done = write_tables(records.folder, wanted, records)
    assert done == 1
    with open(table, newline="") as file:
        lines = list(csv.DictReader(file))
    assert [line["state"] for line in lines] == ["done", "failed", "failed"]
    assert lines[0]["energy"] == "2.0" and lines[1]["reason"] == "this row is refused"
    assert [entry["row"] for entry in json.loads(open(listed).read())] == [1, 2, 3]
    write_sheet(tmp_path / "sheet.html", "Rows & more", wanted, records)
    sheet = (tmp_path / "sheet.html").read_text()
    assert "Rows &amp; more" in sheet and "data:image/jpeg;base64,YSBwaWN0dXJl" in sheet
    assert "25.0%" in sheet and "this row is refused" in sheet and "&lt;no&gt; JSON" in sheet
    assert "http://" not in sheet and "https://" not in sheet and "<script" not in sheet


def test_a_long_sheet_shows_failures_and_the_widest_gaps(records, tmp_path):
    class Many:
        """Records of 2000 rows, one of which has failed."""

        def done(self, key):
            return None if key == "7" else {"files": {}, "gap": int(key) / 4000, "energy": 1.0, "seconds": 1.0}

        def failed(self, key):
            return {"tries": 1, "reason": "the one that failed"}

        thumbnail = records.thumbnail

    write_sheet(tmp_path / "sheet.html", "Many", [Planned(f"r{n}", str(n), "[]") for n in range(2000)], Many())
    sheet = (tmp_path / "sheet.html").read_text()
    assert "600 of 2,000 rows" in sheet and "the one that failed" in sheet
    assert "· r1999<" in sheet and "· r1401<" in sheet and "· r1400<" not in sheet
