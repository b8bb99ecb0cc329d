# SPDX-License-Identifier: GPL-3.0-or-later
"""The spacing map of a quad mesh: what is painted on it counts for the object that it was made of."""

import numpy as np

from ...core.geometry.nearest import NearestTriangles, nearest_in_triangles
from ..blender import attributes, groups, meshes, schema

# Change of a weight, as a share, from which on it was painted.
_LEAST = 1e-6


def note_map(made):
    """Note the weights that a new quad mesh has of its spacing map, so that later painting can be told apart."""
    name = made.synch.spacing_map if hasattr(made, "synch") else ""  # as long as the extension is registered
    if name and groups.is_group(made, name):
        attributes.write(made, schema.MAPPED, groups.read_weights(made, name))


def paint_back(made, source):
    """Add what was painted on a quad mesh in object mode to the weights of its source, which gets the group if need be;
    whether there was anything."""
    name = made.synch.spacing_map
    if not (name and groups.is_group(made, name)) or name in source.data.attributes:
        return False
    now, before = groups.read_weights(made, name), attributes.read(made, schema.MAPPED)
    is_new = name not in source.vertex_groups
    if before is None:
        before = np.zeros(len(now)) if is_new else now
    # How far towards 1 and towards 0 each vertex was painted: what is painted 1 is 1 at the source, too.
    up = np.divide(now - before, 1 - before, out=np.zeros(len(now)), where=now > before)
    down = np.divide(before - now, before, out=np.zeros(len(now)), where=now < before)
    if not (is_new or max(up.max(initial=0), down.max(initial=0)) > _LEAST):
        return False
    surface = NearestTriangles(meshes.measured_places(made), meshes.read_polygons(made).triangles)
    places, triangles = surface.nearest(meshes.measured_places(source))
    corners = surface.triangles[triangles]
    shares = nearest_in_triangles(places, surface.vertices[corners.T])
    given = np.zeros(len(places)) if is_new else groups.read_weights(source, name)
    up, down = (np.einsum("nk,nk->n", shares, way[corners]) for way in (up, down))
    groups.write_weights(source, name, np.clip(given + up * (1 - given) - down * given, 0.0, 1.0))
    attributes.write(made, schema.MAPPED, now)
    return True
