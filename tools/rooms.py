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
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TOPS = ("core", "synch_addon")
# Of the picture, in pixels: a room, the space between two, and the letters of a line.
WIDTH, HEIGHT, GAP, FLOOR, LETTERS = 200, 74, 26, 132, 31
COLOURS = {"core": "#e8eef7", "synch_addon": "#f7efe2"}


def modules():
    """Paths of all modules by their dotted names."""
    found = {}
    for top in TOPS:
        for path in sorted((ROOT / top).rglob("*.py")):
            if "shipped" not in path.parts:
                name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
                found[name.removesuffix(".__init__")] = path
    return found


def imports(found):
    """The modules that each module imports, by their names."""
    result = {}
    for name, path in found.items():
        package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        result[name] = set()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
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
    levels = floors(graph)
    rows = defaultdict(list)
    for name in sorted(graph, key=lambda name: (TOPS.index(name.split(".")[0]), name)):
        rows[levels[name]].append(name)
    _order(rows, graph)
    highest, widest = max(rows), max(map(len, rows.values()))
    width, height = widest * (WIDTH + GAP) + GAP, highest * FLOOR + GAP
    places = {}
    for level, names in rows.items():
        start = (width - len(names) * (WIDTH + GAP) + GAP) / 2
        for number, name in enumerate(names):
            places[name] = start + number * (WIDTH + GAP), (highest - level) * FLOOR + GAP
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
    ]
    for name, targets in sorted(direct(graph).items()):
        for target in sorted(targets):
            parts.append(_arrow(places[name], places[target]))
    parts += [_box(name, line_of(name, found), *places[name]) for name in sorted(places)]
    return "\n".join([*parts, "</svg>"]) + "\n"


def _order(rows, graph):
    """Put each room near the middle of what it imports and what imports it, floor by floor, some times."""
    for _ in range(12):
        place = {name: (k + 0.5) / len(names) for names in rows.values() for k, name in enumerate(names)}
        for level in sorted(rows):
            near = {name: [place[t] for t in graph[name]] for name in rows[level]}
            for other, targets in graph.items():
                for name in targets & near.keys():
                    near[name].append(place[other])
            rows[level].sort(key=lambda name: (sum(near[name]) / max(len(near[name]), 1), name))


def _arrow(start, end):
    x, y, u, v = start[0] + WIDTH / 2, start[1] + HEIGHT, end[0] + WIDTH / 2, end[1]
    bend = max((v - y) / 2, 20)
    way = f"M {x:.0f} {y:.0f} C {x:.0f} {y + bend:.0f} {u:.0f} {v - bend:.0f} {u:.0f} {v:.0f}"
    return f'<path d="{way}" fill="none" stroke="#9aa3ad" stroke-width="1.2"/>'


def _box(name, line, x, y):
    lines = textwrap.wrap(line, LETTERS)
    lines = lines[:3] if len(lines) < 4 else [*lines[:2], lines[2][: LETTERS - 2] + " …"]
    size = 13 if len(name) < 24 else 11
    texts = [f'<text x="{x + 8:.0f}" y="{y + 17:.0f}" font-size="{size}" font-weight="bold">{escape(name)}</text>']
    for number, part in enumerate(lines):
        at = f'x="{x + 8:.0f}" y="{y + 33 + 14 * number:.0f}"'
        texts.append(f'<text {at} font-size="11" fill="#444">{escape(part)}</text>')
    fill = COLOURS[name.split(".")[0]]
    rect = f'<rect x="{x:.0f}" y="{y:.0f}" width="{WIDTH}" height="{HEIGHT}" rx="6" fill="{fill}" stroke="#666"/>'
    return rect + "".join(texts)


def main():
    parser = argparse.ArgumentParser(description="Draw the rooms of the program and the arrows between them.")
    parser.add_argument("--output", type=Path, default=ROOT / "docs" / "architecture.svg", metavar="FILE")
    path = parser.parse_args().output
    path.write_text(drawn(modules()), encoding="utf-8")
    print(path)


if __name__ == "__main__":
    main()
