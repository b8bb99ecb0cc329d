# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors and warnings in German: whatever the sources raise or warn of has its sentence, and is told whole."""

import ast
import re
import string
from pathlib import Path

import bpy
import pytest

from synch_fields.core import errors
from synch_fields.core.errors import name_elements
from synch_fields.core.geometry.carrier import KINDS, Finding
from synch_fields.core.memory import room
from synch_fields.synch_addon.blender import translations
from synch_fields.synch_addon.blender.translations import messages, told

ROOT = Path(errors.__file__).parents[1]
GERMAN, WORDS = translations.MESSAGES["de_DE"], translations.WORDS["de_DE"]
# Rooms of the command line and of Python, which no window reaches.
UNSEEN = re.compile(
    r"core/(batch|spread)/|core/files/declared|core/problem|core/solve/options_check\.py|synch_addon/command/"
)
# What only programs can do wrong, wherever it is said: arrays of other shapes, functions, flags.
FOR_PROGRAMS = re.compile(r"\bshape\b|--[a-z]|the callback is")
RAISED = {"SynchError", "MeshError", "SettingError", "WriteError", "ContradictionError", "WorkerGone", "Cancelled"}
# What is put together from "has" or "have", each of which has its sentence.
BY_NUMBER = {"{} {} {}: {}", "{} {} {}: use {}"}
# Functions that return or yield such lines, and which are called with them.
SAYING = re.compile(r"_about|_judge|split_line$|refusal$|no_object$|_no_layer$|missing$|_last_words$")
CALLED = {"warn", *RAISED}


def template(node):
    """What a node of a text says, with {} for each part; None for what is no text."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.JoinedStr(values=values):
            return "".join(value.value if isinstance(value, ast.Constant) else "{}" for value in values)
        case ast.BinOp(op=ast.Add(), left=left, right=right):
            parts = template(left), template(right)
            return None if None in parts else "".join(parts)
    return None


def raised_and_warned(path):
    """The sentences of a source."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call):
            name = getattr(node.func, "id", getattr(node.func, "attr", ""))
            listed = (name == "append" and "warnings" in ast.unparse(node.func)) or name == "told"
            if node.args and (name in CALLED or listed):
                yield template(node.args[0])
        elif isinstance(node, ast.FunctionDef) and SAYING.match(node.name):
            for inner in ast.walk(node):
                if isinstance(inner, ast.Return | ast.Yield):
                    yield template(inner.value)


def sentences():
    for path in sorted([*ROOT.glob("core/**/*.py"), *ROOT.glob("synch_addon/**/*.py")]):
        if not UNSEEN.match(path.relative_to(ROOT).as_posix()):
            for text in raised_and_warned(path):
                if text is not None and not FOR_PROGRAMS.search(text):
                    yield text


def bare(text):
    """A sentence with {} for its parts, adjacent ones as one."""
    return re.sub(r"(\{(vertices)?\})+", "{}", text)


def of_table(text):
    parts = string.Formatter().parse(text)
    return bare("".join(literal + ("" if name is None else "{}") for literal, name, *_ in parts))


@pytest.fixture
def german(monkeypatch):
    both = GERMAN | WORDS
    monkeypatch.setattr(messages, "pgettext_rpt", lambda text, context: both.get(text, text))


def test_every_error_and_warning_has_its_sentence():
    there, found = {of_table(text) for text in GERMAN}, {bare(text) for text in sentences()}
    assert len(found) > 350
    assert sorted(found - there - BY_NUMBER) == []


def test_sentences_that_nothing_says_any_more_are_removed():
    said = {bare(text) for text in sentences()}
    rooms = (translations.german_messages_fields.FIELDS, translations.german_messages_shapes.SHAPES)
    rooms += (translations.german_messages_objects.OBJECTS, translations.german_messages_patterns.PATTERNS)
    assert sorted(text for room in rooms for text in room if of_table(text) not in said) == []


@pytest.mark.parametrize("text", [*GERMAN, *WORDS])
def test_parts_are_those_of_the_sentence(text):
    names = [name for _, name, *_ in string.Formatter().parse(text) if name is not None]
    others = [name for _, name, *_ in string.Formatter().parse((GERMAN | WORDS)[text]) if name is not None]
    assert sorted(names) == sorted(set(names)) == sorted(others)
    assert "" not in names and "}{" not in text.replace("}}", "").replace("{{", "")


def test_english_stays_as_it_is():
    line = "the vertex group 'Top' is empty: assign vertices to it"
    assert told(line) == line
    assert told("of no table at all") == "of no table at all"


def test_parts_are_filled_in_and_told_too(german):
    assert told("the vertex group 'Top' is empty: assign vertices to it") == (
        "die Punktgruppe 'Top' ist leer: ihr Punkte zuweisen"
    )
    text = "the constraint seams along holds no edge: mark edges with Mark Seam first, or remove the row"
    assert told(text) == (
        "die Bedingung seams along enthält keine Kante: zuerst Kanten als Naht markieren, oder die Zeile entfernen"
    )
    where = name_elements("vertex", [3, 5, 8, 13])
    assert told(f"row 2: the guidance vector of {where} is not finite: set its numbers") == (
        "Zeile 2: der Führungsvektor von Punkte 3, 5, 8 und 1 weitere ist nicht endlich: seine Zahlen setzen"
    )


def test_names_are_not_taken_for_words(german):
    assert WORDS["mesh"] == "das Netz"
    assert told("mesh has no faces: add some first") == "mesh hat keine Flächen: zuerst welche hinzufügen"
    assert told("the mesh mesh is linked: make it local with Object > Relations > Make Local") == (
        "das Netz mesh ist verknüpft: lokal machen mit Objekt > Beziehungen > Lokal machen"
    )


def test_braces_in_names_are_names(german):
    assert told("the vertex group '{x}' is empty: assign vertices to it") == (
        "die Punktgruppe '{x}' ist leer: ihr Punkte zuweisen"
    )
    assert (
        told("the name 'a' is the same for 2 maps: add {map}")
        == "der Name 'a' ist derselbe für 2 Bilder: {map} hinzufügen"
    )


def test_the_longest_sentence_is_taken(german):
    """Files' errors all begin with a path and a colon."""
    assert told("/a: b/c.vdb: no such file") == "/a: b/c.vdb: diese Datei gibt es nicht"
    assert told("s_#.vdb: no such file: frame 3 of the sequence is missing") == (
        "s_#.vdb: diese Datei gibt es nicht: Bild 3 der Folge fehlt"
    )


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("count", [1, 5])
def test_what_carriers_find_is_told_whole(german, name, count):
    elements = [[4, 5]] * count if KINDS[name][0] == "edge" else list(range(count))
    line = told(Finding(name, elements).line)
    assert not re.search(r"\b(the|has|have|more|and|faces?|vert\w+|their|they|out)\b", line), line


def test_rooms_of_memory_are_told_whole(german):
    left = room()
    line = (
        f"a solve of 9 phases takes about 2 GB of {left.name} and 1 GB are left: use a coarser mesh, or {left.remedy}"
    )
    assert not re.search(r"\b(the|of|are|takes|use|its|with|more)\b", told(line)), told(line)


@pytest.mark.skipif(not bpy.app.build_options.international, reason="this Blender has been built without languages")
def test_blender_finds_the_sentences_in_the_language_of_reports():
    view = bpy.context.preferences.view
    before, view.language = view.language, "de_DE"
    try:
        assert told("the mesh is empty: add some geometry first").startswith("das Netz ist leer")
    finally:
        view.language = before
