# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes for the benchmarks, read from .obj files."""

from itertools import pairwise
from pathlib import Path

import numpy as np

from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.check import check_mesh


def read_obj(path):
    """A checked :class:`TriangleMesh` of unit area from the v and f lines of a file; polygons as fans."""
    vertices, triangles = [], []
    for line in Path(path).read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) - 1 for word in words[1:]]
            triangles += [(corners[0], b, c) for b, c in pairwise(corners[1:])]
    mesh = TriangleMesh(np.array(vertices), np.array(triangles))
    check_mesh(mesh)
    return TriangleMesh(mesh.vertices / np.sqrt(mesh.areas.sum()), mesh.triangles)
