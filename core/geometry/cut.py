# SPDX-License-Identifier: GPL-3.0-or-later
"""Cuts of a surface along edges."""

import numpy as np

from ..graphs import components
from .triangle_mesh import TriangleMesh
from .vertex_splitting import corner_links


def cut_open(mesh: TriangleMesh, edges: np.ndarray) -> tuple[TriangleMesh, np.ndarray]:
    """Cut a manifold mesh along (k,) edges.

    Returns a mesh of the same triangles, in which every old vertex keeps its number on one side, and (n,) the vertex of
    the uncut mesh that each of its vertices was.
    """
    halves = mesh.halves_off(edges)
    return cut_all_but(mesh, halves, mesh.twins[halves])


def cut_all_but(mesh: TriangleMesh, halves: np.ndarray, twins: np.ndarray) -> tuple[TriangleMesh, np.ndarray]:
    """Cut a mesh, with any number of triangles at an edge, along all but given edges; returns as :func:`cut_open`.

    ``halves`` and ``twins`` are (k,) opposite half-edges that stay joined; pairs may be repeated.
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


def edges_after_cut(mesh: TriangleMesh, cut: TriangleMesh, edges: np.ndarray) -> np.ndarray:
    """Find edges of the uncut mesh in the cut one: both sides of edges that were cut."""
    chosen = np.zeros(len(mesh.edges), bool)
    chosen[edges] = True
    return np.unique(cut.triangle_edges[chosen[mesh.triangle_edges]])
