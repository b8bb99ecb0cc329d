# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers in tetrahedra that a dislocation curve punctures: sheets that end at the curve, and whole ones.

On the rim of a face the phase crosses levels upwards or downwards, N times more often upwards where it turns N times.
Two crossings beside each other of which one goes up and one down belong to the same line on the face, and so on with
those that are left, until the N remain whose lines run to the face's centre. The lines on the four faces of a
tetrahedron join to closed loops, which bound sheets, and to ways from one puncture to another, which bound sheets
together with the singular curve through the centre.
"""

from itertools import pairwise

import numpy as np

from ...interpolate_solid import outward_signs


def sheets_in(crossings, numbers, tets):
    """Triangles of the levels in punctured tetrahedra, normals along the growth.

    Returns (k, 3) int: crossings, then crossings + f for the centre of face f, then crossings + faces + t for that of
    tet t.

    Parameters
    ----------
    crossings : LayerCrossings
    numbers : (f,) dislocation numbers of the faces
    tets : (t,) tetrahedra
    """
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
        while following:
            first, node = following.popitem()
            loop = [first]
            while node != first:
                loop.append(node)
                node = following.pop(node)
            triangles += [(first, a, b) for a, b in pairwise(loop[1:])]
    return np.array(triangles, int).reshape(-1, 3)


def _lines_on(crossings, numbers, faces):
    """Dict of face to the lines on it: pairs of crossings, or of one and the face's centre, the higher side on the left
    where the face's vertices in increasing order go round counterclockwise."""
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


def _pair_rims(rim, centre):
    """Lines from where the rim goes down to where it goes up, as the higher side is to be on the left."""
    lines: list[tuple[int, int]] = []
    open_ends: list[tuple[int, bool]] = []
    for _, crossing, rises in rim:
        if open_ends and open_ends[-1][1] != rises:
            other = open_ends.pop()[0]
            lines.append((other, crossing) if rises else (crossing, other))
        else:
            open_ends.append((crossing, rises))
    return lines + [(centre, crossing) if rises else (crossing, centre) for crossing, rises in open_ends]


def _partings(changes, numbers):
    """(f,) where to begin on the rims of faces, in sides from the first corner.

    Lines near a corner turn around it on one side of the puncture. The interpolant divides them at its saddle, on the
    ray from the centre on which its linear part stays what it is at the centre, while it falls along the rim where
    the number is positive.
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
