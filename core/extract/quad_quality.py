# SPDX-License-Identifier: GPL-3.0-or-later
"""How good a quad mesh is: irregular vertices, corner angles, edge lengths."""

import numpy as np


def quality(quads):
    """Figures of a :class:`QuadMesh`, angles in degrees, as a dict of plain numbers.

    ``irregular_vertices`` are those inside with other than four edges; ``angle_deviation`` is the mean of |angle - 90|
    over all corners, ``length_spread`` the standard deviation of the edges' lengths over their mean.
    """
    edges, counts = quads.edges
    valences = np.bincount(edges.ravel(), minlength=len(quads.vertices))
    inside = np.ones(len(quads.vertices), bool)
    inside[edges[counts == 1]] = False
    off = np.abs(corner_angles(quads) - 90)
    lengths = np.linalg.norm(quads.vertices[edges[:, 1]] - quads.vertices[edges[:, 0]], axis=1)
    return {
        "vertices": len(quads.vertices),
        "edges": len(edges),
        "faces": len(quads.sizes),
        "quad_share": float((quads.sizes == 4).mean()),
        "irregular_vertices": int((inside & (valences != 4)).sum()),
        "euler_characteristic": quads.euler_characteristic,
        "closed": bool((counts == 2).all()),
        "angle_deviation": float(off.mean()),
        "worst_angle": float(off.max()),
        "edge_length": float(lengths.mean()),
        "length_spread": float(lengths.std() / lengths.mean()),
    }


def corner_angles(quads):
    """(c,) degrees."""
    corners, following = quads.corner_vertices, quads.next_corners
    before = np.empty_like(following)
    before[following] = np.arange(len(following))
    ahead = quads.vertices[corners[following]] - quads.vertices[corners]
    behind = quads.vertices[corners[before]] - quads.vertices[corners]
    across = np.linalg.norm(np.cross(ahead, behind), axis=1)
    return np.degrees(np.arctan2(across, np.einsum("ij,ij->i", ahead, behind)))
