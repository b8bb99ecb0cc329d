# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an object shows a pattern of other settings than it has now."""

import math
from dataclasses import asdict

from ...core.errors import SynchError
from ..jobs.kept_results import read_result_or_empty
from ..reading.surface import settings_for
from ..settings.fields import original_of, source_of, stored_settings

# Settings that are compared, those of quad meshes, and the spacing where it is set.
_NAMES = {"guidance", "symmetry", "angle", "mirror", "branching", "singularities", "aspect", "boundary"}
_QUAD_MESH_NAMES = {"faces", "features", "smoothing", "loops", "surface"}


def shows_other_settings(obj, kind):
    """Whether an object shows a pattern of a kind that was solved with other settings than the panel has now."""
    result = read_result_or_empty(obj.synch.result)
    if kind == "directions" or result.get("command") != kind or not result.get("settings"):
        return False
    if kind == "quad_mesh" and source_of(obj) is None:
        return False
    try:
        now = asdict(settings_for(kind, original_of(obj), stored_settings(obj)))
    except SynchError:
        return False
    names = set(_NAMES)
    if kind == "quad_mesh":
        names |= _QUAD_MESH_NAMES
        names -= set() if now["mirror"] else {"mirror"}  # it may be that of a modifier
    if not obj.synch.automatic_spacing and not (kind == "quad_mesh" and now["faces"]):
        names.add("spacing")
    return any(not _are_same(now[name], result["settings"].get(name, now[name])) for name in names)


def _are_same(first, second):
    numbers = isinstance(first, float | int) and isinstance(second, float | int)
    return math.isclose(first, second, rel_tol=1e-4, abs_tol=1e-6) if numbers else first == second
