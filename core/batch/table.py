# SPDX-License-Identifier: GPL-3.0-or-later
"""The results of a batch's rows as .csv and .json tables, written row by row because there may be many."""

import csv
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from ..files.json_text import json_text
from ..files.whole import write_whole
from .records import Record, Records
from .run import Planned

# Figures of a report in the table, and lists of a report whose lengths are in the table.
FIGURES = "status", "energy", "lower_bound", "gap", "certificate", "nodes"
COUNTS = "disclinations", "dislocations", "warnings"
_COLUMNS = ("row", "label", "state", *FIGURES, *COUNTS, "seconds", "memory_mb", "tries", "reason", "files")
# First characters of formulas in spreadsheets.
_OF_FORMULAS = "=", "+", "-", "@", "\t", "\r"
# State of a row that has not been tried.
OPEN = "open"


def figures(report: dict[str, Any], seconds: float) -> Record:
    """The record of a row's report; seconds include the writing of its files."""
    counts = {name: len(report[name]) for name in COUNTS if name in report}
    kept = {name: report[name] for name in FIGURES if report.get(name) is not None}
    return kept | counts | {"seconds": seconds, "memory_mb": report.get("peak_memory_mb")}


def entries(rows: Iterable[Planned], records: Records) -> Iterator[Record]:
    """The result of each row, read one at a time, whose ``state`` is "done", "failed" or "open"."""
    for number, row in enumerate(rows, 1):
        entry = {"row": number, "label": row.label, "key": row.key}
        done = row.key and records.done(row.key)
        failed = {"tries": 0, "reason": row.content} if row.key is None else records.failed(row.key)
        if done:
            yield entry | {"state": "done"} | done
        elif failed:
            yield entry | {"state": "failed"} | failed
        else:
            yield entry | {"state": OPEN, "reason": "not tried yet"}


def _cell(value: object) -> object:
    """A cell of a .csv file; an apostrophe marks texts that spreadsheets would read as formulas."""
    return f"'{value}" if isinstance(value, str) and value.startswith(_OF_FORMULAS) else value


def write_tables(folder: Path, rows: Iterable[Planned], records: Records) -> tuple[list[str], int]:
    """Write summary.csv and summary.json; returns their paths and the number of rows that are done."""
    table, listed, done = folder / "summary.csv", folder / "summary.json", 0
    with write_whole(table) as csv_path, write_whole(listed) as json_path:
        with (
            csv_path.open("w", newline="", encoding="utf-8", errors="backslashreplace") as rows_file,
            json_path.open("w", encoding="utf-8") as file,
        ):
            writer = csv.DictWriter(rows_file, _COLUMNS, extrasaction="ignore")
            writer.writeheader()
            before = "[\n"
            for entry in entries(rows, records):
                done += entry["state"] == "done"
                file.write(before + json_text(entry))
                before = ",\n"
                cells = entry | {"files": " ".join(entry.get("files", ()))}
                writer.writerow({name: _cell(value) for name, value in cells.items()})
            file.write("\n]\n")
    return [str(table), str(listed)], done
