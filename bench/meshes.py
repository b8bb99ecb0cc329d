# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes for the benchmarks, from and to .obj files."""

from itertools import pairwise
from pathlib import Path

import numpy as np

from synch_fields.core.errors import MeshError
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.check import check_mesh
from synch_fields.core.geometry.manifold_repair import repair_mesh
from synch_fields.core.geometry.polygons import Polygons


def read_obj(path):
    """A checked :class:`TriangleMesh` of unit area from the v and f lines of a file; polygons as fans."""
    mesh = _fans_of(path)
    check_mesh(mesh)
    return _of_unit_area(mesh)


def read_carrier(path):
    """The surface of a file, repaired where it has to be, scaled to unit area."""
    mesh = _fans_of(path)
    try:
        check_mesh(mesh)
    except MeshError:
        mesh = repair_mesh(mesh, Polygons.of_triangles(mesh)).mesh
    return _of_unit_area(mesh)


def _fans_of(path):
    vertices, faces = read_faces(path)
    triangles = [(corners[0], b, c) for corners in faces for b, c in pairwise(corners[1:])]
    return TriangleMesh(vertices, np.array(triangles))


def _of_unit_area(mesh):
    return TriangleMesh(mesh.vertices / np.sqrt(mesh.areas.sum()), mesh.triangles)


def read_faces(path):
    """(n, 3) vertices from the v lines of an .obj file, and a list of the corners of each face from its f lines."""
    vertices, faces = [], []
    for line in Path(path).read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            faces.append([int(word.split("/")[0]) - 1 for word in words[1:]])
    return np.array(vertices).reshape(-1, 3), faces


def write_obj(mesh, path):
    """The v and f lines of a triangle mesh."""
    lines = ["v {:.9g} {:.9g} {:.9g}".format(*place) for place in mesh.vertices]
    lines += ["f {} {} {}".format(*corners) for corners in (mesh.triangles + 1).tolist()]
    Path(path).write_text("\n".join(lines) + "\n")
