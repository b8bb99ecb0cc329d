# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces without tunnels and handles that are narrower than a given width, such as the screw holes of a part."""

from dataclasses import dataclass

import numpy as np

from ..graphs import components, sum_by
from .triangle_mesh import TriangleMesh
from .vertex_splitting import next_half_edges


@dataclass(frozen=True)
class FilledMesh:
    """A surface with tunnels replaced by disks at both ends.

    Attributes
    ----------
    mesh : the given vertices, of which some are loose, and then the centres of the disks
    sources : (k,) a given vertex at the rim of each disk
    triangles : (m,) the given triangle that each triangle was, or next to which it is in a disk
    """

    mesh: TriangleMesh
    sources: np.ndarray
    triangles: np.ndarray


def without_narrow_tunnels(mesh: TriangleMesh, edges: np.ndarray, width: float) -> FilledMesh | None:
    """The surface without the tunnels that are narrower than a width; None where there are none.

    Edges divide the surface into parts. A part is narrow if its extent along the second of its principal axes is below
    the width. Connected narrow parts are a tunnel if they have no boundary and meet the rest of the surface along
    several loops, all of them simple and narrow. Where tunnels are all that joins two parts, these become pieces.

    Parameters
    ----------
    edges : (k,) sharp edges
    """
    parts = mesh.parts_between(edges)
    inside = (_second_extents(mesh, parts) < width)[parts]
    halves = np.flatnonzero(mesh.twins >= 0)
    beside = mesh.twins[halves] // 3
    same = inside[halves // 3] == inside[beside]
    clusters = components(mesh.triangle_count, np.column_stack([halves[same] // 3, beside[same]]))
    rim = halves[inside[halves // 3] & ~same]  # half-edges of narrow parts beside others
    tails, heads = mesh.triangles.ravel()[[rim, next_half_edges(rim)]]
    loops = _loops(mesh, clusters[rim // 3], tails, heads)
    filled = _are_tunnels(mesh, clusters, rim, tails, loops, width)[clusters[rim // 3]]
    if not filled.any():
        return None
    rim, tails, heads = (values[filled] for values in (rim, tails, heads))
    loops = np.unique(loops[filled], return_inverse=True)[1]
    removed = np.isin(clusters, clusters[rim // 3])
    lengths = np.linalg.norm(mesh.vertices[tails] - mesh.vertices[heads], axis=1)
    middles = lengths[:, None] * (mesh.vertices[tails] + mesh.vertices[heads]) / 2
    centres = sum_by(loops, middles) / np.bincount(loops, lengths)[:, None]
    disks = np.column_stack([tails, heads, mesh.vertex_count + loops])
    vertices, triangles = np.concatenate([mesh.vertices, centres]), np.concatenate([mesh.triangles[~removed], disks])
    sources = tails[np.unique(loops, return_index=True)[1]]
    return FilledMesh(TriangleMesh(vertices, triangles), sources, np.append(np.flatnonzero(~removed), rim // 3))


def _are_tunnels(
    mesh: TriangleMesh, clusters: np.ndarray, rim: np.ndarray, tails: np.ndarray, loops: np.ndarray, width: float
) -> np.ndarray:
    """(c,) bool: clusters of triangles, (m,) labels, without boundary and with several loops of (k,) half-edges, all of
    which are simple and have diameters below the width.

    ``rim`` are the half-edges, ``tails`` the vertices where they begin, ``loops`` the labels of their loops.
    """
    count = clusters.max(initial=-1) + 1
    of = clusters[rim // 3]
    result = np.bincount(of[np.unique(loops, return_index=True)[1]], minlength=count) > 1
    # The box around a circle has a diagonal of root two times its diameter.
    low, high = _boxes(loops, mesh.vertices[tails])
    result[of[np.linalg.norm(high - low, axis=1)[loops] >= np.sqrt(2) * width]] = False
    passes, times = np.unique(of * mesh.vertex_count + tails, return_counts=True)
    result[passes[times > 1] // mesh.vertex_count] = False
    result[clusters[np.flatnonzero(mesh.twins < 0) // 3]] = False
    return result


def _loops(mesh: TriangleMesh, clusters: np.ndarray, tails: np.ndarray, heads: np.ndarray) -> np.ndarray:
    """(k,) label of the loop of half-edges that each one is in; those of different clusters may meet."""
    count = mesh.vertex_count
    names, ends = np.unique(np.concatenate([clusters * count + tails, clusters * count + heads]), return_inverse=True)
    labels = components(len(names), ends.reshape(2, -1).T)
    return labels[ends.ravel()[: len(tails)]]


def _second_extents(mesh: TriangleMesh, parts: np.ndarray) -> np.ndarray:
    """(p,) extent of each part along the second one of its principal axes."""
    labels, places = np.repeat(parts, 3), mesh.vertices[mesh.triangles]
    # The mean of a quadratic function at the middles of its sides is its mean over a triangle.
    middles, weights = ((places + np.roll(places, 1, axis=1)) / 2).reshape(-1, 3), np.repeat(mesh.areas, 3)
    areas = np.maximum(np.bincount(labels, weights), np.finfo(float).tiny)  # a part without area has any axes
    centres = sum_by(labels, weights[:, None] * middles) / areas[:, None]
    apart = middles - centres[labels]
    moments = sum_by(labels, (weights[:, None, None] * apart[:, :, None] * apart[:, None, :]).reshape(-1, 9))
    axes = np.linalg.eigh(moments.reshape(-1, 3, 3))[1][:, :, 1]
    along = np.einsum("nx,nx->n", places.reshape(-1, 3), axes[labels])
    low, high = _boxes(labels, along[:, None])
    return (high - low)[:, 0]


def _boxes(labels: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The lowest and highest coordinates of (k, d) places of each label, (l, d) both."""
    shape = labels.max(initial=-1) + 1, places.shape[1]
    low, high = np.full(shape, np.inf), np.full(shape, -np.inf)
    np.minimum.at(low, labels, places)
    np.maximum.at(high, labels, places)
    return low, high
