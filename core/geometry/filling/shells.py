# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed surfaces of several shells: their nesting, and the orientation that belongs to the solid."""

import numpy as np

from ..triangle_mesh import TriangleMesh

# Pairs of a point and a triangle per batch, which take about 200 bytes each.
BATCH = 400_000


def orient_outwards(mesh: TriangleMesh) -> TriangleMesh:
    """Orient the faces away from the solid: outwards on shells at an even depth, inwards on cavities.

    The mesh is closed, does not intersect itself, and each shell is oriented consistently. Returned as it is if its
    faces are so already.
    """
    names, owners = np.unique(mesh.pieces[mesh.triangles[:, 0]], return_inverse=True)
    shells = np.split(np.argsort(owners, kind="stable"), np.cumsum(np.bincount(owners))[:-1])
    marks = mesh.vertices[[mesh.triangles[shell[0], 0] for shell in shells]]
    depths, volumes = np.zeros(len(names), int), np.empty(len(names))
    for number, shell in enumerate(shells):
        corners = mesh.vertices[mesh.triangles[shell]]
        a, b, c = np.moveaxis(corners - marks[number], 1, 0)
        volumes[number] = np.einsum("tx,tx->", np.cross(a, b), c)
        in_box = ((marks >= corners.min(axis=(0, 1))) & (marks <= corners.max(axis=(0, 1)))).all(axis=1)
        in_box[number] = False
        others = np.flatnonzero(in_box)
        depths[others] += np.abs(winding_numbers(corners, marks[others])) > 0.5
    wrong = np.where(depths % 2, volumes > 0, volumes < 0)[owners]
    if not wrong.any():
        return mesh
    return TriangleMesh(mesh.vertices, np.where(wrong[:, None], mesh.triangles[:, ::-1], mesh.triangles))


def winding_numbers(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Compute (k,) winding numbers of closed triangles, (t, 3, 3), around points, (k, 3): 1 inside outward faces.

    Van Oosterom and Strackee, "The solid angle of a plane triangle" (1983).
    """
    step = max(1, BATCH // len(corners))
    parts = [_winding(corners, points[start : start + step]) for start in range(0, len(points), step)]
    return np.concatenate(parts) if parts else np.zeros(0)


def _winding(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(corners - points[:, None, None], -2, 0)
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    volume = np.einsum("ptx,ptx->pt", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ptx,ptx->pt", u, v) for u, v in ((a, b), (b, c), (c, a)))
    return np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb).sum(axis=1) / (2 * np.pi)
