# SPDX-License-Identifier: GPL-3.0-or-later
"""Boundary edges and the directions that they ask for."""

import numpy as np

from ..errors import SettingError

# A boundary vertex whose edges disagree by more than this (as a mean of unit powers) is left free:
# at a right angle a line cannot run along both sides, though a cross can.
AGREEMENT = 0.5


def chosen_boundary_edges(mesh, vertices=None):
    """Indices of the boundary edges, or of those with both ends among (n,) bool ``vertices``."""
    edges = mesh.boundary_edges
    if len(edges) == 0:
        raise SettingError("the mesh has no boundary: set the boundary to free")
    if vertices is not None:
        edges = edges[np.asarray(vertices, bool)[mesh.edges[edges]].all(axis=1)]
        if len(edges) == 0:
            raise SettingError("the vertex group holds no boundary edge: add both ends of at least one to it")
    return edges


def boundary_tangents(mesh, symmetry, edges, across=False):
    """Vertices on chosen boundary edges and the power of the direction along (or across) them.

    Vectors run with the face on their left (along) or into the surface (across).

    Returns
    -------
    nodes : (k,) vertices; those at corners too sharp for the symmetry are left out
    values : (k,) complex of unit modulus
    """
    forward = np.zeros(len(mesh.edges), int)
    forward[mesh.triangle_edges.ravel()] = mesh.triangle_edge_signs.ravel()
    directions = mesh.edge_directions[edges]
    # The angle of the walk along the boundary at both ends of every edge.
    towards = np.where(forward[edges] > 0, 0, np.pi)
    angles = np.column_stack([directions[:, 0] + towards, directions[:, 1] + np.pi + towards])
    angles += np.pi / 2 if across else 0
    powers = np.exp(1j * symmetry * angles).ravel()
    ends = mesh.edges[edges].ravel()
    counts = np.bincount(ends, minlength=mesh.vertex_count)
    real = np.bincount(ends, weights=powers.real, minlength=mesh.vertex_count)
    imaginary = np.bincount(ends, weights=powers.imag, minlength=mesh.vertex_count)
    mean = (real + 1j * imaginary) / np.maximum(counts, 1)
    nodes = np.flatnonzero(np.abs(mean) > AGREEMENT)
    return nodes, mean[nodes] / np.abs(mean[nodes])
