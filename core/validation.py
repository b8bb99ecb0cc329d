# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings from keyword arguments, and what their values may be."""

import math
from dataclasses import fields
from numbers import Integral, Real
from pathlib import PurePath
from types import UnionType
from typing import Any, get_args, get_type_hints

import numpy as np

from .errors import SettingError, quote_value

# The largest whole number that files and Blender keep, and how often anything is smoothed.
MOST, MOST_ROUNDS = 2**63 - 1, 10_000
# Sizes of numbers that single precision, in which Blender and its files keep them, tells from 0 and from infinity, and
# whose cubes and squares double precision does. Whether infinity makes sense is for each setting to say.
LEAST_SIZE, MOST_SIZE = 1e-30, 1e30
# Blender has no frame from here on.
FRAMES_END = 2**20
# Of simple fields: what is taken for them, NumPy's kinds included, and what errors ask for.
_KINDS: dict[type, tuple[Any, str]] = {
    bool: ((bool, np.bool_), "True or False"),
    int: (Integral, "a whole number"),
    float: (Real, "a number"),
    str: (str, "a text"),
}


def from_names(cls, values):
    """The dataclass ``cls`` from keyword arguments, refusing names that do not exist."""
    known = [field.name for field in fields(cls)]
    for name in values:
        if name not in known:
            raise SettingError(f"the setting {name!r} is unknown: use one of {', '.join(known)}")
    return cls(**values)


def convert_values(settings):
    """Turn each value of a frozen dataclass into the kind that its field has, as :func:`convert_value` does."""
    for name, hint in get_type_hints(type(settings)).items():
        object.__setattr__(settings, name, convert_value(name, hint, getattr(settings, name)))


def convert_value(name, hint, value):
    """A value of a setting as the kind that it has; kinds that are not simple are looked at elsewhere."""
    wanted = get_args(hint) if isinstance(hint, UnionType) else (hint,)
    kinds = [kind for kind in wanted if kind in _KINDS]
    if not kinds or (value is None and type(None) in wanted):
        return value
    for kind in kinds:
        if isinstance(value, _KINDS[kind][0]) and (kind is bool or not isinstance(value, bool | np.bool_)):
            return check_text(value, f"the {label_of(name)}") if kind is str else _converted(name, kind, value)
    asked = " or ".join(_KINDS[kind][1] for kind in kinds)
    raise SettingError(f"the {label_of(name)} is {quote_value(value)}: give {asked}")


def _converted(name, kind, value):
    try:
        number = kind(value)
    except OverflowError:
        raise SettingError(f"the {label_of(name)} is {quote_value(value)}: give a smaller number") from None
    if kind is float and abs(number) != math.inf:
        check_size(number, f"the {label_of(name)}")
    return number


def check_size(number, what):
    """Refuse a number that is not finite, or whose size is not 0 and not between the least and the most."""
    if number == 0 or LEAST_SIZE <= abs(number) <= MOST_SIZE:
        return
    is_finite = abs(number) < math.inf  # math.isfinite does not take whole numbers of hundreds of digits
    asked = f"0, or a number between {LEAST_SIZE:g} and {MOST_SIZE:g} in size" if is_finite else "a finite number"
    raise SettingError(f"{what} is {quote_value(number)}: give {asked}")


def are_frames(first, last):
    """Whether two values are a first and a last frame of Blender's, in order."""
    whole = all(isinstance(frame, Integral) and not isinstance(frame, bool) for frame in (first, last))
    return whole and -FRAMES_END < first <= last < FRAMES_END


def check_text(text, what):
    """The text; refuses one that no name and no file can have, since it has halves of characters."""
    try:
        text.encode()
    except UnicodeEncodeError:
        raise SettingError(f"{what} is {quote_value(text)}, which is no text: write it as UTF-8") from None
    return text


def check_path(path, what="the path"):
    """The path as a text; refuses what no file can be called."""
    if not isinstance(path, str | PurePath):
        raise SettingError(f"{what} is {quote_value(path)}: give a text")
    if "\0" in str(path):
        raise SettingError(
            f"{what} is {quote_value(str(path))}, which has a null character: no file can be called that"
        )
    return check_text(str(path), what)


def check_choice(settings, name, choices):
    """Refuse a value that is none of the choices."""
    value = getattr(settings, name)
    if value not in choices:
        raise SettingError(f"the {label_of(name)} {quote_value(value)} is unknown: use one of {', '.join(choices)}")


def check_positive(settings, *names, optional=()):
    """Refuse values that are no positive, finite numbers; None will do for optional ones."""
    for name in (*names, *(name for name in optional if getattr(settings, name) is not None)):
        value = getattr(settings, name)
        if not isinstance(value, int | float) or not 0 < value < math.inf:
            raise SettingError(f"the {label_of(name)} is {quote_value(value)}: give a positive number")


def label_of(name):
    """A setting's name as messages write it."""
    return name.replace("_", " ")
