# SPDX-License-Identifier: GPL-3.0-or-later
"""The axes in which an object is its own mirror image: its mesh, as far as its vertices and the middles of faces say,
or only its shape."""

import numpy as np

from ...core.geometry.mirror import TOLERANCE, symmetric_axes
from ..blender import attributes
from ..blender.changes import changes
from ..jobs.lru_cache import LruCache

# Of larger meshes a redraw would take too long.
MOST_VERTICES = 100_000
# Meshes of the same shape have nearly all vertices within an edge of those of their mirror images.
SAME_SHAPE = 0.95
# Of the last four objects that were asked for.
_kept = LruCache(4)


def mirror_axes(obj, of_shape=False):
    """The axes, 0, 1 or 2, of an object's mesh or of its shape, kept until it changes and while it is edited; none of a
    very large mesh."""
    if obj.mode != "OBJECT":
        found = _kept.get(obj.session_uid)
        return found[1][of_shape] if found else ()
    if not 0 < len(obj.data.vertices) <= MOST_VERTICES or len(obj.data.edges) == 0:
        return ()
    return _kept.renewed(obj.session_uid, changes.state(obj.data), lambda: _axes(obj))[of_shape]


def _axes(obj):
    places = attributes.read_values(obj, "position", "POINT").astype(float)
    ends = attributes.read_values(obj, ".edge_verts", "EDGE")
    used = places[np.unique(ends)]
    if not np.isfinite(used).all():
        return (), ()
    edge = np.median(np.linalg.norm(places[ends[:, 0]] - places[ends[:, 1]], axis=1))
    centers = attributes.read_all(obj.data.polygons, "center", 3, np.float32).astype(float)
    exact = symmetric_axes(used, centers, TOLERANCE * edge)
    return exact, tuple(sorted({*exact, *symmetric_axes(used, used[:0], edge, SAME_SHAPE)}))
