# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed mesh objects for layers, and what is read of the layers that were made."""

import bpy
import numpy as np

from synch_fields.synch_addon.solids import memory

from .scenes import add_group, add_object, attribute

# Of the layers in a block.
SPACING = 0.3


def in_world(obj, points):
    """Points of the solid of an object with layers, in the world."""
    matrix = memory.recall_layers(obj).matrix
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def block(size=(1.0, 1.0, 1.0), faces=(2, 2, 2)):
    """A box of quads around the origin; groups "Bottom" and "Top" hold its faces at the ends of Z."""
    axes = [np.linspace(-length / 2, length / 2, count + 1) for length, count in zip(size, faces, strict=True)]
    numbers, quads = {}, []

    def at(*place):
        return numbers.setdefault(place, len(numbers))

    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, faces[axis]):
            for i in range(faces[u]):
                for j in range(faces[v]):
                    corners = []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        place = [0, 0, 0]
                        place[axis], place[u], place[v] = side, a, b
                        corners.append(at(*place))
                    quads.append(corners if side else corners[::-1])
    places = np.array([[axes[k][place[k]] for k in range(3)] for place in numbers])
    obj = add_object(places, quads, "Block")
    for name, height in (("Bottom", -size[2] / 2), ("Top", size[2] / 2)):
        add_group(obj, name, np.flatnonzero(np.abs(places[:, 2] - height) < 1e-9))
    return obj


def bent_bar(angle=np.pi / 2, inner=1.0, outer=2.0, width=0.6, faces=(16, 4, 4)):
    """A bar bent around Y through an angle; groups "Begin" and "End" hold its end faces."""
    obj = block(faces=faces)
    places = attribute(obj, "position").astype(float) + 0.5
    turn, radius = angle * places[:, 0], inner + (outer - inner) * places[:, 2]
    bent = np.column_stack([-radius * np.cos(turn), width * (places[:, 1] - 0.5), radius * np.sin(turn)])
    obj.data.vertices.foreach_set("co", bent.astype(np.float32).ravel())
    obj.data.update()
    for group in list(obj.vertex_groups):
        obj.vertex_groups.remove(group)
    add_group(obj, "Begin", np.flatnonzero(places[:, 0] < 1e-6))
    add_group(obj, "End", np.flatnonzero(places[:, 0] > 1 - 1e-6))
    return obj


def triangles_of(obj):
    """(t, 3) vertices of an object of triangles."""
    corners = np.empty(3 * len(obj.data.polygons), np.int32)
    obj.data.polygons.foreach_get("vertices", corners)
    return corners.reshape(-1, 3)


def layers_of(obj):
    """World positions of the vertices of each layer, from bottom to top."""
    matrix = np.array(obj.matrix_world)
    places = attribute(obj, "position").astype(float) @ matrix[:3, :3].T + matrix[:3, 3]
    number, triangles = attribute(obj, "synch_layer"), triangles_of(obj)
    return [places[np.unique(triangles[number == k])] for k in range(number.max() + 1)]


def made(report, kind="layers"):
    """An object that a run has made."""
    return bpy.data.objects[report[f"{kind}_object"]]


def placed(obj):
    """(n, 3) the vertices of an object in the world."""
    matrix = np.array(obj.matrix_world)
    return attribute(obj, "position") @ matrix[:3, :3].T + matrix[:3, 3]
