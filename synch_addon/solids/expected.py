# SPDX-License-Identifier: GPL-3.0-or-later
"""How far apart layers will be and how large the tetrahedra, before they are made."""

import numpy as np

from ...core.errors import SettingError
from ...core.geometry.filling.lengths import Lengths, Measures
from ..blender.attributes import read_all
from ..blender.changes import changes
from ..jobs.lru_cache import LruCache

# Measures of the mesh that was measured last, by what it was known by.
_measured = LruCache(1)


def expected_lengths(obj, spacing=None, size=None):
    """The :class:`Lengths` of an object's layers, with the spacing and the size that are given; None where they are not
    known, since the mesh is being edited or encloses nothing, or where they are refused."""
    measures = measures_of(obj)
    try:
        return None if measures is None else Lengths.of(measures, spacing, size)
    except SettingError:  # the operator says what is wrong
        return None


def measures_of(obj):
    """Volume, area and bounds of an object's mesh, None where there is no volume; measured again where the mesh or its
    scale changes."""
    mesh = obj.data
    if obj.type != "MESH" or obj.mode == "EDIT" or len(mesh.polygons) == 0:
        return None
    box = tuple(np.round(np.array(obj.bound_box).ravel(), 6))
    counts = len(mesh.vertices), len(mesh.polygons)
    key = (changes.state(mesh), counts, box, tuple(obj.matrix_world.to_scale()))
    if _measured.get(key) is None:
        mesh.calc_loop_triangles()
        points = read_all(mesh.vertices, "co", 3, np.float32).astype(float) * np.abs(key[-1])
        _measured.put(key, Measures.of(points, read_all(mesh.loop_triangles, "vertices", 3)))
    return _measured.get(key) if _measured.get(key).volume > 0 else None
