# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad collapses (Daniels et al. 2008): two opposite corners of a quad are merged where that regularises vertices.

Where odd faces were paired, vertices with three and with five edges lie beside each other. Collapsing a quad whose
corners have 3, 5, 3 and 5 edges leaves only regular vertices. Where an edge of a line was halved between two odd faces,
two quads share both halves: the ends of the edge are merged, and both quads go.
"""

import numpy as np

from ....geometry import TriangleMesh
from ....geometry.barycentric import barycentric
from ..trace.quad_mesh import QuadMesh
from .reconnections import FEWEST, FEWEST_ON_RIM

# Most edges at a vertex that stands for both ends of a halved edge.
MOST = 6


def collapse_quads(
    quads: QuadMesh, mesh: TriangleMesh, held: np.ndarray, corners: np.ndarray
) -> tuple[QuadMesh, np.ndarray]:
    """The quad mesh with quads collapsed, and (k,) the vertices that were kept, in their order.

    A collapse of a quad reduces the sum of squares of the vertices' surplus or missing edges, and does not increase the
    number of irregular vertices.

    Parameters
    ----------
    quads : all faces are quads
    mesh : the surface
    held : (n,) bool, vertices that stay in place; two of them are merged only as ends of a halved edge
    corners : (n,) bool, vertices whose number of edges stays, too, unless they are an end of a halved edge
    """
    faces = quads.corner_vertices.reshape(-1, 4).copy()
    valences, on_rim = np.bincount(quads.edges[0].ravel(), minlength=len(held)), quads.on_rim
    vertices = quads.vertices.copy()
    faces = _merge_halved_edges(faces, valences, on_rim, held, corners)
    moved = np.zeros(len(held), bool)
    while (found := _best_collapse(faces, valences, on_rim, held, corners)) is not None:
        number, (a, b, c, d) = found
        kept, gone = (c, a) if held[c] else (a, c)
        if not held[kept]:
            vertices[kept] = (vertices[a] + vertices[c]) / 2
            moved[kept] = True
        valences[kept], valences[gone] = valences[a] + valences[c] - 2, 0
        valences[[b, d]] -= 1
        faces = np.delete(faces, number, axis=0)
        faces[faces == gone] = kept
    used = np.unique(faces)
    which = np.flatnonzero(moved)
    normals = mesh.face_normals[quads.triangles[which]]
    places, triangles = mesh.finder.nearest_facing(vertices[which], normals)
    quads = quads.moved(which, places, triangles, barycentric(mesh, triangles, places))
    return quads.with_faces(faces.ravel(), np.full(len(faces), 4)), used


def _merge_halved_edges(
    faces: np.ndarray, valences: np.ndarray, on_rim: np.ndarray, held: np.ndarray, corners: np.ndarray
) -> np.ndarray:
    """The (f, 4) faces where the ends of edges, whose middle has only two quads, are merged; one end stays in place.

    Both ends are on the edge's line. The vertices' numbers of edges are brought up to date.
    """
    for middle in np.flatnonzero((valences == 2) & ~on_rim).tolist():
        rows, places = np.nonzero(faces == middle)
        if len(rows) != 2:
            continue
        (a, b, c), (_, d, _) = (np.roll(faces[row], -place)[1:] for row, place in zip(rows, places, strict=True))
        merged = valences[a] + valences[c] - 4
        stays = on_rim[[a, b, c, d]].any() or corners[[b, d, middle]].any() or (corners[a] and corners[c])
        if stays or not FEWEST <= merged <= MOST or valences[[b, d]].min() <= FEWEST:
            continue
        if not _is_free(faces, a, c, {b, d, middle}):
            continue
        kept, gone = (c, a) if corners[c] or (held[c] and not held[a]) else (a, c)
        valences[kept], valences[[gone, middle]] = merged, 0
        valences[[b, d]] -= 1
        faces = np.delete(faces, rows, axis=0)
        faces[faces == gone] = kept
    return faces


def _best_collapse(
    faces: np.ndarray, valences: np.ndarray, on_rim: np.ndarray, held: np.ndarray, corners: np.ndarray
) -> tuple[int, np.ndarray] | None:
    """The face whose collapse regularises vertices most, and its corners a, b, c, d, of which a and c are to be merged;
    None if no face can be collapsed.

    Parameters
    ----------
    faces : (f, 4) vertices
    valences : (n,) edges at each vertex
    on_rim : (n,) bool, vertices on the boundary
    held, corners : as of :func:`collapse_quads`
    """
    # Rows k and f + k merge either pair of opposite corners of face k.
    ways = np.concatenate([faces, np.roll(faces, -1, axis=1)])
    a, b, c, d = ways.T
    allowed = ~(held[a] & held[c]) & ~on_rim[a] & ~on_rim[c] & ~corners[ways].any(axis=1)
    for corner in (b, d):
        allowed &= valences[corner] > np.where(on_rim[corner], FEWEST_ON_RIM, FEWEST)
    wanted = np.where(on_rim, 3, 4)
    before = (valences - wanted)[ways]
    after = before - [0, 1, 0, 1]
    # The merged vertex has valences[a] + valences[c] - 2 edges, of 4 wanted; c is gone.
    after[:, 0], after[:, 2] = valences[a] + valences[c] - 6, 0
    gain = (before**2).sum(axis=1) - (after**2).sum(axis=1)
    allowed &= (gain > 0) & ((after != 0).sum(axis=1) <= (before != 0).sum(axis=1))
    candidates = np.flatnonzero(allowed)
    for candidate in candidates[np.argsort(-gain[candidates], kind="stable")]:
        a, b, c, d = ways[candidate]
        if _is_free(faces, a, c, {b, d}):
            return candidate % len(faces), ways[candidate]
    return None


def _is_free(faces: np.ndarray, a: int, c: int, common: set[int]) -> bool:
    """Whether a and c have only these common neighbours, and are not neighbours themselves."""
    around = []
    for vertex in (a, c):
        at = np.argwhere(faces == vertex)
        sides = [faces[at[:, 0], (at[:, 1] + step) % 4] for step in (1, 3)]
        around.append(set(np.concatenate(sides).tolist()))
    return around[0] & around[1] == common and c not in around[0]
