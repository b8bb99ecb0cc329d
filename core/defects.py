# SPDX-License-Identifier: GPL-3.0-or-later
"""Topological defects with exact integer indices (paper, Sections 3.1.1 and 3.3)."""

from dataclasses import dataclass

import numpy as np

from .connection import levi_civita


@dataclass(frozen=True)
class Defect:
    """One defect in one triangle.

    Attributes
    ----------
    kind : "disclination" of a direction field, or "dislocation" of a pattern
    triangle : index of the triangle
    index : k / symmetry for a disclination, the integer N for a dislocation; the sign of N is
        relative to the sheet of the triangle's first corner, and arbitrary for line and cross fields
    position, normal : (3,) the triangle's centre and normal
    phase : number of the phase of a quad pattern that a dislocation is in, at the triangle's first corner
    """

    kind: str
    triangle: int
    index: float
    position: np.ndarray
    normal: np.ndarray
    phase: int


def wrap(angles):
    """Angles in [-pi, pi)."""
    return (np.asarray(angles) + np.pi) % (2 * np.pi) - np.pi


def disclination_numbers(mesh, powers, symmetry, correction=None):
    """Integer k of each triangle: the field turns by 2 pi k / symmetry around it against the surface.

    Edge residuals enter both triangles of an edge with opposite signs and the curvatures sum to
    2 pi chi, so that on a closed mesh the sum of k / symmetry is the Euler characteristic, exactly.

    Parameters
    ----------
    powers : (n,) complex, the symmetry-th power of the field in the vertices' tangent planes
    correction : (e,) radians by which powers turn further along the edges than by the surface's own connection,
        against which the turns of the field are told; optional
    """
    i, j = mesh.edges.T
    angles = np.angle(powers)
    correction = 0.0 if correction is None else correction
    residuals = wrap(angles[j] - angles[i] - levi_civita(mesh, symmetry) - correction) + correction
    around = (mesh.triangle_edge_signs * residuals[mesh.triangle_edges]).sum(axis=1)
    return np.rint((around + symmetry * mesh.face_curvatures) / (2 * np.pi)).astype(int)


def list_defects(mesh, kind, numbers, symmetry=1, phase=0):
    """:class:`Defect` records of the triangles whose number is not zero."""
    triangles = np.flatnonzero(numbers)
    centres = mesh.vertices[mesh.triangles[triangles]].mean(axis=1)
    indices = numbers[triangles] / symmetry if symmetry > 1 else numbers[triangles]
    return [
        Defect(kind, int(t), index.item(), position, normal, phase)
        for t, index, position, normal in zip(triangles, indices, centres, mesh.face_normals[triangles], strict=True)
    ]
