# SPDX-License-Identifier: GPL-3.0-or-later
"""What became of the rows of a batch: a table as .csv and .json, row by row, so that there may be many."""

import csv

from ..files.json_text import json_text
from ..files.whole import write_whole

# Figures of a report that the table has, and lists of it whose lengths it has.
FIGURES = "status", "energy", "lower_bound", "gap", "certificate", "nodes"
COUNTS = "disclinations", "dislocations", "warnings"
_COLUMNS = ("row", "label", "state", *FIGURES, *COUNTS, "seconds", "memory_mb", "tries", "reason", "files")
# What formulas of spreadsheets begin with.
_OF_FORMULAS = "=", "+", "-", "@", "\t", "\r"
# What a table says of a row that nobody has done yet.
OPEN = "open"


def figures(report, seconds):
    """What the record of a row keeps of its report.

    Parameters
    ----------
    report : dict
    seconds : that the row took, its files included
    """
    counts = {name: len(report[name]) for name in COUNTS if name in report}
    kept = {name: report[name] for name in FIGURES if report.get(name) is not None}
    return kept | counts | {"seconds": seconds, "memory_mb": report.get("peak_memory_mb")}


def entries(rows, records):
    """What became of each row, as a dict whose ``state`` is "done", "failed" or "open"; nothing is kept of them.

    Parameters
    ----------
    rows : sequence of Planned
    records : Records
    """
    for number, row in enumerate(rows, 1):
        entry = {"row": number, "label": row.label, "key": row.key}
        done = row.key and records.done(row.key)
        failed = {"tries": 0, "reason": row.told} if row.key is None else records.failed(row.key)
        if done:
            yield entry | {"state": "done"} | done
        elif failed:
            yield entry | {"state": "failed"} | failed
        else:
            yield entry | {"state": OPEN, "reason": "nobody has tried it yet"}


def _cell(value):
    """A cell of a .csv file that no spreadsheet takes for a formula: texts are marked as such by an apostrophe."""
    return f"'{value}" if isinstance(value, str) and value.startswith(_OF_FORMULAS) else value


def write_tables(folder, rows, records):
    """Write summary.csv and summary.json; returns their paths and how many rows are done.

    Parameters
    ----------
    folder : pathlib.Path
    rows, records : see :func:`entries`
    """
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
