# SPDX-License-Identifier: GPL-3.0-or-later
"""Two-dimensional grids as meshes of squares."""

import numpy as np

from . import TriangleMesh
from .check import check_mesh
from .grid import Grid
from .mesh_input import MeshInput
from .polygons import Polygons


def grid_squares(grid: Grid) -> MeshInput:
    """Build the mesh of a two-dimensional grid's squares, split as Blender splits them; its vertices are the nodes.

    A periodic grid gives an open mesh. Squares at obstacles are left out.
    """
    cuts = np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[1:, 1:], np.s_[:-1, 1:]
    corners = np.column_stack([grid.numbers[cut].ravel() for cut in cuts])
    across, upwards = (count - 1 for count in grid.shape)
    corners = corners[grid.open_cells[:across, :upwards].ravel()]
    starts = 4 * np.arange(len(corners))
    triangle_corners = (starts[:, None, None] + [[0, 1, 2], [0, 2, 3]]).reshape(-1, 3)
    polygons = Polygons(
        corners.ravel(), starts, np.full(len(corners), 4), triangle_corners, np.repeat(np.arange(len(corners)), 2)
    )
    # Rounded as an object's vertices are, which are compared later to see whether it has changed.
    places = grid.places.astype(np.float32).astype(float)
    mesh = TriangleMesh(np.pad(places, ((0, 0), (0, 1))), polygons.triangles)
    check_mesh(mesh, polygons.triangle_faces)
    return MeshInput(mesh, polygons, np.eye(3), mesh, np.arange(mesh.vertex_count))
