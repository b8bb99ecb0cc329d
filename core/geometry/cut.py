# SPDX-License-Identifier: GPL-3.0-or-later
"""Cut a surface open along edges, so that nothing is carried across them."""

import numpy as np

from ..graphs import components
from .triangle_mesh import TriangleMesh
from .vertex_splitting import corner_links


def cut_open(mesh, edges):
    """The mesh with its two sides apart along given edges.

    Parameters
    ----------
    mesh : TriangleMesh, manifold
    edges : (k,) indices of edges; boundary edges are open already

    Returns
    -------
    cut : TriangleMesh of the same triangles, in which every old vertex keeps its number on one side
    source : (n,) the vertex of ``mesh`` that each vertex of ``cut`` was
    """
    is_cut = np.zeros(len(mesh.edges), bool)
    is_cut[edges] = True
    halves = np.flatnonzero((mesh.twins >= 0) & ~is_cut[mesh.triangle_edges.ravel()])
    return cut_all_but(mesh, halves, mesh.twins[halves])


def cut_all_but(mesh, halves, twins):
    """The mesh whose triangles hold together across given half-edges alone.

    Parameters
    ----------
    mesh : TriangleMesh, with any number of triangles at an edge
    halves, twins : (k,) half-edges that stay together, which run opposite ways; pairs may come up twice

    Returns
    -------
    What :func:`cut_open` does
    """
    fans = components(3 * mesh.triangle_count, corner_links(mesh.triangles, halves, twins))
    _, first_corner = np.unique(fans, return_index=True)
    vertex_of_fan = mesh.triangles.ravel()[first_corner]
    _, kept = np.unique(vertex_of_fan, return_index=True)
    new = np.ones(len(vertex_of_fan), bool)
    new[kept] = False
    numbers = vertex_of_fan.copy()
    numbers[new] = mesh.vertex_count + np.arange(new.sum())
    source = np.concatenate([np.arange(mesh.vertex_count), vertex_of_fan[new]])
    return TriangleMesh(mesh.vertices[source], numbers[fans].reshape(-1, 3)), source


def edges_after_cut(mesh, cut, edges):
    """Indices in a cut mesh of edges of the uncut one: both sides of those that were cut."""
    chosen = np.zeros(len(mesh.edges), bool)
    chosen[edges] = True
    return np.unique(cut.triangle_edges[chosen[mesh.triangle_edges]])
