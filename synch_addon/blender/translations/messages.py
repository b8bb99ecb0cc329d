# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors and warnings in the interface's language.

They are raised and collected in English, and stay so in reports, in scripts and on the command line. Where the window
shows one, its sentence is looked for among those of the tables, as a text with parts in braces. The parts are filled
into the sentence of the other language: those that are sentences or words of ours in that language, too.
"""

import re
from functools import lru_cache
from string import Formatter
from typing import NamedTuple

from bpy.app.translations import pgettext_rpt

# How the parts are called that are the user's, such as the name of an object, which single words of ours may equal.
_OWN = ("name", "path")
# Parts that are numbers of elements, one or more.
_NUMBERS, _DIGITS = ("i", "j", "index", "indices", "more"), re.compile(r"\d+(, \d+)*")
# Messages of which the sentence is kept: panels show the same ones at every drawing.
_KEPT = 256
# The context in which Blender looks our own words up: it has others for some.
OURS = "Synch"


class Sentence(NamedTuple):
    """A text with parts in braces.

    Attributes
    ----------
    text : with the names of its parts in braces
    fixed : what stands before, between and behind the parts
    parts : names of the parts, one less than ``fixed``
    """

    text: str
    fixed: tuple[str, ...]
    parts: tuple[str, ...]

    @classmethod
    def of(cls, text):
        fixed, parts = [""], []
        for literal, part, *_ in Formatter().parse(text):
            fixed[-1] += literal
            if part is not None:
                parts.append(part)
                fixed.append("")
        return cls(text, tuple(fixed), tuple(parts))

    def filled(self, line):
        """The parts of a line by their names, each up to the next that is fixed, or None for another sentence."""
        first, *between = self.fixed
        if not line.startswith(first):
            return None
        if not self.parts:
            return {} if line == first else None
        place, found = len(first), {}
        last = len(line) - len(between[-1])
        for part, literal in zip(self.parts[:-1], between[:-1], strict=True):
            end = line.find(literal, place, last)
            if end < 0:
                return None
            found[part], place = line[place:end], end + len(literal)
        if place > last or not line.endswith(between[-1]):
            return None
        found[self.parts[-1]] = line[place:last]
        numbers = (found[name] for name in _NUMBERS if name in found)
        return found if all(map(_DIGITS.fullmatch, numbers)) else None


class Sentences:
    """Those that a message may be made of.

    Parameters
    ----------
    texts : of sentences, with parts in braces
    words : that stand for settings and kinds of elements
    """

    def __init__(self, texts, words):
        # What says most comes first.
        self._sentences = sorted(map(Sentence.of, texts), key=lambda sentence: -len("".join(sentence.fixed)))
        self._words = frozenset(words)
        self._find = lru_cache(_KEPT)(self._look_for)

    def told(self, line):
        """A line in the interface's language, and as it is where there is none."""
        sentence, parts = self._find(line)
        if sentence is None:
            return line
        other = pgettext_rpt(sentence.text, OURS)
        if other == sentence.text:
            return line
        return other.format(**{name: self._told_part(name, part) for name, part in parts.items()})

    def _told_part(self, name, part):
        if part in self._words:
            return part if name.startswith(_OWN) else pgettext_rpt(part, OURS)
        return self.told(part)

    def _look_for(self, line):
        for sentence in self._sentences:
            parts = sentence.filled(line)
            if parts is not None:
                return sentence, parts
        return None, None
