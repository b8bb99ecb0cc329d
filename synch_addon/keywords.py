# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings from keyword arguments."""

from dataclasses import fields

from ..core.errors import SettingError


def from_names(cls, values):
    """The dataclass ``cls`` from keyword arguments, refusing names that do not exist."""
    known = [field.name for field in fields(cls)]
    for name in values:
        if name not in known:
            raise SettingError(f"the setting {name!r} is unknown: use one of {', '.join(known)}")
    return cls(**values)
