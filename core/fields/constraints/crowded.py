# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sharp edges that are too near to others for quads between them."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from ...geometry.polylines import divide_pieces
from ...geometry.triangle_mesh import TriangleMesh
from ...graphs import pairs_within
from ...unit_vectors import unit_vectors
from .features import pieces_between_corners

# Two lines are crowded where they are nearer than this to one another, in sides of a quad, at an angle with at least
# this cosine, and if that is so on at least this share of the first one's length.
NEAREST, BESIDE, SHARE = 0.6, np.cos(np.radians(20)), 0.6
# Around a thin part the faces beyond two lines look apart: the cosine of the angle between their normals is lower.
APART = -0.2
# Distance of sample points on lines, in sides of a quad, and most pairs of them that are looked at.
STEP, MOST_PAIRS = 0.1, 20_000_000


def without_crowded_lines(mesh: TriangleMesh, edges: np.ndarray, side: ArrayLike) -> np.ndarray:
    """The edges without lines that run beside longer or sharper ones, with no room for a quad between.

    Of two lines, between corners, the one with less length times angle goes. Boundaries stay, and so do both lines
    around a thin part.

    Parameters
    ----------
    edges : (k,) indices of edges of boundaries and sharp edges
    side : length of a quad's side, one or (n,) at the vertices
    """
    lines = pieces_between_corners(mesh, edges)
    sides = np.broadcast_to(side, mesh.vertex_count)[mesh.edges[edges]].mean(axis=1)
    lengths = mesh.edge_lengths[edges]
    begins, ends = mesh.vertices[mesh.edges[edges].T]
    of, points = divide_pieces(begins, ends, STEP * sides)
    sizes = (lengths / np.bincount(of, minlength=len(edges)))[of]
    of, points, sizes = _thin_out(lines, of, points, sizes, STEP * sides)
    tree = cKDTree(points)
    if tree.count_neighbors(tree, NEAREST * sides.max(initial=0)) > MOST_PAIRS:
        return edges
    at, near = pairs_within(tree, points, NEAREST * sides[of])
    line = lines[of]
    is_other = line[at] != line[near]
    at, near = at[is_other], near[is_other]
    along = unit_vectors(mesh.edge_vectors[edges])
    ways = points[near] - points[at]
    ways -= np.einsum("kx,kx->k", ways, along[of[at]])[:, None] * along[of[at]]
    crowded = np.abs(np.einsum("kx,kx->k", along[of[at]], along[of[near]])) > BESIDE
    beyond = (
        _normals_beyond(mesh, edges[of[at]], points[at], ways),
        _normals_beyond(mesh, edges[of[near]], points[near], -ways),
    )
    crowded &= np.einsum("kx,kx->k", *beyond) > APART
    at, near = at[crowded], near[crowded]

    weights = np.bincount(lines, lengths * np.abs(mesh.dihedral_angles[edges]))
    on_boundary = np.bincount(lines, mesh.edge_face_counts[edges] == 1) > 0
    wholes = np.bincount(lines, lengths)
    kept = np.ones(len(wholes), bool)
    order = np.argsort(lines[of[at]], kind="stable")
    first = np.searchsorted(lines[of[at]][order], np.arange(len(wholes) + 1))
    for line in np.argsort(weights, kind="stable"):
        pairs = order[first[line] : first[line + 1]]
        pairs = pairs[kept[lines[of[near[pairs]]]]]
        beside = sizes[np.unique(at[pairs])].sum()
        kept[line] = on_boundary[line] or beside < SHARE * wholes[line]
    return edges[kept[lines]]


def _thin_out(
    lines: np.ndarray, of: np.ndarray, points: np.ndarray, lengths: np.ndarray, steps: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Keep one sample point of each line in each cube of a step.

    Takes (p,) edges, (p, 3) points, and (p,) lengths that these stand for. Returns those of the points that are kept;
    the length of each is the sum of the lengths in its cube.
    """
    cubes = np.column_stack([lines[of], np.floor(points / steps[of, None])])
    _, first, number = np.unique(cubes, axis=0, return_index=True, return_inverse=True)
    return of[first], points[first], np.bincount(number.ravel(), lengths)


def _normals_beyond(mesh: TriangleMesh, edges: np.ndarray, points: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """(k, 3) normals of the faces at edges that lie away from the (k, 3) ways from points on these."""
    faces = mesh.edge_triangles[edges].T
    centres = mesh.vertices[mesh.triangles].mean(axis=1)
    towards = np.einsum("fkx,kx->fk", centres[faces] - points, ways)
    return mesh.face_normals[np.take_along_axis(faces, towards.argmin(axis=0)[None], axis=0)[0]]
