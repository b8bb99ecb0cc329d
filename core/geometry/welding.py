# SPDX-License-Identifier: GPL-3.0-or-later
"""Welding of boundary vertices at the same place, and of those on boundary edges, where this closes edges."""

import numpy as np
from scipy.spatial import cKDTree

from ..graphs import components, pairs_within
from .triangle_mesh import TriangleMesh

# Vertices closer than this share of the surface's size are at the same place.
SAME_PLACE = 1e-6
# Vertices closer to a boundary edge than this share of the surface's size are on it.
ON_EDGE = 1e-5


def welded_vertices(places: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Find the (n,) vertex that represents each vertex at (n, 3) places: itself, or the first that it is joined with.

    Two boundary edges whose ends are at the same places become one. Closed bodies are not joined where they touch.
    """
    own = np.arange(len(places))
    mesh = TriangleMesh(places, triangles)
    ends = mesh.edges[mesh.boundary_edges]
    ends = ends[np.isfinite(places[ends]).all(axis=(1, 2))]
    rim = np.unique(ends)
    if len(rim) == 0:
        return own
    spots = own.copy()
    spots[rim], pairs = _find_spots(places[rim])
    if pairs == 0:
        return own
    met = spots[ends]
    ends, met = (values[met[:, 0] != met[:, 1]] for values in (ends, met))
    swapped = met[:, 0] > met[:, 1]
    ends[swapped], met[swapped] = ends[swapped][:, ::-1], met[swapped][:, ::-1]
    order = np.lexsort(met.T)
    ends, met = ends[order], met[order]
    same = np.flatnonzero((met[1:] == met[:-1]).all(axis=1))
    joined = np.concatenate([np.column_stack([ends[same, k], ends[same + 1, k]]) for k in (0, 1)])
    labels = components(len(places), joined)
    first = np.unique(labels, return_index=True)[1]
    return first[labels]


def find_slivers(places: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Find triangles with one corner on the opposite edge, away from its ends, where another triangle is, (t,) bool.

    Their parts would not have an area in single precision. Without them, :func:`boundary_splits` closes the surface.
    """
    mesh = TriangleMesh(places, triangles)
    with np.errstate(invalid="ignore"):
        sides = places[np.roll(triangles, -1, axis=1)] - places[triangles]
        lengths = np.linalg.norm(sides, axis=2)
        doubled = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        near = ON_EDGE * _find_size(places)
        is_flat = (doubled <= near * lengths.max(axis=1)) & (lengths.min(axis=1) > 2 * near)
    shared = mesh.edge_face_counts[mesh.triangle_edges] > 1
    return is_flat & np.take_along_axis(shared, lengths.argmax(axis=1)[:, None], axis=1)[:, 0]


def boundary_splits(places: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find boundary vertices on boundary edges of other triangles that have to be split there to be closed.

    Returns
    -------
    halves : (s,) ascending, 3 t + k for the edge from corner k of triangle t to the next
    vertices : (s,) vertex on that edge, in its order
    shares : (s,) of the edge's length, from its first corner to the vertex
    """
    mesh = TriangleMesh(places, triangles)
    is_finite = np.isfinite(places[triangles]).all(axis=(1, 2))[:, None]
    halves = np.flatnonzero((mesh.edge_face_counts[mesh.triangle_edges] == 1) & is_finite)
    ends = np.column_stack([triangles.ravel()[halves], np.roll(triangles, -1, axis=1).ravel()[halves]])
    rim = np.unique(ends)
    if len(rim) == 0:
        return halves, halves, np.empty(0)
    size = np.ptp(places[rim], axis=0).max()
    spots = np.arange(len(places))
    labels, _ = _find_spots(places[rim])
    spots[rim] = rim[np.unique(labels, return_index=True)[1]][labels]  # the first vertex at each place
    has_length = spots[ends[:, 0]] != spots[ends[:, 1]]
    halves, ends = halves[has_length], spots[ends[has_length]]
    begins, ahead = places[ends[:, 0]], places[ends[:, 1]] - places[ends[:, 0]]
    lengths = np.linalg.norm(ahead, axis=1)
    singles = np.unique(ends)
    edge, near = pairs_within(cKDTree(places[singles]), begins + ahead / 2, lengths / 2)
    vertices = singles[near]
    shares = np.einsum("sx,sx->s", places[vertices] - begins[edge], ahead[edge]) / lengths[edge] ** 2
    apart = np.linalg.norm(begins[edge] + shares[:, None] * ahead[edge] - places[vertices], axis=1)
    inside = np.minimum(shares, 1 - shares) * lengths[edge] > SAME_PLACE * size
    inside &= apart <= ON_EDGE * _find_size(places)
    inside &= (spots[triangles[halves[edge] // 3]] != vertices[:, None]).all(axis=1)
    edge, vertices, shares = edge[inside], vertices[inside], shares[inside]
    closes = _find_closing(ends, edge, vertices, shares)[edge]
    edge, vertices, shares = edge[closes], vertices[closes], shares[closes]
    order = np.lexsort((shares, edge))
    return halves[edge[order]], vertices[order], shares[order]


def _find_closing(ends: np.ndarray, edge: np.ndarray, vertices: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Find edges with (e, 2) ends that have a part in common with another, (e,) bool, split at (s,) vertices."""
    owners = np.concatenate([np.arange(len(ends)), edge, np.arange(len(ends))])
    along = np.concatenate([np.zeros(len(ends)), shares, np.ones(len(ends))])
    order = np.lexsort((along, owners))
    owners, points = owners[order], np.concatenate([ends[:, 0], vertices, ends[:, 1]])[order]
    part = np.flatnonzero(owners[1:] == owners[:-1])
    parts = np.sort(np.column_stack([points[part], points[part + 1]]), axis=1)
    _, label, count = np.unique(parts, axis=0, return_inverse=True, return_counts=True)
    return np.bincount(owners[part], weights=count[label.reshape(-1)] > 1, minlength=len(ends)) > 0


def _find_size(places: np.ndarray) -> float:
    """Compute the longest side of the box around finite places."""
    return float(np.ptp(places[np.isfinite(places).all(axis=1)], axis=0).max(initial=0.0))


def _find_spots(places: np.ndarray) -> tuple[np.ndarray, int]:
    """Label places within SAME_PLACE of one another, (n,), and count the pairs of them."""
    size = np.ptp(places, axis=0).max()
    pairs = cKDTree(places).query_pairs(SAME_PLACE * size, output_type="ndarray")
    return components(len(places), pairs), len(pairs)
