# SPDX-License-Identifier: GPL-3.0-or-later
"""The axes in which the vertices and the middles of faces of an object's mesh are their own mirror images."""

import numpy as np

from ...core.geometry.mirror import TOLERANCE, symmetric_axes
from ..blender import attributes
from ..blender.changes import changes
from ..jobs.lru_cache import LruCache

# Of larger meshes a redraw would take too long.
MOST_VERTICES = 100_000
# Of the last four objects that were asked for.
_kept = LruCache(4)


def mirror_axes(obj):
    """The axes, 0, 1 or 2, of an object, kept until its mesh changes and while it is edited; none of a very large
    mesh."""
    if obj.mode != "OBJECT":
        return (_kept.get(obj.session_uid) or (None, ()))[1]
    if not 0 < len(obj.data.vertices) <= MOST_VERTICES or len(obj.data.edges) == 0:
        return ()
    return _kept.renewed(obj.session_uid, changes.state(obj.data), lambda: _axes(obj))


def _axes(obj):
    places = attributes.read_values(obj, "position", "POINT").astype(float)
    ends = attributes.read_values(obj, ".edge_verts", "EDGE")
    used = places[np.unique(ends)]
    if not np.isfinite(used).all():
        return ()
    lengths = np.linalg.norm(places[ends[:, 0]] - places[ends[:, 1]], axis=1)
    centers = attributes.read_all(obj.data.polygons, "center", 3, np.float32).astype(float)
    return symmetric_axes(used, centers, TOLERANCE * np.median(lengths))
