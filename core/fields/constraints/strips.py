# SPDX-License-Identifier: GPL-3.0-or-later
"""Strips between two grid lines that are narrower than a quad, and a target one-form for which a quad fits across.

Where lines run side by side closer than a quad's side, the phase on both rounds to the same multiple, so that they
would become one grid line. There lengths across the strip are enlarged, and those along it kept.
"""

from collections.abc import Iterator, Sequence

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
# Triangles whose pairs with points are held at a time.
RUN = 1024


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
    directions, factors = np.zeros((mesh.triangle_count, 3)), np.ones(mesh.triangle_count)
    for triangles, met in _within_reach(places, mesh.parts_between(edges), reach, points, regions):
        ways = points[met] - places[triangles]
        lengths = np.linalg.norm(ways, axis=1)
        nearest = _first_of_each(triangles, lengths)
        at, own = triangles[nearest], met[nearest]
        # Of each triangle that has points near by, by its place in ``at``.
        across = unit_vectors(np.cross(mesh.face_normals[at], tangents[own]))
        own_heights = np.einsum("kx,kx->k", points[own] - places[at], across)
        which = np.cumsum(np.diff(triangles, prepend=-1) != 0) - 1
        parallel = np.abs(np.einsum("kx,kx->k", tangents[met], tangents[own][which])) > BESIDE
        which, met, ways, lengths = which[parallel], met[parallel], ways[parallel], lengths[parallel]
        heights = np.einsum("kx,kx->k", ways, across[which])
        # Within one step of the sample points, the distance from the line itself is used.
        along = np.einsum("kx,kx->k", ways, tangents[met])
        straight = np.where(np.abs(along) < step, np.sqrt(np.maximum(lengths**2 - along**2, 0)), lengths)
        opposite = np.flatnonzero(-np.sign(own_heights[which]) * heights > STRAIGHT * straight)
        found = opposite[_first_of_each(which[opposite], lengths[opposite])]
        row = which[found]
        widths = np.maximum(np.abs(heights[found] - own_heights[row]), np.finfo(float).tiny)
        directions[at[row]], factors[at[row]] = across[row], np.clip(reach[at[row]] / widths, 1, MOST)
    return directions, factors


def _within_reach(
    places: np.ndarray, own: np.ndarray, reach: np.ndarray, points: np.ndarray, regions: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Pairs of (m, 3) places and of points on lines within (m,) reach of them, beside the place's (m,) own region: (k,)
    places, ascending, and (k,) points, for :data:`RUN` places at a time. Places farther than half of their reach from
    all such points are in no strip and are left out."""
    # Regions lie apart along a fourth axis.
    apart = 4 * reach.max(initial=0)
    which, side = np.nonzero((regions >= 0) & (np.diff(regions, prepend=-2) != 0))
    tree = cKDTree(np.column_stack([points[which], apart * regions[which, side]]))
    places = np.column_stack([places, apart * own])
    near = np.flatnonzero(tree.query(places, distance_upper_bound=reach.max() / 2)[0] < reach / 2)
    for begin in range(0, len(near), RUN):
        part = near[begin : begin + RUN]
        rows, reached = pairs_within(tree, places[part], reach[part])
        yield part[rows], which[reached]


def _first_of_each(labels: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """The (l,) first of the shortest items of each label; (k,) labels ascend."""
    starts = np.flatnonzero(np.diff(labels, prepend=-1))
    if len(starts) == 0:
        return starts
    shortest = np.repeat(np.minimum.reduceat(lengths, starts), np.diff(starts, append=len(labels)))
    found = np.flatnonzero(lengths == shortest)
    return found[np.diff(labels[found], prepend=-1) != 0]


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
