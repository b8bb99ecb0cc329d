# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an object shows a pattern of other settings than it has now."""

import math
from dataclasses import asdict

from ...core.errors import SynchError
from ...core.settings.guidance import parse_guidance
from ..jobs.kept_results import read_result_or_empty
from ..reading.surface import settings_for
from ..settings.fields import RECORDS, original_of, source_of, stored_settings

# Settings that are compared where they are set, and those on which no pattern depends.
_SPACING, _OF_NO_PATTERN = "spacing", {"strict", "time_limit", "assign_material"}


def shows_other_settings(obj, kind):
    """Whether an object shows a pattern of a kind that was solved with other settings than the panel has now.

    Never for a quad mesh that was traced from a shown pattern: the panel has the settings of a quad mesh, not those of
    the pattern.
    """
    result = read_result_or_empty(obj.synch.result)
    if kind == "directions" or result.get("command") != kind or not result.get("settings"):
        return False
    if kind == "quad_mesh" and (source_of(obj) is None or not obj.synch.made_from):
        return False
    try:
        now = asdict(settings_for(kind, original_of(obj), stored_settings(obj)))
    except SynchError:
        return False
    before = _with_sources(result["settings"])
    now = _with_sources(now)
    return any(not _are_same(now[name], before.get(name, now[name])) for name in _compared(kind, now, obj))


def _with_sources(settings):
    """Settings with the sources of the guidance in place of its text, in which a strength of 1 may be left out."""
    try:
        sources = parse_guidance(settings["guidance"])
    except (SynchError, KeyError):  # others have written it
        return settings
    plain = [(source.kind, source.name, _strength(source)) for source in sources]
    return settings | {"guidance": plain} if plain else settings


def _strength(source):
    """The strength of a source; of an attribute without one None, which is not the same as 1."""
    return 1.0 if source.strength is None and source.kind != "attribute" else source.strength


def _compared(kind, settings, obj):
    """Names of the settings that a pattern of a kind depends on, beside the others."""
    for name, record in RECORDS.items():
        is_heard = kind in record.commands and name not in _OF_NO_PATTERN
        if not is_heard or (record.part_of and not settings[record.part_of]):
            continue
        if name == _SPACING and (obj.synch.automatic_spacing or (kind == "quad_mesh" and settings["faces"])):
            continue
        if (name == "vertex_group" and settings["boundary"] == "free") or (
            name in ("rounding", "target_gap") and settings["method"] != "sdp"
        ):
            continue
        yield name


def _are_same(first, second):
    if isinstance(first, list | tuple) and isinstance(second, list | tuple):
        return len(first) == len(second) and all(map(_are_same, first, second))
    if isinstance(first, dict) and isinstance(second, dict):
        return first.keys() == second.keys() and all(_are_same(first[name], second[name]) for name in first)
    numbers = isinstance(first, float | int) and isinstance(second, float | int)
    return math.isclose(first, second, rel_tol=1e-4, abs_tol=1e-6) if numbers else first == second
