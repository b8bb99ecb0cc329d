# SPDX-License-Identifier: GPL-3.0-or-later
"""State of the curves that settings name: compared to see whether a pattern still follows them."""

import hashlib

import bpy
import numpy as np

from ..blender.changes import changes
from ..blender.strokes import SOURCE_TYPES, shape_of
from ..jobs.lru_cache import LruCache

# Decimals to which transforms are compared: rounding changes less, as where curve and mesh move together.
_DECIMALS = 5

_digests = LruCache(64)


def curves_read(obj, settings):
    """The curve objects that settings of a mesh object name, as a value that is equal while they look the same.

    ``settings``: SurfaceSettings, with the constraint list. Returns a tuple of (name, digest of the lines, transform in
    the space of the mesh object).
    """
    names = {row.name for row in settings.constraints if row.where == "curve"}
    names |= {source.name for source in settings.sources if source.kind in ("distance", "offset")}
    found = (bpy.data.objects.get(name) for name in sorted(names))
    return tuple(_look(obj, curve) for curve in found if curve is not None and curve.type in SOURCE_TYPES)


def _look(obj, curve):
    digest = _digests.renewed(curve.session_uid, (changes.state(curve), curve.mode), lambda: _digest(curve))
    place = np.round(np.array(obj.matrix_world.inverted_safe() @ curve.matrix_world), _DECIMALS) + 0.0
    return curve.name, digest, place.tobytes()


def _digest(curve):
    return hashlib.blake2b(b"".join(np.float32(line).tobytes() for line in shape_of(curve))).hexdigest()
