# SPDX-License-Identifier: GPL-3.0-or-later
"""Markdown tables of measured rows, and how many rows hold a criterion."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Column:
    """A heading, the key of a row's value, and the value's format."""

    heading: str
    key: str
    format: str

    def cell(self, row):
        value = row.get(self.key)
        return "–" if value is None else format(value, self.format)


@dataclass(frozen=True)
class Criterion:
    """Rows of enough nodes hold it when the value of ``key`` is at most (or at least) ``limit``."""

    text: str
    key: str
    limit: float
    at_least: bool = False
    from_nodes: int = 0

    def concerns(self, row):
        return row.get(self.key) is not None and row["nodes"] >= self.from_nodes

    def holds(self, row):
        return row[self.key] >= self.limit if self.at_least else row[self.key] <= self.limit

    def worst(self, rows):
        return (min if self.at_least else max)(rows, key=lambda row: row[self.key])


def print_table(title, columns, rows, first="problem"):
    """One line per row, whose name is its label; over these stands ``first``."""
    print(f"\n{title}\n")
    for line in table_lines(columns, rows, first):
        print(line, flush=True)


def table_lines(columns, rows, first="problem"):
    """The lines of a table."""
    yield f"| {first} | " + " | ".join(column.heading for column in columns) + " |"
    yield "|---" * (len(columns) + 1) + "|"
    for row in rows:
        yield f"| {row['label']} | " + " | ".join(column.cell(row) for column in columns) + " |"


def print_summary(criteria, rows):
    """Share of the rows that hold each criterion, and the worst row."""
    print("\n| criterion | rows that hold | worst | at |")
    print("|---|---|---|---|")
    for criterion in criteria:
        known = [row for row in rows if criterion.concerns(row)]
        if known:
            worst = criterion.worst(known)
            held = sum(map(criterion.holds, known))
            share = f"{held} of {len(known)} ({held / len(known):.0%})"
            print(f"| {criterion.text} | {share} | {worst[criterion.key]:.5g} | {worst['label']} |")
