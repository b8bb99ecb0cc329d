# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The house of docs/architecture.md: imports run one way, every room says what it is for, and its picture is true."""

import ast
import importlib.util
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[1]
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def rooms():
    """tools/rooms.py as a module, which reads the imports of the program once."""
    spec = importlib.util.spec_from_file_location("rooms", ROOT / "tools" / "rooms.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    found, read = module.modules(), module.imports
    known = read(found)
    module.imports = lambda asked: known if asked == found else read(asked)
    return module


@pytest.fixture(scope="module")
def found(rooms):
    return rooms.modules()


@pytest.fixture(scope="module")
def trees(found):
    return {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in found.items()}


def test_no_imports_run_in_a_circle(rooms, found):
    assert rooms.circles(rooms.imports(found)) == []
    assert rooms.circles(rooms.arrows(found)) == []


def test_a_circle_would_be_found(rooms):
    assert rooms.circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == [["a", "b", "c"]]


def test_imports_inside_functions_count(rooms, tmp_path):
    (tmp_path / "lazy.py").write_text("def f():\n    from .other import g\n")
    (tmp_path / "other.py").write_text("")
    found = {"core.lazy": tmp_path / "lazy.py", "core.other": tmp_path / "other.py"}
    assert rooms.imports(found) == {"core.lazy": {"core.other"}, "core.other": set()}


def test_imports_of_types_alone_do_not_count(rooms, tmp_path):
    (tmp_path / "typed.py").write_text(
        "if TYPE_CHECKING:\n    from .other import A\nif SLOW:\n    from .third import b\n"
    )
    (tmp_path / "other.py").write_text("")
    (tmp_path / "third.py").write_text("")
    found = {f"core.{name}": tmp_path / f"{name}.py" for name in ("typed", "other", "third")}
    assert rooms.imports(found)["core.typed"] == {"core.third"}


def test_core_knows_nothing_of_the_add_on(rooms, found):
    for name, targets in rooms.imports(found).items():
        if name.startswith("core"):
            assert not [target for target in targets if not target.startswith("core")], name


def test_looks_bakes_solids_flows_and_frames_do_not_know_one_another(rooms, found):
    siblings = {f"synch_addon.{name}" for name in ("looks", "bakes", "solids", "flows", "frames")}
    graph = rooms.arrows(found)
    for room in siblings:
        assert graph[room] & siblings <= ({"synch_addon.looks"} if room.endswith("bakes") else set()), room


_BESIDE = {"threading", "_thread", "concurrent", "multiprocessing", "asyncio"}


def test_threads_are_begun_in_one_module_and_processes_through_pipes_alone(trees):
    """Where they run is told there."""
    assert "beside Blender" in ast.get_docstring(trees["core.threads"])
    for here, tree in trees.items():
        if here == "core.threads":
            continue
        for node in ast.walk(tree):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import | ast.ImportFrom) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                assert name.split(".")[0] not in _BESIDE, here


_CHANGING = {
    "add",
    "append",
    "clear",
    "discard",
    "extend",
    "insert",
    "pop",
    "popitem",
    "remove",
    "setdefault",
    "update",
}


def changed_outside_of_objects(tree):
    """Lines where functions of a module change what the module holds, other than through an object of a class."""
    held = set()
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        built = getattr(getattr(getattr(node, "value", None), "func", None), "id", None)
        plain = isinstance(getattr(node, "value", None), ast.List | ast.Dict | ast.Set | ast.ListComp | ast.DictComp)
        if plain or built in ("list", "dict", "set", "defaultdict", "deque", "OrderedDict", "Counter"):
            held |= {target.id for target in targets if isinstance(target, ast.Name)}
        if isinstance(node, ast.FunctionDef):
            held.add(node.name)
    lines = set()
    for function in (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.Lambda)):
        inside = [*ast.walk(function)]
        own = {name.id for name in inside if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store)}
        own |= {name.arg for name in inside if isinstance(name, ast.arg)}
        for node in inside:
            if isinstance(node, ast.Global):
                lines.add(node.lineno)
            changes = isinstance(getattr(node, "ctx", None), ast.Store | ast.Del)
            changes |= isinstance(node, ast.Attribute) and node.attr in _CHANGING
            place = getattr(node, "value", None)
            if changes and isinstance(place, ast.Name) and place.id in held - own:
                lines.add(node.lineno)
    return sorted(lines)


def test_no_module_changes_what_it_holds_but_through_the_object_that_owns_it(trees):
    for name, tree in trees.items():
        assert changed_outside_of_objects(tree) == [], name


@pytest.mark.parametrize(
    "held, change",
    [
        ("kept = None", "global kept"),
        ("kept = []", "kept.append(1)"),
        ("kept: dict = {}", "kept[1] = 2"),
        ("kept = {}", "kept[1] += 2"),
        ("kept = set()", "kept.clear()"),
        ("kept = {1: 2}", "del kept[1]"),
        ("def kept(): pass", "kept.last = 1"),
    ],
)
def test_a_change_of_what_a_module_holds_would_be_found(held, change):
    assert changed_outside_of_objects(ast.parse(f"{held}\ndef f():\n    {change}\n")) == [3]
    assert changed_outside_of_objects(ast.parse(f"{held}\ndef f(kept):\n    {change}\n")) == [3] * ("global" in change)


def test_every_room_says_in_one_line_what_it_is_for(rooms, found):
    for room in rooms.arrows(found):
        line = rooms.line_of(room, found)
        assert line and line.endswith((".", ":")) and len(line) < 200, f"{room}: {line!r}"


def test_the_picture_is_of_the_imports_as_they_are(rooms, found):
    drawn = (ROOT / "docs" / "architecture.svg").read_text(encoding="utf-8")
    assert drawn == rooms.drawn(found), "draw it anew with python tools/rooms.py"


def test_the_picture_has_whole_texts_and_arrows_with_heads_that_pass_beside_the_rooms(rooms, found):
    picture = ElementTree.fromstring(rooms.drawn(found))
    graph = rooms.arrows(found)
    texts = [text.text for text in picture.iter(SVG + "text")]
    whole = [f"{name} {rooms.line_of(name, found).replace('`', '')}" for name in texts if name in graph]
    assert " ".join(texts) == " ".join(whole)
    assert graph.keys() <= set(texts)
    sides = ("x", "y", "width", "height")
    boxes = [[float(box.get(side)) for side in sides] for box in picture.findall(SVG + "rect") if box.get("x")]
    ways = picture.findall(SVG + "path")
    assert len(ways) == sum(map(len, rooms.direct(graph).values()))
    for way in ways:
        assert way.get("marker-end") == "url(#head)"
        for x, y in re.findall(r" (\d+) \d+ V (\d+)", way.get("d")):
            for left, top, width, height in boxes:
                assert not (left < int(x) < left + width and top < int(y) <= top + height)


def test_every_module_that_a_text_names_is_there(found):
    named = 0
    for here, path in found.items():
        package = here if path.name == "__init__.py" else here.rpartition(".")[0]
        for name in re.findall(r":mod:`([.\w]+)`", path.read_text(encoding="utf-8")):
            assert importlib.util.resolve_name(name, package) in found, f"{here}: {name}"
            named += 1
    assert named > 10


def test_every_place_that_the_page_names_is_there():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    bases = [ROOT, ROOT / "synch_addon", ROOT / "core"]
    for name in re.findall(r"`([\w/]+/(?:[\w]+\.\w+)?)`", page):
        assert any((base / name).exists() for base in bases), name
