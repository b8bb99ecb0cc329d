# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings as Blender properties, made from their records, and back to plain settings."""

from collections.abc import Collection
from typing import Any

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ...core.settings.setting import (
    ANGLE,
    FILE,
    FOLDER,
    LENGTH,
    NUMBERS,
    PIXELS,
    SHARE,
    SMALLEST,
    Setting,
    SettingsRecord,
    default_of,
    records,
    value_type,
)
from .suggestions import suggest_numbers

# Limits of whole numbers in Blender.
_MOST = 2**31 - 1
# Numbers that go so far change by so much with the arrows of their fields.
_MANY, _COARSE = 10_000, 100
_SUBTYPES = {LENGTH: "DISTANCE", ANGLE: "ANGLE", PIXELS: "PIXEL", FILE: "FILE_PATH", FOLDER: "DIR_PATH"}


def property_of(kind: type[SettingsRecord], setting: str, command: str = "", /, **more: Any) -> Any:
    """Blender's property of a named setting of a group, or of a command's variant of it; ``more`` are arguments of the
    property that are not those of the record."""
    record = dict(records(kind))[setting]
    variant = record.variants.get(command)
    given = {
        "name": variant.label if command and variant else record.label,
        "description": variant.tip if command and variant else record.tip,
    }
    default, of_type = default_of(kind, setting, command), value_type(kind, setting)
    if record.choices:
        return EnumProperty(**given | _choices(record, default) | more)
    if of_type is bool:
        return BoolProperty(**given | {"default": default} | more)
    if of_type in (int, float):
        make = IntProperty if of_type is int else FloatProperty
        return make(**given | _number(record, of_type, default) | more)
    if record.names == NUMBERS:
        given["search"] = suggest_numbers
    if record.names in _SUBTYPES:
        given["subtype"] = _SUBTYPES[record.names]
    return StringProperty(**given | {"default": default or ""} | more)


def identifier_of(name: str) -> str:
    """Blender's identifier of a choice."""
    return name.upper().replace("-", "_")


def _choices(record: Setting, default: Any) -> dict[str, Any]:
    many = isinstance(default, tuple)
    items = [
        (identifier_of(choice.name), choice.label, choice.tip, choice.icon, 1 << number if many else number)
        for number, choice in enumerate(record.choices)
    ]
    if many:
        return {"items": items, "default": set(map(identifier_of, default)), "options": {"ENUM_FLAG"}}
    return {"items": items, "default": identifier_of(default)}


def _number(record: Setting, of_type: type, default: Any) -> dict[str, Any]:
    """Default and limits; shares are shown in per cent."""
    start = record.start if default is None else default
    low, high = record.usual
    if record.unit == SHARE and record.most == 1:
        return {"default": 100.0 * start, "min": 0.0, "max": 100.0, "subtype": "PERCENTAGE", "precision": 0}
    scale = {
        "default": start or 0,
        "min": None if record.least == SMALLEST else record.least,
        "max": record.most,
        "soft_min": low,
        "soft_max": high,
    }
    if of_type is int:
        scale = {
            name: value if value is None else round(max(min(value, _MOST), -_MOST)) for name, value in scale.items()
        }
        scale["step"] = _COARSE if (high or 0) >= _MANY else 1
    if record.unit in (LENGTH, SHARE):
        scale["precision"] = 4
    if record.unit in _SUBTYPES:
        scale["subtype"] = _SUBTYPES[record.unit]
    return {name: value for name, value in scale.items() if value is not None}


def properties_of(kind: type[SettingsRecord], names: Collection[str], **own: Any) -> type:
    """A class to mix into property groups and operators, with the properties of the named settings of a group.

    ``own`` are properties that replace or join those that the records give, by name.
    """
    made = {name: own.pop(name) if name in own else property_of(kind, name) for name in names}
    return type(f"{kind.__name__}Properties", (), {"__annotations__": made | own})


def settings_of(kind: type[SettingsRecord], properties: Any, names: Collection[str], **apart: Any) -> Any:
    """The named settings of a group from a property group or an operator; ``apart`` are values that are given
    otherwise."""
    known = dict(records(kind))
    values = {name: _plain(known[name], getattr(properties, name)) for name in names if name not in apart}
    return kind(**values | apart)


def values_of(settings: SettingsRecord, names: Collection[str]) -> dict[str, Any]:
    """Named settings as the values of their properties, by name: the inverse of :func:`settings_of`."""
    known = dict(records(type(settings)))
    return {name: _shown(known[name], getattr(settings, name)) for name in names}


def _shown(record: Setting, value: Any) -> Any:
    """A setting's value as its property has it."""
    if record.choices:
        return identifier_of(value) if isinstance(value, str) else set(map(identifier_of, value))
    if record.unit == SHARE and record.most == 1:
        return 100 * value
    return min(max(value, -(2**31)), 2**31 - 1) if isinstance(value, int) else value  # as long as Blender's integers


def _plain(record: Setting, value: Any) -> Any:
    """A property's value as the setting has it."""
    if record.choices:
        by_identifier = {identifier_of(name): name for name in record.choice_names}
        return by_identifier[value] if isinstance(value, str) else tuple(map(by_identifier.get, value))
    return value / 100 if record.unit == SHARE and record.most == 1 else value
