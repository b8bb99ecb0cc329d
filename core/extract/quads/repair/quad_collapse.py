# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads closed, two corners across from each other made one, where that leaves more vertices regular.

Where odd faces were paired, vertices with three and with five edges lie beside each other. A quad with corners of
3, 5, 3 and 5 edges closes to nothing but regular ones (Daniels et al. 2008 call that a quad collapse).
"""

from dataclasses import replace

import numpy as np

from ....geometry.barycentric import barycentric
from ....geometry.nearest import NearestTriangles
from ..features.chains import move_vertices

# Edges at a vertex at least, inside and on the boundary.
FEWEST, FEWEST_ON_RIM = 3, 2


def with_faces_closed(quads, mesh, held, corners):
    """The :class:`QuadMesh` with quads closed, and (k,) which of its vertices were kept, in their order.

    A vertex is irregular by the square of the edges that it has too many or too few. Each quad that is closed takes
    some of that away and leaves no more irregular vertices than there were.

    Parameters
    ----------
    quads : QuadMesh of nothing but quads
    mesh : TriangleMesh that it is on
    held : (n,) bool, vertices that stay where they are; no two of them become one
    corners : (n,) bool, vertices whose edges stay, too
    """
    faces = quads.corner_vertices.reshape(-1, 4).copy()
    edges, counts = quads.edges
    valences = np.bincount(edges.ravel(), minlength=len(held))
    on_rim = np.zeros(len(held), bool)
    on_rim[edges[counts == 1]] = True
    vertices = quads.vertices.copy()
    moved = np.zeros(len(held), bool)
    while (found := _first(faces, valences, on_rim, held, corners)) is not None:
        number, (a, b, c, d) = found
        kept, gone = (c, a) if held[c] else (a, c)
        if not held[kept]:
            vertices[kept] = (vertices[a] + vertices[c]) / 2
            moved[kept] = True
        valences[kept], valences[gone] = valences[a] + valences[c] - 2, 0
        valences[[b, d]] -= 1
        faces = np.delete(faces, number, axis=0)
        faces[faces == gone] = kept
    used, corner_vertices = np.unique(faces, return_inverse=True)
    which = np.flatnonzero(moved)
    places, triangles = NearestTriangles(mesh.vertices, mesh.triangles).nearest(vertices[which])
    quads = move_vertices(quads, which, places, triangles, barycentric(mesh, triangles, places))
    own = {name: getattr(quads, name)[used] for name in ("vertices", "triangles", "weights")}
    return replace(quads, **own, corner_vertices=corner_vertices.ravel(), sizes=np.full(len(faces), 4)), used


def _first(faces, valences, on_rim, held, corners):
    """The face whose closing takes the most away, and its corners from one that meets the one across; None where there
    is no such face."""
    ways = np.concatenate([faces, np.roll(faces, -1, axis=1)])
    a, b, c, d = ways.T
    allowed = ~(held[a] & held[c]) & ~on_rim[a] & ~on_rim[c] & ~corners[ways].any(axis=1)
    for corner in (b, d):
        allowed &= valences[corner] > np.where(on_rim[corner], FEWEST_ON_RIM, FEWEST)
    wanted = np.where(on_rim, 3, 4)
    before = (valences - wanted)[ways]
    after = before - [0, 1, 0, 1]
    after[:, 0], after[:, 2] = valences[a] + valences[c] - 6, 0
    gain = (before**2).sum(axis=1) - (after**2).sum(axis=1)
    allowed &= (gain > 0) & ((after != 0).sum(axis=1) <= (before != 0).sum(axis=1))
    candidates = np.flatnonzero(allowed)
    for candidate in candidates[np.argsort(-gain[candidates], kind="stable")]:
        if _is_free(faces, *ways[candidate]):
            return candidate % len(faces), ways[candidate]
    return None


def _is_free(faces, a, b, c, d):
    """Whether a and c have no neighbours in common but b and d, and are none themselves."""
    around = []
    for vertex in (a, c):
        at = np.argwhere(faces == vertex)
        sides = [faces[at[:, 0], (at[:, 1] + step) % 4] for step in (1, 3)]
        around.append(set(np.concatenate(sides).tolist()))
    return around[0] & around[1] == {b, d} and c not in around[0]
