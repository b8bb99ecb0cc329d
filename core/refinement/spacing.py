# SPDX-License-Identifier: GPL-3.0-or-later
"""Which spacing suits a surface, and whether its mesh is fine enough for a spacing."""

import numpy as np

from ..fields.target_one_form import COARSE_SHARE

# Automatic spacing: this many stripes or quads across the object, and at least this many edges to a period.
LINES_ACROSS = 40
EDGES_PER_PERIOD = 4
FEWEST_LINES = 2
# A mesh whose edges carry fewer quads than this is solved on a finer copy, with about as many quads as this; stripes
# are as wide as quads.
FEWEST_QUADS, QUADS = 50, 1500
# An edge is short enough where it is at most this part of a period: the side of a quad.
EDGE_SHARE = 0.5
# Edges of a finer copy are at most this part of that: quads come out a little smaller than asked.
_MARGIN = 0.9
# Triangles with an edge this many times as long as that may cover a share of the surface of COARSE_SHARE.
_TOO_LONG = 2.0


def automatic_spacing(mesh, per_period, across=LINES_ACROSS):
    """A spacing that suits a surface: about so many lines across it, or as many as its edges carry.

    Where its edges carry next to nothing, a finer copy will: then the area says how wide lines are.

    Parameters
    ----------
    mesh : TriangleMesh
    per_period : lines in a period: 1 for stripes, 2 for quads
    across : lines across the longest side
    """
    return spacing_across(_size(mesh), mesh.areas.sum(), carried_spacing(mesh.edge_lengths), per_period, across)


def spacing_across(size, area, finest, per_period, across=LINES_ACROSS):
    """As :func:`automatic_spacing`, for a surface's longest side, its area, and the finest spacing that it carries."""
    if finest <= 2 * np.sqrt(area / FEWEST_QUADS):
        return _spacing_carried(size, finest, per_period, across)
    return wished_spacing(area, per_period) * LINES_ACROSS / across


def spacing_on_faces(mesh, per_period, across=LINES_ACROSS):
    """As :func:`automatic_spacing` for a mesh that stays as it is: as many lines as its edges carry, two at least."""
    return _spacing_carried(_size(mesh), carried_spacing(mesh.edge_lengths), per_period, across)


def _spacing_carried(size, finest, per_period, across):
    return float(min(max(per_period * size / across, finest), per_period * size / FEWEST_LINES))


def _size(mesh):
    """The longest side of the box around a mesh's triangles."""
    return np.ptp(mesh.vertices[np.unique(mesh.triangles)], axis=0).max()


def wished_spacing(area, per_period):
    """The automatic spacing of a surface that is made as fine as it needs."""
    return float(per_period * np.sqrt(area / QUADS))


def carried_spacing(lengths):
    """The finest spacing for (e,) lengths of edges: four edges to it as a rule, and two where they are longest."""
    median, long = np.quantile(lengths, [0.5, 1 - COARSE_SHARE])
    return float(max(EDGES_PER_PERIOD * median, long / EDGE_SHARE))


def longest_edge(mesh, spacings):
    """How long the edges of a finer copy should be at most; None where the mesh is fine enough as it is.

    A mesh is fine where few edges are longer than the side of a quad, and few of its triangles much longer.

    Parameters
    ----------
    mesh : TriangleMesh
    spacings : one, or one at each vertex (and axis)
    """
    at_vertices = np.asarray(spacings, float)
    at_vertices = at_vertices.min(axis=1) if at_vertices.ndim == 2 else at_vertices
    limits = EDGE_SHARE * np.broadcast_to(at_vertices, mesh.vertex_count)[mesh.edges].min(axis=1)
    much_longer = (mesh.edge_lengths > _TOO_LONG * limits)[mesh.triangle_edges].any(axis=1)
    few = (mesh.edge_lengths > limits).mean() <= COARSE_SHARE
    is_fine = few and mesh.areas[much_longer].sum() <= COARSE_SHARE * mesh.areas.sum()
    return None if is_fine else _MARGIN * EDGE_SHARE * float(np.quantile(at_vertices, COARSE_SHARE))
