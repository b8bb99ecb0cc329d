# SPDX-License-Identifier: GPL-3.0-or-later
"""Parser of lists in one line of text, such as ``curvature-max=2,axis:Z`` or ``Top=layer,Bottom=constant``.

Items are separated by commas and follow a form: ``KIND``, names after colons, and a value after an equals sign. A name
that contains a comma, an equals sign, a double quote or a line end is written in double quotes, doubled inside, and so
is one with a colon unless it is the last name of the form.
"""

import re
from functools import cache
from typing import Any

from .errors import SettingError, quote_value

# Possessive quantifiers (*+) do not backtrack, so that the time grows linearly with the length.
_QUOTED = r'\s*+"(?:[^"]|"")*+"\s*+'
_NAMES = rf'({_QUOTED}|[^,:="\r\n]*+)', rf'({_QUOTED}|[^,="\r\n]*+)'


def items(text: str, what: str, form: str) -> list[tuple[Any, ...]]:
    """Split a text into its items: tuples with a str for each part of the form, None where it is missing.

    Raises SettingError for a text that cannot be read, quoted from the first error on, or a value that is not text.

    Parameters
    ----------
    what : name of the text in errors
    form : of each item, such as "KIND:NAME=STRENGTH" or "NAME=layer"; all but its first part are optional
    """
    if not isinstance(text, str):
        raise SettingError(f"the {what} is {quote_value(text)}: give a text such as {form}")
    result: list[tuple[str | None, ...]] = []
    place, end = 0, ","
    while end == ",":
        found = _pattern(form).match(text, place)
        if found is None:
            raise SettingError(
                f"the {what} {quote_value(text[place:].strip())} cannot be read: write {form}, "
                'and names with , : = or " in double quotes'
            )
        *parts, end = found.groups()
        result.append(tuple(part and _unquote(part) for part in parts))
        place = found.end()
    return result


@cache
def _pattern(form: str) -> re.Pattern[str]:
    """The regular expression of an item, with a group for each part of the form and one for what ends the item."""
    names, has_value, _ = form.partition("=")
    *others, _ = names.split(":")
    parts = [_NAMES[0]] * len(others) + [_NAMES[1]]
    if names.startswith("KIND"):
        parts[0] = r"\s*+([\w-]*+)"
    pattern = parts[0] + "".join(f"(?::{part})?" for part in parts[1:])
    return re.compile(pattern + (r"(?:=([^,=\"]*+))?" if has_value else "") + r"\s*+(,|$)")


def _unquote(part: str) -> str:
    part = part.strip()
    return part[1:-1].replace('""', '"') if part.startswith('"') else part


def quote_name(name: str) -> str:
    """Quote a name where the syntax needs it."""
    if re.search(r'[,:="\r\n]', name) or name != name.strip():
        return '"' + name.replace('"', '""') + '"'
    return name
