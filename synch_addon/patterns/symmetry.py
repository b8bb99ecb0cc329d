# SPDX-License-Identifier: GPL-3.0-or-later
"""The axes in which an object's mesh is its own mirror image, as far as its vertices and the middles of faces say, and
a Mirror modifier for those in which its halves differ."""

import numpy as np

from ...core.geometry.mirror import TOLERANCE, symmetric_axes
from ..blender import attributes
from ..blender.changes import changes
from ..jobs.lru_cache import LruCache

# Of larger meshes a redraw would take too long.
MOST_VERTICES = 100_000
# Name of the Mirror modifier, and up to which distance from the plane it joins vertices, as a share of the object.
_MODIFIER, _JOINED = "Synch Mirror", 1e-6
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


def crosses(obj, axis):
    """Whether the plane across an axis leads through what is seen of an object."""
    heights = [corner[axis] for corner in obj.bound_box]
    return min(heights) < 0 < max(heights)


def half_modifier(obj):
    """The modifier of :func:`toggle_half`, or None."""
    found = obj.modifiers.get(_MODIFIER)
    return found if found is not None and found.type == "MIRROR" else None


def toggle_half(obj, axis):
    """Mirror the half of an object on the positive side of an axis by a modifier, or no longer."""
    modifier = half_modifier(obj)
    if modifier is None:
        modifier = obj.modifiers.new(_MODIFIER, "MIRROR")
        modifier.use_axis = False, False, False
        modifier.merge_threshold = modifier.bisect_threshold = _JOINED * max(obj.dimensions)
        of_own_mesh = [number for number, one in enumerate(obj.modifiers) if one.type == "MULTIRES"]
        obj.modifiers.move(len(obj.modifiers) - 1, max(of_own_mesh, default=-1) + 1)
        modifier = half_modifier(obj)
    modifier.use_axis[axis] = modifier.use_bisect_axis[axis] = not modifier.use_axis[axis]
    if not any(modifier.use_axis):
        obj.modifiers.remove(modifier)


def _axes(obj):
    places = attributes.read_values(obj, "position", "POINT").astype(float)
    ends = attributes.read_values(obj, ".edge_verts", "EDGE")
    used = places[np.unique(ends)]
    if not np.isfinite(used).all():
        return ()
    lengths = np.linalg.norm(places[ends[:, 0]] - places[ends[:, 1]], axis=1)
    centers = attributes.read_all(obj.data.polygons, "center", 3, np.float32).astype(float)
    return symmetric_axes(used, centers, TOLERANCE * np.median(lengths))
