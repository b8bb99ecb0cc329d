# SPDX-License-Identifier: GPL-3.0-or-later
"""One record for each setting, from which Python, Blender's panel, the command line and the manual are made.

A group of settings is a frozen dataclass derived from :class:`SettingsRecord`. Each of its fields is declared by
:func:`setting`, or a partial of it, which adds a :class:`Setting` to the type and the default:

    spacing: float | None = setting(None, "Spacing", "Distance from one stripe to the next", unit=LENGTH)

The values are checked when the dataclass is made. ``synch_addon/settings/rna.py`` makes Blender's properties from the
records, ``synch_addon/command/flags.py`` the flags, and ``tools/settings.py`` the keywords of the Python functions and
the manual's reference.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from inspect import get_annotations
from types import UnionType
from typing import Any, get_args, get_type_hints

from ..errors import SettingError, quote_value
from ..validation import LEAST_SIZE, MOST_SIZE, convert_value, label_of

# Units of numbers in Python. Panels show angles in degrees and shares in per cent, the command line angles in degrees.
LENGTH, ANGLE, SHARE, FACTOR, SECONDS, PIXELS = "scene units", "radians", "share", "factor", "seconds", "pixels"
# Kinds of names in a text, for which a panel can suggest values or open a file browser.
NUMBERS, FILE, FOLDER = "numbers", "file", "folder"
# The largest number of any setting, and the smallest positive one.
LARGEST, SMALLEST = MOST_SIZE, LEAST_SIZE


@dataclass(frozen=True)
class Choice:
    """One of the possible values of a setting.

    Attributes
    ----------
    name : in Python and on the command line
    label, tip : in the panel
    icon : Blender's name of an icon, "" for none
    """

    name: str
    label: str
    tip: str = ""
    icon: str = ""


@dataclass(frozen=True)
class Variant:
    """Default, label and tip of a setting that differ for one command."""

    default: Any
    label: str
    tip: str


@dataclass(frozen=True)
class Setting:
    """The properties of one setting besides its name, type and default.

    Attributes
    ----------
    label : in the panel
    tip : what it does, in one sentence, for the tooltip, the help of the flag and the manual
    unit : of a number, "" without one
    least, most : the smallest and the largest number
    usual : the smallest and the largest number on a slider, None for ``least`` and ``most``
    start : where the slider begins if the default is None
    choices : of a text, or of several texts
    names : kind of name in a text, "" for other texts
    unset : meaning of the default None, or of an empty text
    zero : what 0 means, which panels say beside it; "" where it is a number as others are
    commands : that have a flag for it
    group : part of the panel that draws it, "" for none
    flag : name of the flag, "" for the setting's own name
    placeholder : shown in the help of the flag in place of a value
    part_of : the setting without which this one has no effect, "" for none
    variants : by command, where the default None stands for the command's own
    """

    label: str
    tip: str
    unit: str = ""
    least: float = -LARGEST
    most: float = LARGEST
    usual: tuple[float | None, float | None] = (None, None)
    start: float | None = None
    choices: tuple[Choice, ...] = ()
    names: str = ""
    unset: str = ""
    zero: str = ""
    commands: tuple[str, ...] = ()
    group: str = ""
    flag: str = ""
    placeholder: str = ""
    part_of: str = ""
    variants: Mapping[str, Variant] = field(default_factory=dict)

    @property
    def choice_names(self) -> tuple[str, ...]:
        return tuple(choice.name for choice in self.choices)

    def check(self, name: str, value: object) -> None:
        """Raise SettingError for a number out of range, or a text that is not one of the choices."""
        if isinstance(value, bool) or value is None:
            return
        if isinstance(value, int | float):
            if not self.least <= value <= self.most:
                raise SettingError(f"the {label_of(name)} is {quote_value(value)}: give {self._range(type(value))}")
        elif self.choices and isinstance(value, str):
            if value not in self.choice_names:
                raise SettingError(
                    f"the {label_of(name)} {quote_value(value)} is unknown: use one of {', '.join(self.choice_names)}"
                )

    def _range(self, kind: type) -> str:
        """The allowed numbers, for a message."""
        noun = "a whole number" if kind is int else "a share" if self.unit == SHARE else "a number"
        if self.least == SMALLEST and self.most >= LARGEST:
            return "a positive number"
        if self.least <= -LARGEST:
            return "a finite number" if self.most >= LARGEST else f"{noun} up to {self.most:g}"
        start = f"{noun} from {self.least:g}"
        if self.most >= LARGEST:
            return f"{start} on"
        return f"{start} to {self.most:.12g}"


def setting(default: Any, label: str, tip: str, **record: Any) -> Any:
    """A field of a dataclass of settings; all other arguments are attributes of its :class:`Setting`."""
    return field(default=default, metadata={"setting": Setting(label, tip, **record)})


@dataclass(frozen=True, kw_only=True)
class SettingsRecord:
    """Base of all groups of settings: each value is converted to its declared type and checked against its record."""

    def __post_init__(self) -> None:
        hints = get_type_hints(type(self))
        for name, record in records(type(self)):
            value = convert_value(name, hints[name], getattr(self, name))
            record.check(name, value)
            object.__setattr__(self, name, value)


def records(kind: type[SettingsRecord]) -> Iterator[tuple[str, Setting]]:
    """Names and records of a group's settings: its own in the order of declaration, then the inherited ones."""
    inherited = {name for base in kind.__mro__[1:] for name in get_annotations(base)}
    ordered = sorted(fields(kind), key=lambda item: item.name in inherited)
    return ((item.name, item.metadata["setting"]) for item in ordered)


def value_type(kind: type[SettingsRecord], name: str) -> type:
    """The type of a setting's values besides None, such as float for ``float | None``."""
    hint = get_type_hints(kind)[name]
    options: tuple[type, ...] = get_args(hint) if isinstance(hint, UnionType) else (hint,)
    return next(option for option in options if option is not type(None))


def default_of(kind: type[SettingsRecord], name: str, command: str = "") -> Any:
    """The default of a setting for a command."""
    item = next(item for item in fields(kind) if item.name == name)
    variants = item.metadata["setting"].variants
    variant = variants.get(command, variants.get("")) if variants else None
    return item.default if variant is None else variant.default


def of_type(values: object, kind: type | tuple[type, ...], count: int) -> bool:
    """Whether a value is an iterable of ``count`` values of a type."""
    listed = list(values) if isinstance(values, Iterable) else []
    return len(listed) == count and all(isinstance(value, kind) and not isinstance(value, bool) for value in listed)
