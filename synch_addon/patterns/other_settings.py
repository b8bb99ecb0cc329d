# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an object shows a pattern of other settings than it has now."""

import math
from dataclasses import asdict

from ...core.errors import SynchError
from ..jobs.kept_results import read_result_or_empty
from ..settings.fields import stored_settings

# Settings that are compared, and the spacing where it is set.
_NAMES = {"guidance", "symmetry", "angle", "mirror", "branching", "singularities", "aspect", "boundary"}


def shows_other_settings(obj, kind):
    """Whether an object shows a pattern of a kind that was solved with other settings than the panel has now."""
    result = read_result_or_empty(obj.synch.result)
    if kind not in {"stripes", "quads"} or result.get("command") != kind or not result.get("settings"):
        return False
    try:
        now = asdict(stored_settings(obj).for_command(kind))
    except SynchError:
        return False
    names = _NAMES if obj.synch.automatic_spacing else {*_NAMES, "spacing"}
    return any(not _are_same(now[name], result["settings"].get(name, now[name])) for name in names)


def _are_same(first, second):
    numbers = isinstance(first, float | int) and isinstance(second, float | int)
    return math.isclose(first, second, rel_tol=1e-4, abs_tol=1e-6) if numbers else first == second
