# SPDX-License-Identifier: GPL-3.0-or-later
"""Dislocation curves of layers in a solid, from punctured face to punctured face (paper, Sections 3.3 and 3.4)."""

from dataclasses import dataclass

import numpy as np

from ...geometry.face_crossing_curves import join_curves
from ...geometry.smoothing import smooth_line
from ...interpolate_solid import outward_signs

# Smoothing goes half of the way to the middle of the neighbours, and not back: paths through tetrahedra waver over many
# points.
_STEPS = (0.5,)


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
    """

    points: np.ndarray
    faces: np.ndarray
    tets: np.ndarray
    index: int

    @property
    def is_closed(self):
        return len(self.tets) == len(self.faces)

    @property
    def smooth_points(self):
        """(p, 3) points without the zigzag from cell to cell; the ends of an open curve stay.

        They move half as many times as there are points: a ring of any size shrinks by less than the distance between
        two of them.
        """
        return smooth_line(self.points, self.is_closed, len(self.points) // 2, _STEPS)


def defect_curves(mesh, numbers):
    """Join punctured faces to curves, each of which closes or ends on the boundary.

    Returns list of DefectCurve, open ones first, in the order of their first faces.

    Parameters
    ----------
    mesh : TetMesh
    numbers : (f,) as :func:`core.interpolate_solid.face_numbers` gives them
    """
    # By the right hand: where the phase turns counterclockwise seen from outside, the curve comes out.
    return [_curve(mesh, strand) for strand in join_curves(numbers, mesh.tet_faces, outward_signs(mesh))]


def _curve(mesh, strand):
    points = np.empty((len(strand.faces) + len(strand.cells), 3))
    points[0::2] = mesh.vertices[mesh.faces[strand.faces]].mean(axis=1)
    points[1::2] = mesh.vertices[mesh.tets[strand.cells]].mean(axis=1)
    return DefectCurve(points, strand.faces, strand.cells, strand.index)
