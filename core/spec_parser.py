# SPDX-License-Identifier: GPL-3.0-or-later
"""Lists of things with names, as one line of text such as ``curvature-max=2,axis:Z`` or ``Top=layer,Bottom=constant``.

Items are separated by commas, and look as a form says: ``KIND``, names behind colons, and a value behind an equals
sign. A name with a comma, an equals sign, a double quote or the end of a line goes in double quotes, which are doubled
inside, and so does one with a colon, unless it is the last one of the form.
"""

import re
from functools import cache

from .errors import SettingError, quote_value

# Nothing that is once read is given back (*+): the time grows with the length alone.
_QUOTED = r'\s*+"(?:[^"]|"")*+"\s*+'
_NAMES = rf'({_QUOTED}|[^,:="\r\n]*+)', rf'({_QUOTED}|[^,="\r\n]*+)'


def items(text, what, form):
    """The items of a text.

    Parameters
    ----------
    text : str
    what : the text is, for the error
    form : of each item, such as "KIND:NAME=STRENGTH" or "NAME=layer"; all but its first part may be missing

    Returns
    -------
    list of tuples with a str for each part of the form, None where it is missing

    Raises
    ------
    SettingError
        naming the place that cannot be read, or what is no text
    """
    if not isinstance(text, str):
        raise SettingError(f"the {what} is {quote_value(text)}: give a text such as {form}")
    result, place, end = [], 0, ","
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
def _pattern(form):
    names, has_value, _ = form.partition("=")
    *others, _ = names.split(":")
    parts = [_NAMES[0]] * len(others) + [_NAMES[1]]
    if names.startswith("KIND"):
        parts[0] = r"\s*+([\w-]*+)"
    pattern = parts[0] + "".join(f"(?::{part})?" for part in parts[1:])
    return re.compile(pattern + (r"(?:=([^,=\"]*+))?" if has_value else "") + r"\s*+(,|$)")


def _unquote(part):
    part = part.strip()
    return part[1:-1].replace('""', '"') if part.startswith('"') else part


def quote_name(name):
    """A name as it is written in a text."""
    if re.search(r'[,:="\r\n]', name) or name != name.strip():
        return '"' + name.replace('"', '""') + '"'
    return name
