# SPDX-License-Identifier: GPL-3.0-or-later
"""How good a quad mesh is: irregular vertices, corner angles, edge lengths."""

import numpy as np


def quality(quads):
    """Figures of a :class:`QuadMesh`, angles in degrees, as a dict of plain numbers.

    ``folds`` are faces with a corner that is turned over against the rest of the face.

    ``irregular_vertices`` are those inside with other than four edges; ``angle_deviation`` is the mean of |angle - 90|
    over all corners, ``length_spread`` the standard deviation of the edges' lengths over their mean.
    """
    edges, counts = quads.edges
    off = np.abs(corner_angles(quads) - 90)
    lengths = np.linalg.norm(quads.vertices[edges[:, 1]] - quads.vertices[edges[:, 0]], axis=1)
    return {
        "vertices": len(quads.vertices),
        "edges": len(edges),
        "faces": len(quads.sizes),
        "quad_share": float((quads.sizes == 4).mean()),
        "irregular_vertices": int(quads.is_irregular.sum()),
        "euler_characteristic": quads.euler_characteristic,
        "closed": bool((counts == 2).all()),
        "angle_deviation": float(off.mean()),
        "worst_angle": float(off.max()),
        "folds": int(_is_folded(quads).sum()),
        "edge_length": float(lengths.mean()),
        "length_spread": float(lengths.std() / lengths.mean()),
    }


def corner_angles(quads):
    """(c,) degrees inside the faces, up to 360, seen along the normal of each whole face."""
    ahead, behind = _sides(quads)
    across = np.linalg.norm(np.cross(ahead, behind), axis=1)
    angles = np.degrees(np.arctan2(across, np.einsum("ij,ij->i", ahead, behind)))
    return np.where(_looks_away(quads), 360 - angles, angles)


def _sides(quads):
    """(c, 3) from each corner to the next one, and to the one before."""
    corners, following = quads.corner_vertices, quads.next_corners
    before = np.empty_like(following)
    before[following] = np.arange(len(following))
    ahead = quads.vertices[corners[following]] - quads.vertices[corners]
    return ahead, quads.vertices[corners[before]] - quads.vertices[corners]


def _is_folded(quads):
    """(f,) bool: faces with a corner that looks the other way than the face on the whole."""
    return np.bincount(quads.corner_faces[_looks_away(quads)], minlength=len(quads.sizes)) > 0


def _looks_away(quads):
    """(c,) bool: corners that look the other way than their face on the whole."""
    normals = np.cross(*_sides(quads))
    sums = np.add.reduceat(normals, quads.starts)
    return np.einsum("cx,cx->c", normals, sums[quads.corner_faces]) < 0
