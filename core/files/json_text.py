# SPDX-License-Identifier: GPL-3.0-or-later
"""JSON that every reader accepts: reports are written, and the parts that objects keep are read and checked."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .border import border

# Kinds of values that :func:`read_kept_dict` knows besides types, dicts of kinds, and lists of kinds.
NUMBER = (int, float)
# An object of JSON, such as a report.
Json = dict[str, Any]


def json_text(value: object, indent: int | None = None) -> str:
    """A report as JSON; see :func:`plain`."""
    return json.dumps(plain(value), indent=indent, allow_nan=False)


def plain(value: Any) -> Any:
    """The value with JSON's types: NumPy's numbers and arrays become Python's, numbers that are not finite None."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def read_kept_dict(text: str, source: str | Path, kinds: Mapping[str, tuple[Any, Any]]) -> dict[str, Any]:
    """Read a dict that a property of an object or a file keeps as JSON, and check it, since others can write there.

    Parameters
    ----------
    text : "" for an empty dict
    source : where it was kept, for errors
    kinds : default and kind of each known value by its name: a kind is a type or several, a dict of kinds by name, or a
        list of kinds; other names stay as they are, and None is allowed where it is the default

    Returns a dict with all names of ``kinds``; {} for "".

    Raises SettingError naming the source and the first value of another kind.
    """
    if not text:
        return {}
    with border(source, "solve it again"):
        found = json.loads(text)
        if not isinstance(found, dict):
            raise ValueError("it is not a table of names and values")
        found = {name: default for name, (default, _) in kinds.items()} | found
        for name, (default, kind) in kinds.items():
            if not (found[name] is None and default is None):
                _check(found[name], kind, name)
        return found


def read_kept_names(text: str, source: str | Path) -> list[str]:
    """Read a list of names that a property keeps as JSON; [] for ""; errors as :func:`read_kept_dict`."""
    if not text:
        return []
    with border(source, "solve it again"):
        names = json.loads(text)
        _check(names, [str] * len(names), "list")
        return names


def _check(value: Any, kind: Any, name: str) -> None:
    """Raise ValueError for a value of another kind."""
    if isinstance(kind, dict):
        right = isinstance(value, dict)
        parts = [(value.get(key, None), own, key) for key, own in kind.items()] if right else []
    elif isinstance(kind, list):
        right = isinstance(value, list) and len(value) == len(kind)
        parts = [(item, own, name) for item, own in zip(value, kind, strict=True)] if right else []
    else:
        right = isinstance(value, kind) and not isinstance(value, bool)
        right = right and not (isinstance(value, float) and not math.isfinite(value))
        parts = []
    if not right:
        raise ValueError(f"its {name} is of another kind")
    for part in parts:
        _check(*part)
