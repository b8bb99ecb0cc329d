# SPDX-License-Identifier: GPL-3.0-or-later
"""Automatic spacing of lines on a surface, and the edge length that a spacing needs."""

import numpy as np
from numpy.typing import ArrayLike

from ..fields.target_one_form import COARSE_SHARE
from ..geometry.triangle_mesh import TriangleMesh

# Automatic spacing: number of stripes or quads across the object, and least number of edges per period.
LINES_ACROSS = 40
EDGES_PER_PERIOD = 4
FEWEST_LINES = 2
# A mesh whose edges carry fewer quads than the first is solved on a finer copy, with about as many quads as the second;
# stripes are as wide as quads.
FEWEST_QUADS, QUADS = 50, 1500
# An edge is short enough if it is at most this share of a period: the side of a quad.
EDGE_SHARE = 0.5
# Edges of a finer copy are at most this share of that, as quads become a little smaller than asked.
_MARGIN = 0.9
# Triangles with an edge this many times as long as that may cover COARSE_SHARE of the surface.
_TOO_LONG = 2.0


def automatic_spacing(mesh: TriangleMesh, per_period: int, across: float = LINES_ACROSS) -> float:
    """Choose a spacing for a surface: about ``across`` lines across it, or as many as its edges carry.

    If its edges carry very few lines, a finer copy will be made, and the spacing follows from the area.

    Parameters
    ----------
    per_period : lines in a period: 1 for stripes, 2 for quads
    across : lines across the longest side
    """
    return spacing_across(_size(mesh), mesh.areas.sum(), carried_spacing(mesh.edge_lengths), per_period, across)


def spacing_across(size: float, area: float, finest: float, per_period: int, across: float = LINES_ACROSS) -> float:
    """Choose as :func:`automatic_spacing` from a surface's longest side, area, and finest spacing that it carries."""
    if finest <= 2 * np.sqrt(area / FEWEST_QUADS):
        return _spacing_carried(size, finest, per_period, across)
    return wished_spacing(area, per_period) * LINES_ACROSS / across


def spacing_on_faces(mesh: TriangleMesh, per_period: int, across: float = LINES_ACROSS) -> float:
    """Choose as :func:`automatic_spacing` without a finer copy: as many lines as the edges carry, at least two."""
    return _spacing_carried(_size(mesh), carried_spacing(mesh.edge_lengths), per_period, across)


def _spacing_carried(size: float, finest: float, per_period: int, across: float) -> float:
    return float(min(max(per_period * size / across, finest), per_period * size / FEWEST_LINES))


def _size(mesh: TriangleMesh) -> float:
    """Compute the longest side of the box around a mesh's triangles."""
    return np.ptp(mesh.vertices[np.unique(mesh.triangles)], axis=0).max()


def wished_spacing(area: float, per_period: int) -> float:
    """Compute the automatic spacing of a surface that is refined as needed."""
    return float(per_period * np.sqrt(area / QUADS))


def carried_spacing(lengths: np.ndarray) -> float:
    """Compute the finest spacing for (e,) edge lengths: four median edges, and at least two of the longest."""
    median, long = np.quantile(lengths, [0.5, 1 - COARSE_SHARE])
    return float(max(EDGES_PER_PERIOD * median, long / EDGE_SHARE))


def longest_edge(mesh: TriangleMesh, spacings: ArrayLike) -> float | None:
    """Compute the longest edge of a finer copy for one spacing, or one at each vertex (and axis); None without need.

    A mesh is fine enough if few edges are longer than the side of a quad, and few of its triangles have much longer
    edges.
    """
    at_vertices = np.asarray(spacings, float)
    at_vertices = at_vertices.min(axis=1) if at_vertices.ndim == 2 else at_vertices
    limits = EDGE_SHARE * np.broadcast_to(at_vertices, mesh.vertex_count)[mesh.edges].min(axis=1)
    much_longer = (mesh.edge_lengths > _TOO_LONG * limits)[mesh.triangle_edges].any(axis=1)
    few = (mesh.edge_lengths > limits).mean() <= COARSE_SHARE
    is_fine = few and mesh.areas[much_longer].sum() <= COARSE_SHARE * mesh.areas.sum()
    return None if is_fine else _MARGIN * EDGE_SHARE * float(np.quantile(at_vertices, COARSE_SHARE))
