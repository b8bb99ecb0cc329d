# SPDX-License-Identifier: GPL-3.0-or-later
"""The contact sheet of a batch: one .html file with small pictures, energies, gaps and failures."""

import base64
import heapq
import statistics
from collections.abc import Iterable, Iterator
from html import escape
from pathlib import Path

from ..files.whole import write_whole
from .records import Record, Records
from .run import Planned
from .table import entries

# Most rows of a sheet, failures first, then the widest gaps; a longer page is slow to open.
_MOST = 600
_STYLE = """
:root { --ink: #1d232b; --dim: #667180; --line: #dfe3e8; --page: #f4f5f7; --card: #fff; --good: #2f7d5b; --bar: #3b5b92;
  --bad: #b3382c; color-scheme: light dark }
@media (prefers-color-scheme: dark) { :root { --ink: #e7eaee; --dim: #98a2ae; --line: #333a43; --page: #16191d;
  --card: #1f242a; --good: #6cc29a; --bar: #7d9fdc; --bad: #ef7b6d } }
* { box-sizing: border-box }
body { margin: 0 auto; max-width: 1500px; padding: 28px; background: var(--page); color: var(--ink);
  font: 14px/1.45 system-ui, "DejaVu Sans", sans-serif }
h1 { font-size: 22px; margin: 0 0 14px } h2 { font-size: 16px; margin: 30px 0 10px }
.tiles { display: flex; flex-wrap: wrap; gap: 10px }
.tiles div { background: var(--card); border: 1px solid var(--line); border-radius: 8px; padding: 9px 16px;
  color: var(--dim) }
.tiles b { display: block; font-size: 20px; color: var(--ink) }
.tiles .bad b { color: var(--bad) }
.sheet { display: grid; grid-template-columns: repeat(auto-fill, minmax(220px, 1fr)); gap: 14px }
.card { background: var(--card); border: 1px solid var(--line); border-radius: 8px; overflow: hidden }
.card img, .card .none { display: block; width: 100%; aspect-ratio: 4/3; object-fit: cover; background: var(--line) }
.card .none { display: grid; place-items: center; color: var(--dim) }
.card div.facts { padding: 8px 12px 11px } .card h3 { font-size: 13px; margin: 0; overflow-wrap: anywhere }
.card dl { display: grid; grid-template-columns: auto 1fr; gap: 0 10px; margin: 5px 0 0;
  font-variant-numeric: tabular-nums }
dt { color: var(--dim) } dd { margin: 0; text-align: right } .proved { color: var(--good) }
.bar { height: 4px; background: var(--line); margin-top: 8px; border-radius: 2px }
.bar i { display: block; height: 100%; background: var(--bar); border-radius: 2px }
table { border-collapse: collapse; width: 100%; background: var(--card); border: 1px solid var(--line) }
td, th { text-align: left; padding: 6px 12px; border-top: 1px solid var(--line); vertical-align: top }
th { color: var(--dim); font-weight: 500; border: 0 } td:last-child { color: var(--bad); overflow-wrap: anywhere }
p.note { color: var(--dim) }
"""


def write_sheet(path: str | Path, title: str, rows: Iterable[Planned], records: Records) -> None:
    """Write the .html file of a batch; errors as :func:`..files.whole.write_whole`."""
    found = _Figures()
    kept = heapq.nlargest(_MOST, map(found.ranked, entries(rows, records)), key=lambda ranked: ranked[:2])
    shown = sorted((entry for _, _, entry in kept), key=lambda entry: entry["row"])
    with write_whole(path) as made, made.open("w", encoding="utf-8", errors="backslashreplace") as file:
        file.write(f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{escape(title)}</title>')
        file.write(f"<style>{_STYLE}</style><h1>{escape(title)}</h1>{found.tiles()}")
        if found.count > len(shown):
            note = f"{len(shown)} of {found.count:,} rows: those that failed, and the widest gaps."
            file.write(f'<p class="note">{note}</p>')
        lost = [entry for entry in shown if entry["state"] != "done"]
        if lost:
            file.write("<h2>Not done</h2><table><tr><th>Row<th>What<th>Tries<th>Why")
            file.writelines(map(_failure, lost))
            file.write("</table>")
        done = [entry for entry in shown if entry["state"] == "done"]
        if done:
            file.write('<h2>Done</h2><div class="sheet">')
            file.writelines(_card(entry, records.thumbnail(entry["key"])) for entry in done)
            file.write("</div>")
        file.write("</html>\n")


class _Figures:
    """Counts entries."""

    def __init__(self) -> None:
        self.count, self._seconds, self._proved = 0, 0.0, 0
        self._states: dict[str, int] = {}
        self._gaps: list[float] = []

    def ranked(self, entry: Record) -> tuple[float, int, Record]:
        """Count an entry; its rank, by which the first ones are shown, and the entry."""
        self.count += 1
        state, gap = entry["state"], _gap(entry)
        self._states[state] = self._states.get(state, 0) + 1
        self._seconds += entry.get("seconds", 0.0)
        self._proved += entry.get("certificate") == "proved"
        if gap is not None:
            self._gaps.append(gap)
        return (2.0 if state != "done" else gap or 0.0), -self.count, entry

    def tiles(self) -> str:
        done = self._states.get("done", 0)
        tiles = [("", f"{done:,}", "done"), ("", _time(self._seconds), "of one process")]
        if self._gaps:
            tiles.append(("", f"{statistics.median(self._gaps):.1%}", "median gap"))
            tiles.append(("", f"{max(self._gaps):.1%}", "widest gap"))
            tiles.append(("", f"{self._proved:,}", "bounds proved"))
        for state in ("failed", "open"):
            if state in self._states:
                tiles.append((' class="bad"', f"{self._states[state]:,}", state))
        boxes = (f"<div{kind}><b>{number}</b>{what}</div>" for kind, number, what in tiles)
        return f'<div class="tiles">{"".join(boxes)}</div>'


def _gap(entry: Record) -> float | None:
    """The gap of an entry, None without a bound."""
    return None if entry.get("certificate") == "none" else entry.get("gap")


def _time(seconds: float) -> str:
    if seconds < 120:
        return f"{seconds:.1f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


def _failure(entry: Record) -> str:
    return f"<tr><td>{entry['row']}<td>{escape(entry['label'])}<td>{entry.get('tries', 0)}<td>{escape(entry['reason'])}"


def _card(entry: Record, thumbnail: Path) -> str:
    try:
        data = base64.b64encode(thumbnail.read_bytes()).decode()
        picture = f'<img alt="" loading="lazy" src="data:image/jpeg;base64,{data}">'
    except OSError:
        picture = '<div class="none">no picture asked for</div>'
    lines = [f"<dt>{what}<dd>{value}" for what, value in _card_lines(entry)]
    gap = _gap(entry)
    bar = "" if gap is None else f'<div class="bar"><i style="width:{100 * min(max(gap, 0), 1):.1f}%"></i></div>'
    return (
        f'<div class="card">{picture}<div class="facts"><h3>{entry["row"]} · {escape(entry["label"])}</h3>'
        f"<dl>{''.join(lines)}</dl>{bar}</div></div>"
    )


def _card_lines(entry: Record) -> Iterator[tuple[str, str]]:
    """Names and HTML values of a card's lines."""
    if entry.get("nodes") is not None:
        yield "vertices", f"{entry['nodes']:,}"
    if entry.get("energy") is not None:
        yield "energy", f"{entry['energy']:.6g}"
    if _gap(entry) is not None:
        kind = escape(str(entry.get("certificate", "")))
        yield "gap", f'{entry["gap"]:.1%} <span class="{kind}">{kind}</span>'
    defects = [entry.get(name) for name in ("disclinations", "dislocations")]
    if None not in defects:
        yield "defects", escape(f"{defects[0]} + {defects[1]}")
    if entry.get("warnings"):
        yield "warnings", escape(str(entry["warnings"]))
    yield "time", _time(entry["seconds"])
