# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the rooms of the program and the arrows between them, from its imports; prints the path of the picture.

    python tools/rooms.py [--output docs/architecture.svg]

A room is a package, or a module that lies beside packages; an arrow is an import, those inside functions included. A
room stands on the floor above all that it imports. Arrows that a longer way implies are left out of the picture.
"""

import argparse
import ast
import textwrap
from collections import defaultdict
from functools import cache
from html import escape
from itertools import pairwise
from math import fsum
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TOPS = ("core", "synch_addon")
# Of the picture, in pixels: a room's width, its height without lines of text and that of a line, the space beside a
# room and below it; and the letters of a line.
WIDTH, HEAD, LINE, GAP, BETWEEN, LETTERS = 230, 30, 14, 22, 60, 34
COLOURS, ARROWS = {"core": "#e8eef7", "synch_addon": "#f7efe2"}, "#5b6673"


def modules():
    """Paths of all modules by their dotted names."""
    found = {}
    for top in TOPS:
        for path in sorted((ROOT / top).rglob("*.py")):
            if "shipped" not in path.parts:
                name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
                found[name.removesuffix(".__init__")] = path
    return found


def _walk_run(tree):
    """All nodes but those in ``if TYPE_CHECKING``, which never run."""
    yield tree
    for node in ast.iter_child_nodes(tree):
        if not (isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING"):
            yield from _walk_run(node)


def imports(found):
    """The modules that each module imports when it runs, by their names."""
    result = {}
    for name, path in found.items():
        package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        result[name] = set()
        for node in _walk_run(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level:
                base = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*base, *([node.module] if node.module else [])])
                names = (f"{base}.{alias.name}" for alias in node.names)
                result[name] |= {target if target in found else base for target in names} & found.keys()
        result[name].discard(name)
    return result


def room_of(name, found):
    """The room of a module: its package, or itself where it lies in ``core`` or ``synch_addon`` beside packages."""
    room = name if found[name].name == "__init__.py" else name.rpartition(".")[0]
    return name if room in TOPS else room


def arrows(found):
    """The rooms that each room imports, by their names, without those of whole tops, which only hold others."""
    rooms = defaultdict(set)
    for name, targets in imports(found).items():
        here = room_of(name, found)
        rooms[here] |= {room_of(target, found) for target in targets} - {here}
    for top in TOPS:
        rooms.pop(top, None)
        for targets in rooms.values():
            targets.discard(top)
    return dict(rooms)


def circles(graph):
    """Sets of names that can be reached from one another."""

    @cache
    def reached(name):
        seen, ahead = set(), list(graph.get(name, ()))
        while ahead:
            here = ahead.pop()
            if here not in seen:
                seen.add(here)
                ahead += graph.get(here, ())
        return frozenset(seen)

    rings = {frozenset({other for other in reached(name) if name in reached(other)}) for name in graph}
    return sorted(sorted(ring) for ring in rings if ring)


def floors(graph):
    """The floor of each room, 1 for those that import nothing."""

    @cache
    def floor(name):
        return 1 + max(map(floor, graph.get(name, ())), default=0)

    return {name: floor(name) for name in graph}


def direct(graph):
    """The arrows that no longer way implies."""
    levels = floors(graph)

    @cache
    def below(name):
        return frozenset().union(*(below(target) | {target} for target in graph.get(name, ())))

    return {
        name: {t for t in targets if not any(t in below(other) for other in targets - {t})}
        for name, targets in graph.items()
        if name in levels
    }


def line_of(room, found):
    """The first sentence of what a room says of itself."""
    text = ast.get_docstring(ast.parse(found[room].read_text(encoding="utf-8"))) or ""
    return " ".join(text.split("\n\n")[0].split())


def drawn(found):
    """The picture as SVG."""
    graph = arrows(found)
    names = sorted(graph, key=lambda name: (TOPS.index(name.split(".")[0]), name))
    lines = {name: _wrapped(line_of(name, found)) for name in names}
    rows, ways = _rows_and_ways(names, floors(graph), direct(graph))
    _order(rows, ways)
    width = max(map(_row_width, rows.values())) + 2 * GAP
    places, top = {}, GAP
    for level in sorted(rows, reverse=True):
        left = (width - _row_width(rows[level])) / 2
        height = HEAD + LINE * max(len(lines.get(place, ())) for place in rows[level])
        for place in rows[level]:
            places[place] = left, top, height
            left += _width(place) + GAP
        top += height + BETWEEN
    height = top - BETWEEN + GAP
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
        '<marker id="head" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="9" markerHeight="9" '
        f'markerUnits="userSpaceOnUse" orient="auto"><path d="M 0 0 L 8 4 L 0 8 z" fill="{ARROWS}"/></marker>',
    ]
    parts += [_arrow([(places[place][0] + _width(place) / 2, *places[place][1:]) for place in way]) for way in ways]
    parts += [_box(name, lines[name], *places[name]) for name in names]
    return "\n".join([*parts, "</svg>"]) + "\n"


def _wrapped(line):
    return textwrap.wrap(line.replace("`", ""), LETTERS, break_on_hyphens=False)


def _rows_and_ways(names, levels, targets):
    """Rooms on each floor with gaps for the arrows that pass it, and the way of each arrow through these."""
    rows, ways = defaultdict(list), []
    for name in names:
        rows[levels[name]].append(name)
    for name in names:
        for target in sorted(targets[name]):
            passed = [(name, target, level) for level in range(levels[name] - 1, levels[target], -1)]
            for gap in passed:
                rows[gap[2]].append(gap)
            ways.append([name, *passed, target])
    return rows, ways


def _order(rows, ways):
    """Put each room or gap near the middle of what arrows join it to, floor by floor, some times."""
    joined = defaultdict(list)
    for way in ways:
        for one, other in pairwise(way):
            joined[one].append(other)
            joined[other].append(one)
    for _ in range(12):
        shares = {place: (k + 0.5) / len(row) for row in rows.values() for k, place in enumerate(row)}
        for row in rows.values():
            near = {place: [shares[other] for other in joined[place]] for place in row}
            row.sort(key=lambda place: (round(fsum(near[place]) / max(len(near[place]), 1), 9), str(place)))


def _width(place):
    return WIDTH if isinstance(place, str) else 0


def _row_width(row):
    return sum(map(_width, row)) + GAP * (len(row) - 1)


def _arrow(stops):
    """An arrow from below the first of its stops, (middle, top, height), down through the gaps to the last."""
    x, y = stops[0][0], stops[0][1] + stops[0][2]
    way = f"M {x:.0f} {y:.0f}"
    for u, top, height in stops[1:]:
        bend = (top - y) / 2
        way += f" C {x:.0f} {y + bend:.0f} {u:.0f} {top - bend:.0f} {u:.0f} {top:.0f}"
        x, y = u, top + height
        way += f" V {y:.0f}" if (u, top, height) != stops[-1] else ""
    return f'<path d="{way}" fill="none" stroke="{ARROWS}" stroke-width="1.2" marker-end="url(#head)"/>'


def _box(name, lines, x, y, height):
    size = 13 if len(name) < 28 else 11
    texts = [f'<text x="{x + 8:.0f}" y="{y + 17:.0f}" font-size="{size}" font-weight="bold">{escape(name)}</text>']
    for number, line in enumerate(lines):
        at = f'x="{x + 8:.0f}" y="{y + 33 + LINE * number:.0f}"'
        texts.append(f'<text {at} font-size="11" fill="#444">{escape(line)}</text>')
    fill = COLOURS[name.split(".")[0]]
    rect = f'<rect x="{x:.0f}" y="{y:.0f}" width="{WIDTH}" height="{height}" rx="6" fill="{fill}" stroke="#666"/>'
    return rect + "".join(texts)


def main():
    parser = argparse.ArgumentParser(description="Draw the rooms of the program and the arrows between them.")
    parser.add_argument("--output", type=Path, default=ROOT / "docs" / "architecture.svg", metavar="FILE")
    path = parser.parse_args().output
    path.write_text(drawn(modules()), encoding="utf-8")
    print(path)


if __name__ == "__main__":
    main()
