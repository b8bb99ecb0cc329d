# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves from their numbers of passages through faces of cells: tetrahedra, or cubes of a grid."""

from dataclasses import dataclass

import numpy as np

from ..graphs import ragged_arange


@dataclass(frozen=True)
class FaceCrossingCurve:
    """A curve from face to face.

    Attributes
    ----------
    faces : (p,) faces in the curve's direction; a closed curve does not repeat the first
    cells : cells between the faces, beginning after faces[0]
    index : positive, number of coinciding curves
    """

    faces: np.ndarray
    cells: np.ndarray
    index: int

    @property
    def is_closed(self) -> bool:
        return len(self.cells) == len(self.faces)


def join_curves(numbers: np.ndarray, cell_faces: np.ndarray, outward: np.ndarray) -> list[FaceCrossingCurve]:
    """Join punctured faces to curves, open ones first, in the order of their first faces.

    A face of number N is passed by |N| strands. The outward numbers of a cell's faces add up to 0, so that each strand
    that enters a cell continues as one that leaves it. Strands along the same faces become one of higher index.

    Parameters
    ----------
    numbers : (f,) int, positive along the face's normal
    cell_faces : (c, k) faces of each cell
    outward : (c, k) or (k,), +1 where the normal points out of the cell, else -1
    """
    faces = np.repeat(np.arange(len(numbers)), np.abs(numbers))
    starts = np.cumsum(np.abs(numbers)) - np.abs(numbers)
    leaving_numbers = numbers[cell_faces] * outward
    leaving = _list_passages(cell_faces, leaving_numbers, starts)
    coming = _list_passages(cell_faces, -leaving_numbers, starts)
    after, cell_after, entered = np.full(len(faces), -1), np.full(len(faces), -1), np.zeros(len(faces), bool)
    after[coming[1]], cell_after[coming[1]] = leaving[1], coming[0]
    entered[leaving[1]] = True
    courses: dict[tuple[tuple[int, ...], tuple[int, ...]], int] = {}
    waiting = np.ones(len(faces), bool)
    for first in [*np.flatnonzero(~entered).tolist(), *range(len(faces))]:
        strands, strand = [], first
        while strand >= 0 and waiting[strand]:
            waiting[strand] = False
            strands.append(strand)
            strand = after[strand]
        if strands:
            course = tuple(faces[strands].tolist()), tuple(c for c in cell_after[strands].tolist() if c >= 0)
            courses[course] = courses.get(course, 0) + 1
    return [FaceCrossingCurve(np.array(met), np.array(cells, int), index) for (met, cells), index in courses.items()]


def _list_passages(cell_faces: np.ndarray, numbers: np.ndarray, starts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """List cells and the strands through their faces of positive number, sorted by cell."""
    cells, sides = np.nonzero(numbers > 0)
    repeats = numbers[cells, sides]
    which, place = ragged_arange(repeats)
    return cells[which], starts[cell_faces[cells, sides]][which] + place
