# SPDX-License-Identifier: GPL-3.0-or-later
"""What an object keeps of a solve as JSON in a property: enough for the panel, and to read the pattern back."""

from ...core.errors import SynchError
from ...core.files.border import border
from ...core.files.json_text import NUMBER, json_text, read_kept_dict
from ...core.geometry.manifold_repair import KINDS
from ...core.settings.surface import SurfaceSettings
from ...core.validation import from_names
from ..blender.schema import FORMAT

# Of what is kept, by its name: what it is where it is missing, and its kind.
_VALUES = {
    "format": (1, int),
    "command": ("", str),
    "energy": (None, NUMBER),
    "lower_bound": (None, NUMBER),
    "gap": (None, NUMBER),
    "certificate": (None, str),
    "status": ("", str),
    "nodes": (0, int),
    "carrier": ({}, dict),
    "disclinations": (0, int),
    "dislocations": (0, int),
    "seconds": (0.0, NUMBER),
    "settings": (None, dict),
    "evenness": (None, {"spacing": [NUMBER] * 5, "off_share": NUMBER}),
    "quad_mesh": (None, {"quad_share": NUMBER, "irregular_vertices": int}),
}


# Settings of earlier versions that are gone; no pattern depended on them.
GONE = ("straighten",)


def result_line(report):
    """What is kept of a report: figures for the panel, and the settings with which the pattern can be read back."""
    names = ("command", "energy", "lower_bound", "gap", "certificate", "status", "nodes", "carrier")
    counts = {kind: len(report[kind]) for kind in ("disclinations", "dislocations")}
    rest = {"seconds": report["times"]["total"], "settings": report["settings"], "evenness": report.get("evenness")}
    if "quad_mesh" in report:
        rest["quad_mesh"] = {name: report["quad_mesh"][name] for name in ("quad_share", "irregular_vertices")}
    return json_text({"format": FORMAT} | {name: report[name] for name in names} | counts | rest)


def read_result(line, name):
    """The dict that :func:`result_line` made; {} for "". Raises SettingError where others have spoilt it.

    ``name``: of the object.
    """
    found = read_kept_dict(line, f"the result that {name} keeps", _VALUES)
    for kind, count in found.get("carrier", {}).items():
        if kind not in KINDS or not isinstance(count, int):
            raise SynchError(f"the result that {name} keeps cannot be read (its carrier has {kind}): solve it again")
    return found


def read_settings(found, name):
    """The :class:`SurfaceSettings` of what :func:`read_result` gave; errors likewise."""
    with border(f"the result that {name} keeps", "solve it again"):
        return from_names(SurfaceSettings, {k: v for k, v in found["settings"].items() if k not in GONE})


def read_result_or_empty(line):
    """The :func:`read_result` of a line, for panels: {} where it is empty or cannot be read."""
    try:
        found = read_result(line, "")
    except SynchError:
        return {}
    return found if found.get("command") else {}
