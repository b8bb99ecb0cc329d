# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of a long bench in a file of JSON lines: kept as they come, so that it goes on where it was stopped."""

import json


class KeptRows(dict):
    """Rows by the values of some of their names, in the order in which they came.

    Parameters
    ----------
    path : Path of the file, which need not exist yet, or None to keep them in memory only; of rows that are alike in
        the names the last one counts
    names : of a row's values that tell it from the others
    """

    def __init__(self, path, *names):
        self._path, self._names = path, names
        lines = path.read_text(encoding="utf-8").splitlines() if path and path.exists() else []
        rows = map(json.loads, lines)
        super().__init__((tuple(row[name] for name in names), row) for row in rows)

    def keep(self, row):
        """Add a row, in the file too."""
        if self._path:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
        self[tuple(row[name] for name in self._names)] = row
