# SPDX-License-Identifier: GPL-3.0-or-later
"""Quality of a quad mesh: irregular vertices, corner angles, edge lengths."""

import numpy as np

from ....unit_vectors import cross
from ..trace.quad_mesh import QuadMesh

# A corner may turn so many degrees beyond 180 and still be straight: its vertex lies on a boundary.
STRAIGHT = 0.5


def quality(quads: QuadMesh) -> dict[str, float]:
    """Figures of a quad mesh as plain numbers, angles in degrees.

    ``irregular_vertices`` counts interior vertices with other than four edges, ``folds`` faces with a corner that is
    turned over; ``angle_deviation`` is the mean of |angle - 90| over all corners, ``length_spread`` the standard
    deviation of the edges' lengths over their mean.
    """
    edges, counts = quads.edges
    off, lengths = np.abs(corner_angles(quads) - 90), quads.edge_lengths
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


def corner_angles(quads: QuadMesh) -> np.ndarray:
    """(c,) degrees inside the faces, up to 360, seen along the normal of each whole face."""
    here = quads.vertices[quads.corner_vertices]
    ahead, behind = here[quads.next_corners] - here, here[quads.previous_corners] - here
    normals = cross(ahead, behind)
    lengths = np.sqrt(np.einsum("cx,cx->c", normals, normals))
    angles = np.degrees(np.arctan2(lengths, np.einsum("cx,cx->c", ahead, behind)))
    sums = np.add.reduceat(normals, quads.starts)
    looks_away = np.einsum("cx,cx->c", normals, sums[quads.corner_faces]) < 0
    return np.where(looks_away, 360 - angles, angles)


def worst_deviations(quads: QuadMesh) -> np.ndarray:
    """(f,) the largest deviation of each face's corners from a right angle, in degrees."""
    return np.maximum.reduceat(np.abs(corner_angles(quads) - 90), quads.starts)


def _is_folded(quads: QuadMesh) -> np.ndarray:
    """(f,) bool: faces with a corner whose normal is opposed to the face's, straight ones left out."""
    turned = corner_angles(quads) > 180 + STRAIGHT
    return np.bincount(quads.corner_faces[turned], minlength=len(quads.sizes)) > 0
