# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings as flags of the command line, made from their records, and back to plain settings."""

import json
import math

from ...core.errors import SettingError
from ...core.files.border import SETTINGS_BYTES, border, read_text
from ...core.settings.constraints import from_plain
from ...core.settings.setting import ANGLE, LENGTH, SECONDS, default_of, records, value_type
from ...core.validation import label_of
from .flags import add_choice

# What the help of a flag shows in place of a value, by the unit or by the type of its setting.
_PLACEHOLDERS = {LENGTH: "LENGTH", SECONDS: "SECONDS", ANGLE: "DEG", int: "N", float: "X", str: "NAME"}
_SEVERAL = {tuple[float, float, float]: ("X", "Y", "Z"), tuple[int, int]: ("FIRST", "LAST")}


def add_settings(command, kind, name, **defaults):
    """Add a flag to a command's parser for each setting of a group, a class of settings, that the named command has.

    ``defaults`` are those of flags whose default is not that of the setting, by the setting's name.
    """
    for setting, record in records(kind):
        if name in record.commands:
            default = defaults[setting] if setting in defaults else default_of(kind, setting, name)
            _add_flag(command, setting, record, value_type(kind, setting), default)


def _add_flag(command, setting, record, of_type, default):
    """Add the flag of a setting: a switch, a choice, several numbers, or one value in the record's unit."""
    flag, tip = f"--{(record.flag or setting).replace('_', '-')}", _help(record)
    if of_type is bool:
        command.add_argument(flag, dest=setting, action="store_true", help=tip)
    elif record.choices and of_type is str:
        add_choice(command, flag, record.choice_names, default, tip, dest=setting)
    elif of_type in _SEVERAL:
        names, number = _SEVERAL[of_type], of_type.__args__[0]
        command.add_argument(
            flag, dest=setting, nargs=len(names), type=number, metavar=names, help=_with_default(tip, record, None)
        )
    else:
        if record.unit == ANGLE and default is not None:
            default = round(math.degrees(default), 4)
        if record.choices:
            default, tip = ",".join(default), f"{tip}: some of {','.join(record.choice_names)}"
        if record.part_of:  # so that it can be told whether it was given
            tip, default = f"{tip} ({default:g})", None
        else:
            tip = _with_default(tip, record, default)
        number = of_type if of_type in (int, float) else str
        placeholder = record.placeholder or _PLACEHOLDERS.get(record.unit) or _PLACEHOLDERS[number]
        command.add_argument(flag, dest=setting, type=number, default=default, metavar=placeholder, help=tip)


def _help(record):
    """The tip as a line of help, whose sentences begin with a small letter."""
    tip = record.tip.replace("%", "%%")
    return tip if tip[1:2].isupper() else tip[:1].lower() + tip[1:]


def _with_default(tip, record, default):
    if default not in (None, ""):
        return f"{tip} (%(default)s)"
    return f"{tip}; default: {record.unset}" if record.unset else tip


def settings_of(options, kind, **apart):
    """The settings of a group that the flags of a command stand for; ``apart`` are values that are given otherwise.

    Raises SettingError for values that are not allowed, alone or together.
    """
    values = {}
    for name, record in records(kind):
        if name in apart or not hasattr(options, name) or options.command not in record.commands:
            continue
        value = getattr(options, name)
        if record.part_of:
            if value is None:
                continue
            if not getattr(options, record.part_of):
                raise SettingError(
                    f"the {label_of(name)} belongs to a {label_of(record.part_of)}: "
                    f"add --{record.part_of.replace('_', '-')} NAME"
                )
        values[name] = _read(name, record, value)
    if values.get("vertex_group") and values.get("boundary") == "free":
        raise SettingError(
            f"the vertex group {values['vertex_group']!r} restricts the boundary, which is free: "
            "add --boundary along, across or phase"
        )
    return kind(**values | apart)


def _read(name, record, value):
    """A flag's value as the setting has it."""
    if name == "constraints":
        return None if value is None else _read_constraints(value)
    if name == "mirror":
        return value.upper()
    if record.unit == ANGLE:
        return math.radians(value)
    return tuple(value) if isinstance(value, list) else value


def _read_constraints(path):
    with border(path, "write a JSON list of rows"):
        return from_plain(json.loads(read_text(path, SETTINGS_BYTES)))
