# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings from keyword arguments, and what their values may be."""

import math
from dataclasses import fields

from .errors import SettingError


def from_names(cls, values):
    """The dataclass ``cls`` from keyword arguments, refusing names that do not exist."""
    known = [field.name for field in fields(cls)]
    for name in values:
        if name not in known:
            raise SettingError(f"the setting {name!r} is unknown: use one of {', '.join(known)}")
    return cls(**values)


def check_choice(settings, name, choices):
    """Refuse a value that is none of the choices."""
    value = getattr(settings, name)
    if value not in choices:
        raise SettingError(f"the {_label(name)} {value!r} is unknown: use one of {', '.join(choices)}")


def check_whole(settings, *names):
    """Refuse values that are no whole numbers from 0 on."""
    for name in names:
        value = getattr(settings, name)
        if not isinstance(value, int) or value < 0:
            raise SettingError(f"the {_label(name)} is {value!r}: give a whole number from 0 on")


def check_positive(settings, *names, optional=()):
    """Refuse values that are no positive, finite numbers; None will do for optional ones."""
    for name in (*names, *(name for name in optional if getattr(settings, name) is not None)):
        value = getattr(settings, name)
        if not isinstance(value, int | float) or not 0 < value < math.inf:
            raise SettingError(f"the {_label(name)} is {value!r}: give a positive number")


def _label(name):
    return name.replace("_", " ")
