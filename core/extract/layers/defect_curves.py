# SPDX-License-Identifier: GPL-3.0-or-later
"""Dislocation curves of layers in a solid, from punctured face to punctured face (paper, Sections 3.3 and 3.4), and the
places where they leave it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...geometry.face_crossing_curves import FaceCrossingCurve, join_curves
from ...geometry.nearest import NearestTriangles
from ...geometry.smoothing import smooth_line
from ...geometry.tet_mesh import TetMesh
from ...interpolate_solid import outward_signs
from ...unit_vectors import unit_vectors
from .surfaces import LayerSurfaces

# Smoothing goes half of the way to the middle of the neighbours, and not back: paths through tetrahedra are too uneven.
_STEPS = (0.5,)


@dataclass(frozen=True)
class DefectCurve:
    """One curve; the phase turns by 2 pi ``index`` around it, counterclockwise seen from its head.

    Attributes
    ----------
    points : (p, 3) centres of faces and tetrahedra in turn; an open curve begins and ends on the boundary, a closed one
        does not repeat its first point
    faces : the faces that it crosses, in order
    tets : the tetrahedra that it passes through, the first one after faces[0]
    index : positive
    """

    points: np.ndarray
    faces: np.ndarray
    tets: np.ndarray
    index: int

    @property
    def is_closed(self) -> bool:
        return len(self.tets) == len(self.faces)

    @property
    def smooth_points(self) -> np.ndarray:
        """(p, 3) points without the zigzag from cell to cell; the ends of an open curve stay.

        With half as many steps as there are points, a ring of any size shrinks by less than the distance of two points.
        """
        return smooth_line(self.points, self.is_closed, len(self.points) // 2, _STEPS)


def defect_curves(mesh: TetMesh, numbers: np.ndarray) -> list[DefectCurve]:
    """Join punctured faces, by their (f,) :func:`core.interpolate_solid.face_numbers`, to curves that close or end on
    the boundary: open ones first, in the order of their first faces."""
    # By the right hand: where the phase turns counterclockwise seen from outside, the curve comes out.
    return [_curve(mesh, curve) for curve in join_curves(numbers, mesh.tet_faces, outward_signs(mesh))]


def _curve(mesh: TetMesh, curve: FaceCrossingCurve) -> DefectCurve:
    points = np.empty((len(curve.faces) + len(curve.cells), 3))
    points[0::2] = mesh.vertices[mesh.faces[curve.faces]].mean(axis=1)
    points[1::2] = mesh.vertices[mesh.tets[curve.cells]].mean(axis=1)
    return DefectCurve(points, curve.faces, curve.cells, curve.index)


@dataclass(frozen=True)
class CurveEnd:
    """One end of a curve, on the boundary of a solid.

    Attributes
    ----------
    face : the nearest triangle of the layers
    index : of the curve, positive where it leaves the solid
    normal : unit vector out of the solid
    """

    face: int
    index: int
    position: tuple[float, float, float]
    normal: tuple[float, float, float]


def curve_ends(solid: TetMesh, surfaces: LayerSurfaces, curves: Sequence[DefectCurve]) -> tuple[CurveEnd, ...]:
    """Both ends of each open curve in a solid."""
    ends = [
        (curve.points[place], curve.faces[place], sign * curve.index)
        for curve in curves
        if not curve.is_closed
        for place, sign in ((0, -1), (-1, 1))
    ]
    if not ends:
        return ()
    _, faces = NearestTriangles(surfaces.vertices, surfaces.triangles).nearest([end[0] for end in ends])
    rows = np.searchsorted(solid.boundary_faces, [end[1] for end in ends])
    a, b, c = np.moveaxis(solid.vertices[solid.boundary_triangles[rows]], 1, 0)
    normals = unit_vectors(np.cross(b - a, c - a))
    return tuple(
        CurveEnd(int(face), index, tuple(point.tolist()), tuple(normal.tolist()))
        for (point, _, index), face, normal in zip(ends, faces, normals, strict=True)
    )
