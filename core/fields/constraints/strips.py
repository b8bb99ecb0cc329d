# SPDX-License-Identifier: GPL-3.0-or-later
"""Strips between two grid lines that are narrower than a quad, and a target one-form for which a quad fits across.

Where lines run side by side closer than a quad's side, the phase on both rounds to the same multiple, so that they
would become one grid line. There lengths across the strip are enlarged, and those along it kept.
"""

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from ...geometry.triangle_mesh import TriangleMesh
from ...graphs import pairs_within, ragged_arange, sum_by
from ...unit_vectors import unit_vectors
from .groups import OneForm
from .rows import GRID, Row

# Quads across a strip: more than one, so that two are nearer than none where their number has to be even; and the
# largest factor on a length.
ACROSS, MOST = 1.3, 1e4
# Cosine of the largest angle between the way to the second line and the perpendicular on the first.
STRAIGHT = 0.8
# Cosine of the angle between two lines beyond which they meet at a corner and bound no strip.
BESIDE = np.cos(np.radians(12))
# Distance of sample points on lines, in sides of a quad.
STEP = 0.1


def strip_stretch(one_form: OneForm, rows: Sequence[Row]) -> complex | np.ndarray:
    """The stretch of a target one-form of quads, one or (e,) complex, that makes room for a quad between grid lines."""
    links = np.concatenate([np.empty((0, 2), int), *(row.line.links for row in rows if row.kind == GRID)])
    if len(links) == 0:
        return 1.0
    mesh = one_form.mesh
    sides = np.pi / one_form.rates.mean(axis=1)
    across, factors = find_strips(mesh, np.unique(mesh.edges_between(*links.T)), sides)
    return _stretch_edges(mesh, across, factors)


def find_strips(mesh: TriangleMesh, edges: np.ndarray, sides: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(m, 3) unit vectors across narrow strips in each triangle, and (m,) factors on lengths across that make room for
    :data:`ACROSS` quads; 1 outside of strips.

    The lines are (k,) edges, and ``sides`` (n,) lengths of a quad's side at the vertices.
    """
    step = STEP * sides.min()
    points, tangents, regions = _on_lines(mesh, edges, step)
    places, reach = mesh.vertices[mesh.triangles].mean(axis=1), ACROSS * sides[mesh.triangles].mean(axis=1)
    triangles, met = _within_reach(places, mesh.parts_between(edges), reach, points, regions)
    ways = points[met] - places[triangles]
    lengths = np.linalg.norm(ways, axis=1)
    nearest = np.zeros(mesh.triangle_count, int)
    first = _first_of_each(triangles, lengths, np.arange(len(met)))
    nearest[triangles[first]] = met[first]
    own = nearest[triangles]
    across = unit_vectors(np.cross(mesh.face_normals[triangles], tangents[own]))
    heights = np.einsum("kx,kx->k", ways, across)
    own_heights = np.einsum("kx,kx->k", points[own] - places[triangles], across)
    beside = np.abs(np.einsum("kx,kx->k", tangents[met], tangents[own])) > BESIDE
    # Within one step of the sample points, the distance from the line itself is used.
    along = np.einsum("kx,kx->k", ways, tangents[met])
    straight = np.where(np.abs(along) < step, np.sqrt(np.maximum(lengths**2 - along**2, 0)), lengths)
    opposite = np.flatnonzero(beside & (-np.sign(own_heights) * heights > STRAIGHT * straight))
    found = _first_of_each(triangles, lengths, opposite)
    widths = np.maximum(np.abs(heights - own_heights)[found], np.finfo(float).tiny)
    at, directions, factors = triangles[found], np.zeros((mesh.triangle_count, 3)), np.ones(mesh.triangle_count)
    directions[at], factors[at] = across[found], np.clip(reach[at] / widths, 1, MOST)
    return directions, factors


def _within_reach(
    places: np.ndarray, own: np.ndarray, reach: np.ndarray, points: np.ndarray, regions: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of (m, 3) places in (m,) own regions and of points on lines beside these that are within (m,) reach of
    them: (k,) places, (k,) points. Places farther than half of it from all such points are in no strip and are left
    out."""
    # Regions lie apart along a fourth axis.
    apart = 4 * reach.max(initial=0)
    which, side = np.nonzero((regions >= 0) & (np.diff(regions, prepend=-2) != 0))
    tree = cKDTree(np.column_stack([points[which], apart * regions[which, side]]))
    places = np.column_stack([places, apart * own])
    near = np.flatnonzero(tree.query(places, distance_upper_bound=reach.max() / 2)[0] < reach / 2)
    rows, reached = pairs_within(tree, places[near], reach[near])
    return near[rows], which[reached]


def _first_of_each(labels: np.ndarray, lengths: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """The shortest of the (c,) chosen items of each label."""
    order = chosen[np.lexsort((lengths[chosen], labels[chosen]))]
    return order[np.unique(labels[order], return_index=True)[1]]


def _on_lines(mesh: TriangleMesh, edges: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(p, 3) points on edges, unit vectors along these, and (p, 2) regions at both sides, -1 beyond the boundary."""
    own = mesh.parts_between(edges)
    beside = np.full((len(mesh.edges), 2), -1)
    half = np.arange(3 * mesh.triangle_count)
    side = (mesh.triangle_edge_signs.ravel() < 0).astype(int)
    beside[mesh.triangle_edges.ravel(), side] = own[half // 3]
    counts = np.ceil(mesh.edge_lengths[edges] / step).astype(int) + 1
    rows, places = ragged_arange(counts)
    shares = (places / np.maximum(counts[rows] - 1, 1))[:, None]
    points = mesh.vertices[mesh.edges[edges[rows], 0]] + shares * mesh.edge_vectors[edges[rows]]
    tangents = unit_vectors(mesh.edge_vectors[edges])
    return points, tangents[rows], beside[edges[rows]]


def _stretch_edges(mesh: TriangleMesh, across: np.ndarray, factors: np.ndarray) -> np.ndarray:
    """(e,) complex factor on each edge, whose argument turns it counterclockwise; the mean over its faces."""
    half = mesh.triangle_edges.ravel()
    faces = np.arange(len(half)) // 3
    along = unit_vectors(mesh.edge_vectors[half])
    left = np.cross(mesh.face_normals[faces], along)
    forward, sideways = (np.einsum("hx,hx->h", across[faces], part) for part in (along, left))
    extra = (factors[faces] - 1) * forward * (forward + 1j * sideways)
    return 1 + sum_by(half, extra, len(mesh.edges)) / np.maximum(mesh.edge_face_counts, 1)
