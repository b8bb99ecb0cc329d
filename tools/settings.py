# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write what is made from the records of the settings: `python tools/settings.py`.

core/settings/keywords.py holds the keyword arguments of the Python functions, for editors and type checkers;
docs/reference.md lists all settings with their flags, ranges and defaults. A test compares both with the records.
"""

import math
import sys
from pathlib import Path
from typing import get_type_hints

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "out" / "tree"))

from synch_fields.core import settings as core_settings  # noqa: E402
from synch_fields.core.settings.setting import ANGLE, LARGEST, SMALLEST, records  # noqa: E402

# What each group of settings is called in the manual.
TITLES = {
    "SurfaceSettings": "Directions, stripes, quads and quad meshes",
    "LayerSettings": "Layers in a solid",
    "FlowSettings": "Vortices of a flow",
    "LineSettings": "Lines as curves",
    "BakeSettings": "Bake",
}
_HEAD = """# SPDX-License-Identifier: GPL-3.0-or-later
\"\"\"The settings as keyword arguments of the Python functions; `python tools/settings.py` writes this file.\"\"\"

from typing import TypedDict

from .constraints import Constraint
"""
_REFERENCE = """# Reference of all settings

The names are the arguments of the Python functions. The flag of the command line has two dashes in front and dashes
for underscores, unless the table names another. Angles are radians in Python and degrees elsewhere; shares go from 0
to 1 in Python and on the command line, and from 0 to 100 % in the panel. [Settings](settings.md) says more about them.
"""
# What a text names, as the table says it.
_NAMED = {"numbers": "name of an attribute or vertex group", "folder": "path of a folder", "file": "path of a file"}


def groups():
    """The groups of settings, by name."""
    return {name: getattr(core_settings, name) for name in TITLES}


def keywords() -> str:
    """The text of core/settings/keywords.py."""
    parts, base = [_HEAD], core_settings.SolverSettings
    for kind in (base, *groups().values()):
        hints, inherits = get_type_hints(kind), kind is not base and issubclass(kind, base)
        own = [name for name, _ in records(kind) if not (inherits and name in base.__annotations__)]
        name, parent = kind.__name__.removesuffix("Settings"), "SolverKeywords" if inherits else "TypedDict"
        doc = f'    """Keywords of :class:`core.settings.{kind.__name__}`."""'
        lines = [f"    {setting}: {_spelled(hints[setting])}" for setting in own]
        parts.append("\n".join([f"class {name}Keywords({parent}, total=False):", doc, "", *lines]))
    return "\n\n\n".join(part.strip() for part in parts) + "\n"


def _spelled(hint) -> str:
    """A type as it is written in the source."""
    text = hint.__name__ if isinstance(hint, type) and not getattr(hint, "__args__", None) else str(hint)
    return text.replace(f"{core_settings.__name__}.constraints.", "")


def reference() -> str:
    """The text of docs/reference.md."""
    parts = [_REFERENCE]
    for name, kind in groups().items():
        rows = [_row(kind, setting, record) for setting, record in records(kind)]
        parts.append(
            f"## {TITLES[name]}\n\n| name | in the panel | values | default | what it does |\n|---|---|---|---|---|"
        )
        parts[-1] += "\n" + "\n".join(rows)
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _row(kind, setting, record) -> str:
    flag = f", `--{record.flag}`" if record.flag else ""
    default = next(item.default for item in kind.__dataclass_fields__.values() if item.name == setting)
    shown = _default(record, default)
    tip = record.tip.replace("|", "\\|").replace("\n", " ")
    return f"| `{setting}`{flag} | {record.label} | {_values(kind, setting, record)} | {shown} | {tip} |"


def _default(record, default) -> str:
    if record.variants:
        return ", ".join(
            f"{variant.default:g}{f' ({command})' if command else ''}" for command, variant in record.variants.items()
        )
    if default in (None, ""):
        return record.unset or "–"
    if isinstance(default, tuple):
        return ", ".join(default)
    if isinstance(default, bool):
        return "on" if default else "off"
    if record.unit == ANGLE and default:
        return f"{default:.4g} ({math.degrees(default):.4g}°)"
    return f"{default:g}" if isinstance(default, float) else f"{default}"


def _values(kind, setting, record) -> str:
    """What a setting may be."""
    if record.choices:
        return ", ".join(f"`{name}`" for name in record.choice_names)
    hint = str(get_type_hints(kind)[setting])
    if "bool" in hint:
        return "on or off"
    if "tuple" in hint or "str" in hint:
        return _NAMED.get(record.names, "text")
    unit = f"{record.unit} " if record.unit else ""
    low = "" if record.least <= -LARGEST else "above 0 " if record.least == SMALLEST else f"from {record.least:g} "
    high = "" if record.most >= LARGEST else f"to {record.most:.6g}"
    number = "whole number " if "int" in hint else "" if unit else "number "
    return f"{unit}{number}{low}{high}".strip()


def main() -> None:
    (ROOT / "core" / "settings" / "keywords.py").write_text(keywords(), encoding="utf-8")
    (ROOT / "docs" / "reference.md").write_text(reference(), encoding="utf-8")


if __name__ == "__main__":
    main()
