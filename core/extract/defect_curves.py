# SPDX-License-Identifier: GPL-3.0-or-later
"""Dislocation curves of layers in a solid, from punctured face to punctured face (paper, Sections 3.3 and 3.4)."""

from dataclasses import dataclass

import numpy as np

from ..interpolate_solid import outward_numbers


@dataclass(frozen=True)
class DefectCurve:
    """One curve; the phase turns by 2 pi ``index`` around it, counterclockwise seen from its head.

    Attributes
    ----------
    points : (p, 3) centres of faces and tetrahedra by turns, as the curve passes them; an open one begins and ends
        on the boundary, of a closed one the first does not come again
    faces : indices of the faces that it punctures
    tets : indices of the tetrahedra that it runs through, the first one from faces[0] on
    index : positive integer
    is_closed : bool
    """

    points: np.ndarray
    faces: np.ndarray
    tets: np.ndarray
    index: int
    is_closed: bool


def defect_curves(mesh, numbers):
    """Join punctured faces to curves.

    A face of number N is passed by |N| strands. As the numbers of a tetrahedron's faces add up to 0, as many strands
    come in as go out; each one that comes in goes on as one that goes out. Strands with the same course are one curve of
    higher index.

    Parameters
    ----------
    mesh : TetMesh
    numbers : (f,) as :func:`core.interpolate_solid.face_numbers` gives them

    Returns
    -------
    list of DefectCurve, open ones first, in the order of their first faces
    """
    faces = np.repeat(np.arange(len(numbers)), np.abs(numbers))
    entered, tet_after, after = _successors(mesh, numbers)
    courses = {}
    waiting = np.ones(len(faces), bool)
    # One step a strand: as many as there are punctured faces.
    for first in [*np.flatnonzero(~entered).tolist(), *range(len(faces))]:
        if not waiting[first]:
            continue
        strands, strand = [], first
        while strand >= 0 and waiting[strand]:
            waiting[strand] = False
            strands.append(strand)
            strand = after[strand]
        course = tuple(faces[strands].tolist()), tuple(t for t in tet_after[strands].tolist() if t >= 0)
        courses[course] = courses.get(course, 0) + 1
    return [_curve(mesh, np.array(met), np.array(tets, int), index) for (met, tets), index in courses.items()]


def _successors(mesh, numbers):
    """Of each strand whether it comes out of a tetrahedron, which one it goes into and as which strand it leaves that,
    -1 where it leaves the solid."""
    starts = np.cumsum(np.abs(numbers)) - np.abs(numbers)
    count = int(np.abs(numbers).sum())
    outward = outward_numbers(mesh, numbers)
    # By turns of the right hand: where the phase turns counterclockwise seen from outside, the curve comes out.
    leaving = _strands(mesh, outward, starts)
    coming = _strands(mesh, -outward, starts)
    after, tet_after, entered = np.full(count, -1), np.full(count, -1), np.zeros(count, bool)
    after[coming[1]], tet_after[coming[1]] = leaving[1], coming[0]
    entered[leaving[1]] = True
    return entered, tet_after, after


def _strands(mesh, numbers, starts):
    """Tetrahedra and strands through their faces of positive number, sorted by tetrahedron."""
    tets, sides = np.nonzero(numbers > 0)
    repeats = numbers[tets, sides]
    which = np.repeat(np.arange(len(tets)), repeats)
    place = np.arange(len(which)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    return tets[which], starts[mesh.tet_faces[tets, sides]][which] + place


def _curve(mesh, faces, tets, index):
    is_closed = len(tets) == len(faces)
    points = np.empty((len(faces) + len(tets), 3))
    points[0::2] = mesh.vertices[mesh.faces[faces]].mean(axis=1)
    points[1::2] = mesh.vertices[mesh.tets[tets]].mean(axis=1)
    return DefectCurve(points, faces, tets, index, is_closed)
