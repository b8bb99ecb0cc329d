# SPDX-License-Identifier: GPL-3.0-or-later
"""The loops of quads of an object's own mesh."""

import numpy as np

from ...core.extract.quads.measure.loops import quad_loops
from ...core.extract.quads.trace.quad_mesh import QuadMesh
from ..blender import attributes, meshes
from ..blender.changes import changes
from ..jobs.lru_cache import LruCache

# Of the last four objects that were asked for.
_kept = LruCache(4)


def loops_of(obj):
    """The :class:`QuadLoops` of the mesh of an object in object mode, kept until the mesh changes."""
    return _kept.renewed(obj.session_uid, changes.state(obj.data), lambda: quad_loops(_quads(obj)))


def shown_edge(obj):
    """The edge whose loop an object shows, -1 for none; to ask for it does not change the object, as Blender's own
    properties do when they are read for the first time."""
    return obj.synch_loop.edge if obj.is_property_set("synch_loop") else -1


def faces_of_loop(obj, edge):
    """(f,) bool: the faces of the loop that passes through an edge, and whether it is a spiral; no face where no loop
    does."""
    loops = loops_of(obj)
    faces = np.zeros(len(loops.quads.sizes), bool)
    edges = attributes.read_values(obj, ".corner_edge", "CORNER")
    at = np.flatnonzero(edges == edge)[:1]
    loop = loops.corner_loops[at] if len(at) else np.array([-1])
    if loop[0] < 0:
        return faces, False
    faces[loops.quads.corner_faces[loops.corner_loops == loop]] = True
    # Sides of other faces that the loop ends at are not of it.
    return faces & (loops.quads.sizes == 4), bool(loops.spirals[loop[0]])


def _quads(obj):
    polygons = meshes.read_polygons(obj)
    places = attributes.read_values(obj, "position", "POINT")
    return QuadMesh(places, np.empty(0, int), np.empty((0, 3)), polygons.corner_vertices, polygons.sizes)
