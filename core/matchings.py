# SPDX-License-Identifier: GPL-3.0-or-later
"""Matchings: which phase continues as which along an edge, as directions are known up to a turn.

A vertex carries k phases. Phase l grows in direction l, at pi l / k counterclockwise from the first; direction
l + k is the reverse of direction l, and its phase the negative. A line field has k = 1 and two directions, a cross
k = 2 and four. Along an edge a *matching* m says that direction m of the tail continues as direction 0 of the head:
the phases change by A^m (paper, Eq. 7), with A : x -> -x for k = 1 and A : (x, y) -> (y, -x) for k = 2.
"""

import numpy as np
from numpy.typing import ArrayLike

from .connection import levi_civita
from .geometry.triangle_mesh import TriangleMesh


def matchings(
    mesh: TriangleMesh, angles: np.ndarray, symmetry: int, correction: np.ndarray | None = None
) -> np.ndarray:
    """Compute the matching of each edge, (e,) int below the symmetry: the lower vertex's direction nearest to direction
    0 of the higher, for (n,) angles of directions 0 in the vertices' tangent planes, radians.

    The connection in use adds an (e,) correction, radians, to the surface's own for the powers of directions.
    """
    i, j = mesh.edges.T
    turn = 2 * np.pi / symmetry
    carried = levi_civita(mesh, 1)
    if correction is not None:
        carried = carried + correction / symmetry
    return np.rint((angles[j] - angles[i] - carried) / turn).astype(int) % symmetry


def after_turns(phases: np.ndarray, turns: ArrayLike) -> np.ndarray:
    """Apply A^turns (Eq. 7) to (..., k) phases in radians, or growth rates, which gives those of the directions (...,)
    int ``turns`` further on."""
    count, steps = phases.shape[-1], np.asarray(turns, int)[..., None]
    taken = phases if count == 1 else np.where(steps & 1, phases[..., ::-1], phases)
    # Directions from k to 2 k - 1 are reverse; k is 1 or 2, so that this is one bit of their number.
    return np.where((steps + np.arange(count)) & count, -taken, taken)
