# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings from keyword arguments, and the checks of their values."""

import math
from collections.abc import Collection, Mapping
from dataclasses import fields
from numbers import Integral, Real
from pathlib import PurePath
from types import UnionType
from typing import TYPE_CHECKING, Any, TypeVar, get_args, get_type_hints

import numpy as np

from .errors import SettingError, quote_value

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Record = TypeVar("Record", bound="DataclassInstance")

# The largest whole number that files and Blender store, and the most rounds of any smoothing.
MOST, MOST_ROUNDS = 2**63 - 1, 10_000
# Sizes of numbers that differ from 0 and infinity in single precision, in which Blender stores them, and whose squares
# and cubes do in double precision. Each setting decides whether infinity makes sense.
LEAST_SIZE, MOST_SIZE = 1e-30, 1e30
# Blender's frames are below this.
FRAMES_END = 2**20
# Simple types: the types accepted for them, NumPy's included, and their names in errors.
_KINDS: dict[type, tuple[Any, str]] = {
    bool: ((bool, np.bool_), "True or False"),
    int: (Integral, "a whole number"),
    float: (Real, "a number"),
    str: (str, "a text"),
}


def from_names(cls: type[Record], values: Mapping[str, Any]) -> Record:
    """Build the dataclass ``cls`` from keyword arguments; unknown names raise a SettingError."""
    known = [field.name for field in fields(cls)]
    for name in values:
        if name not in known:
            raise SettingError(f"the setting {name!r} is unknown: use one of {', '.join(known)}")
    return cls(**values)


def convert_values(settings: object) -> None:
    """Convert each value of a frozen dataclass to the type of its field, as :func:`convert_value` does."""
    for name, hint in get_type_hints(type(settings)).items():
        object.__setattr__(settings, name, convert_value(name, hint, getattr(settings, name)))


def convert_value(name: str, hint: object, value: Any) -> Any:
    """Convert a value to the type hint of its setting; types that are not simple are checked elsewhere."""
    wanted = get_args(hint) if isinstance(hint, UnionType) else (hint,)
    kinds = [kind for kind in wanted if kind in _KINDS]
    if not kinds or (value is None and type(None) in wanted):
        return value
    for kind in kinds:
        if isinstance(value, _KINDS[kind][0]) and (kind is bool or not isinstance(value, bool | np.bool_)):
            return check_text(value, f"the {label_of(name)}") if kind is str else _convert_number(name, kind, value)
    asked = " or ".join(_KINDS[kind][1] for kind in kinds)
    raise SettingError(f"the {label_of(name)} is {quote_value(value)}: give {asked}")


def _convert_number(name: str, kind: type, value: Any) -> float:
    try:
        number = kind(value)
    except OverflowError:
        raise SettingError(f"the {label_of(name)} is {quote_value(value)}: give a smaller number") from None
    if kind is float and abs(number) != math.inf:
        check_size(number, f"the {label_of(name)}")
    return number


def check_size(number: float, what: str) -> None:
    """Refuse a number that is not finite, or neither 0 nor of a size that single precision can store."""
    if number == 0 or LEAST_SIZE <= abs(number) <= MOST_SIZE:
        return
    is_finite = abs(number) < math.inf  # math.isfinite refuses whole numbers of hundreds of digits
    asked = f"0, or a number between {LEAST_SIZE:g} and {MOST_SIZE:g} in size" if is_finite else "a finite number"
    raise SettingError(f"{what} is {quote_value(number)}: give {asked}")


def are_frames(first: Any, last: Any) -> bool:
    """Tell whether two values are a first and a last frame of Blender, in order."""
    whole = all(isinstance(frame, Integral) and not isinstance(frame, bool) for frame in (first, last))
    return whole and bool(-FRAMES_END < first <= last < FRAMES_END)


def check_text(text: str, what: str) -> str:
    """Return the text, refusing one with lone surrogates, which no name and no file can have."""
    try:
        text.encode()
    except UnicodeEncodeError:
        raise SettingError(f"{what} is {quote_value(text)}, which is not text: write it as UTF-8") from None
    return text


def check_path(path: object, what: str = "the path") -> str:
    """Return the path as a text, refusing what cannot name a file."""
    if not isinstance(path, str | PurePath):
        raise SettingError(f"{what} is {quote_value(path)}: give a text")
    if "\0" in str(path):
        raise SettingError(
            f"{what} is {quote_value(str(path))}, which has a null character: no file can be called that"
        )
    return check_text(str(path), what)


def check_choice(settings: object, name: str, choices: Collection[str]) -> None:
    """Refuse a value that is not one of the choices."""
    value = getattr(settings, name)
    if value not in choices:
        raise SettingError(f"the {label_of(name)} {quote_value(value)} is unknown: use one of {', '.join(choices)}")


def check_positive(settings: object, *names: str) -> None:
    """Refuse values that are not positive, finite numbers."""
    for name in names:
        value = getattr(settings, name)
        if not isinstance(value, int | float) or not 0 < value < math.inf:
            raise SettingError(f"the {label_of(name)} is {quote_value(value)}: give a positive number")


def label_of(name: str) -> str:
    """Write a setting's name as messages do."""
    return name.replace("_", " ")
