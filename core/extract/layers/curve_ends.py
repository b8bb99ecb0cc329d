# SPDX-License-Identifier: GPL-3.0-or-later
"""The places where dislocation curves leave a solid, on its layers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...geometry.nearest import NearestTriangles
from ...geometry.tet_mesh import TetMesh
from .defect_curves import DefectCurve
from .surfaces import LayerSurfaces


@dataclass(frozen=True)
class CurveEnd:
    """One end of a curve.

    Attributes
    ----------
    face : of the layers' triangles, the nearest
    index : of the curve by the right hand: positive where it comes out
    position : of the end
    normal : unit vector out of the solid
    """

    face: int
    index: int
    position: tuple[float, float, float]
    normal: tuple[float, float, float]


def curve_ends(solid: TetMesh, surfaces: LayerSurfaces, curves: Sequence[DefectCurve]) -> tuple[CurveEnd, ...]:
    """:class:`CurveEnd` of each end of open curves.

    Parameters
    ----------
    solid : TetMesh
    surfaces : LayerSurfaces in it
    curves : DefectCurves in it
    """
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
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return tuple(
        CurveEnd(int(face), index, tuple(point.tolist()), tuple(normal.tolist()))
        for (point, _, index), face, normal in zip(ends, faces, normals, strict=True)
    )
