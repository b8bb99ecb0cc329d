# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers in tetrahedra that a dislocation curve punctures: sheets that end at the curve, and whole ones.

On the rim of a face the phase crosses levels upwards or downwards, N times more often upwards where it turns N times.
Neighbouring crossings, one upwards and one downwards, are joined by a line on the face, then neighbours among the
others, until N remain, whose lines end at the face's centre. The lines on the four faces of a tetrahedron form closed
loops, which bound sheets, and paths from one puncture to another, which bound sheets together with the singular curve
through the centre.
"""

from itertools import pairwise

import numpy as np

from ...graphs import take_loops
from ...interpolate_solid import outward_signs
from .crossings import LayerCrossings


def sheets_in(crossings: LayerCrossings, numbers: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """(k, 3) triangles of the levels in (t,) punctured tetrahedra, by the (f,) dislocation numbers of the faces;
    normals point to larger phases. Corners are crossings, then centres of faces, then centres of tetrahedra."""
    mesh, count = crossings.mesh, len(crossings.edges)
    tet_centre = count + len(mesh.faces)
    signs = outward_signs(mesh)[tets].tolist()
    lines = _lines_on(crossings, numbers, np.unique(mesh.tet_faces[tets]))
    triangles = []
    # A few loops in each of the few tetrahedra near the dislocation curves.
    for tet, faces, outward in zip(tets.tolist(), mesh.tet_faces[tets].tolist(), signs, strict=True):
        following, ways = {}, []
        for face, sign in zip(faces, outward, strict=True):
            for tail, head in lines[face]:
                tail, head = (tail, head) if sign > 0 else (head, tail)
                if tail < count:
                    following[tail] = head
                else:
                    ways.append([tail, head])
        for way in ways:
            while way[-1] < count:
                way.append(following.pop(way[-1]))
            triangles += [(tet_centre + tet, a, b) for a, b in pairwise(way)]
        for first, *loop in take_loops(following):
            triangles += [(first, a, b) for a, b in pairwise(loop)]
    return np.array(triangles, int).reshape(-1, 3)


def _lines_on(crossings: LayerCrossings, numbers: np.ndarray, faces: np.ndarray) -> dict[int, list[tuple[int, int]]]:
    """The lines of levels on each face: pairs of crossings, or of a crossing and the face's centre.

    Larger phases are on their left if the face's vertices in increasing order are counterclockwise.
    """
    mesh = crossings.mesh
    a, b, c = mesh.faces[faces].T
    edges = np.column_stack([mesh.edges_between(a, b), mesh.edges_between(b, c), mesh.edges_between(a, c)])
    changes = crossings.changes[edges] * [1, 1, -1]
    parting = _partings(changes, numbers[faces])
    count, shares = len(crossings.edges), crossings.shares.tolist()
    starts, counts = crossings.starts[edges].tolist(), crossings.counts[edges].tolist()
    result = {}
    for row, face in enumerate(faces.tolist()):
        rim = []
        for side in range(3):
            met = range(starts[row][side], starts[row][side] + counts[row][side])
            rises = changes[row, side] > 0
            if side < 2:
                rim += [(side + shares[crossing], crossing, rises) for crossing in met]
            else:
                rim += [(3 - shares[crossing], crossing, rises) for crossing in reversed(met)]
        split = sum(place < parting[row] for place, _, _ in rim)
        result[face] = _pair_rims(rim[split:] + rim[:split], count + face)
    return result


def _pair_rims(rim: list[tuple[float, int, bool]], centre: int) -> list[tuple[int, int]]:
    """Lines from downward to upward crossings of a rim, so that the higher side is on the left."""
    lines: list[tuple[int, int]] = []
    open_ends: list[tuple[int, bool]] = []
    for _, crossing, rises in rim:
        if open_ends and open_ends[-1][1] != rises:
            other = open_ends.pop()[0]
            lines.append((other, crossing) if rises else (crossing, other))
        else:
            open_ends.append((crossing, rises))
    return lines + [(centre, crossing) if rises else (crossing, centre) for crossing, rises in open_ends]


def _partings(changes: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """(f,) places on the rims of faces, in sides from the first corner, where pairing starts.

    Lines near a corner turn around it on one side of the puncture. The interpolant divides them at its saddle, on the
    ray from the centre along which its linear part is constant, and falls along the rim for a positive number.
    """
    values = np.zeros_like(changes)
    values[:, 1:] = np.cumsum(changes, axis=1)[:, :2] - numbers[:, None] / 3 * [1, 2]
    values = np.sign(numbers)[:, None] * (values - values.mean(axis=1, keepdims=True))
    after = np.roll(values, -1, axis=1)
    falls = (values > 0) & (after <= 0)
    side = falls.argmax(axis=1)
    rows = np.arange(len(side))
    high, low = values[rows, side], after[rows, side]
    return np.where(falls.any(axis=1), side + high / np.where(high > low, high - low, 1), 0)
