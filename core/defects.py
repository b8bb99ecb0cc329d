# SPDX-License-Identifier: GPL-3.0-or-later
"""Topological defects with exact integer indices (paper, Sections 3.1.1 and 3.3)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .connection import levi_civita
from .geometry.triangle_mesh import TriangleMesh


@dataclass(frozen=True)
class Defect:
    """One defect in one triangle.

    Attributes
    ----------
    kind : "disclination" of a direction field, or "dislocation" of a pattern
    index : k / symmetry for a disclination, the integer N for a dislocation; the sign of N is
        relative to the sheet of the triangle's first corner, and arbitrary for line and cross fields
    position, normal : (3,) the triangle's centre and normal
    phase : which phase of a quad pattern has the dislocation, at the triangle's first corner
    """

    kind: str
    triangle: int
    index: float
    position: np.ndarray
    normal: np.ndarray
    phase: int


def wrap(angles: ArrayLike) -> np.ndarray:
    """Angles in [-pi, pi)."""
    return (np.asarray(angles) + np.pi) % (2 * np.pi) - np.pi


def disclination_numbers(
    mesh: TriangleMesh, powers: np.ndarray, symmetry: int, correction: np.ndarray | None = None
) -> np.ndarray:
    """Integer k of each triangle: the field turns by 2 pi k / symmetry around it against the surface.

    Edge residuals enter both triangles of an edge with opposite signs and the curvatures sum to
    2 pi chi, so that on a closed mesh the sum of k / symmetry is the Euler characteristic, exactly.

    Parameters
    ----------
    powers : (n,) complex, the symmetry-th power of the field in the vertices' tangent planes
    correction : (e,) radians that the connection in use adds to the surface's own along the edges
    """
    i, j = mesh.edges.T
    angles = np.angle(powers)
    added = np.zeros(len(mesh.edges)) if correction is None else correction
    residuals = wrap(angles[j] - angles[i] - levi_civita(mesh, symmetry) - added) + added
    around = (mesh.triangle_edge_signs * residuals[mesh.triangle_edges]).sum(axis=1)
    return np.rint((around + symmetry * mesh.face_curvatures) / (2 * np.pi)).astype(int)


def list_defects(mesh: TriangleMesh, kind: str, numbers: np.ndarray, symmetry: int = 1, phase: int = 0) -> list[Defect]:
    """List a :class:`Defect` for each triangle with a nonzero number.

    ``numbers`` are (t,) integers: indices of dislocations, or indices of disclinations times the symmetry.
    """
    triangles = np.flatnonzero(numbers)
    centres = mesh.vertices[mesh.triangles[triangles]].mean(axis=1)
    indices = numbers[triangles] / symmetry if symmetry > 1 else numbers[triangles]
    return [
        Defect(kind, int(t), index.item(), position, normal, phase)
        for t, index, position, normal in zip(triangles, indices, centres, mesh.face_normals[triangles], strict=True)
    ]
