# SPDX-License-Identifier: GPL-3.0-or-later
"""Continuous phases inside every tetrahedron, also those that a dislocation curve punctures (paper, Section 3.4).

Let sigma_ij be the phase change along the edge from corner i to j, and N_k = (sum of sigma around face k) / 2 pi,
counterclockwise from outside. The four N_k add up to 0, as every edge is passed once each way. The phase is

    theta = sum_i b_i a_i + omega(b),    a_j = const + 1/4 sum_i sigma_ij

- The a_j are the values whose differences are nearest to sigma. The remainder delta_ij = sigma_ij - (a_j - a_i) is
  1/4 sum_k (sigma_ij + sigma_jk + sigma_ki) = pi/2 (N_k - N_l), where face k runs from i to j and face l from j to i:
  it depends on the numbers alone. If all vanish, delta = 0, omega = 0 and theta is linear.
- On face k, omega is the interpolant of Knöppel et al. 2015 (:mod:`core.interpolate`) of delta: linear, less N_k / 3 of
  a turn on each edge, plus N_k ell. This formula is linear in the changes for given N, so that theta is the interpolant
  of sigma: a function of the face's corners alone, up to whole turns, the same from both tetrahedra.
- Inside, omega is constant along each ray from the centre: the cone over its values on the four faces.

Theta is continuous up to whole turns: on a face by the second point; where two cones meet, on rays through points of an
edge, because the interpolants agree on this edge; and inside a cone wherever the face's interpolant is continuous, that
is everywhere except on the ray through the centre of a punctured face. So theta is singular exactly on the segments
from the centres of the punctured faces to the centre of the tetrahedron: a curve through it where two faces are
punctured. Around such a segment theta turns N_k times.
"""

from dataclasses import dataclass

import numpy as np

from .geometry.tet_mesh import TET_EDGES, TET_FACES, TetMesh
from .interpolate import TURN, EdgePhases, dislocation_numbers, ell

FACE_CORNERS, EDGE_CORNERS = np.array(TET_FACES), np.array(TET_EDGES)


def face_numbers(edge_phases: EdgePhases[TetMesh]) -> np.ndarray:
    """Compute the (f,) dislocation numbers of the faces along their vertices in increasing order."""
    return dislocation_numbers(edge_phases, edge_phases.mesh.faces)[0][:, 0]


def outward_signs(mesh: TetMesh) -> np.ndarray:
    """Compute (m, 4) signs: +1 where a face's sorted vertices run counterclockwise from outside, else -1."""
    a, b, c = np.moveaxis(mesh.tets[:, FACE_CORNERS], 2, 0)
    return np.where((b > a) ^ (c > b) ^ (c > a), 1, -1)


def outward_numbers(mesh: TetMesh, numbers: np.ndarray) -> np.ndarray:
    """Compute (m, 4) dislocation numbers of faces, counterclockwise from outside: each row adds up to 0."""
    return outward_signs(mesh) * numbers[mesh.tet_faces]


@dataclass(frozen=True)
class TetPhases:
    """Values from which the phase is evaluated anywhere.

    Attributes
    ----------
    values : (m, 4) radians, the linear part at the corners
    numbers : (m, 4) dislocation numbers of the faces opposite to the corners, counterclockwise from outside
    """

    values: np.ndarray
    numbers: np.ndarray

    @property
    def punctured(self) -> np.ndarray:
        """(m,) bool: whether the phase is singular inside."""
        return self.numbers.any(axis=1)

    def gradients(self, mesh: TetMesh) -> np.ndarray:
        """Compute (m, 3) gradients of the linear part: the phase's own where no face is punctured."""
        return mesh.gradients(self.values)


def tet_phases(edge_phases: EdgePhases[TetMesh]) -> TetPhases:
    """Compute the :class:`TetPhases` of one phase per vertex."""
    mesh = edge_phases.mesh
    values = corner_values(mesh, edge_phases.changes[:, 0])
    values += (edge_phases.arguments[mesh.tets[:, 0], 0] - values[:, 0])[:, None]
    return TetPhases(values, outward_numbers(mesh, face_numbers(edge_phases)))


def corner_values(mesh: TetMesh, changes: np.ndarray) -> np.ndarray:
    """Compute (m, 4) corner values, of mean 0 in each cell, with differences nearest to (e,) changes along edges."""
    i, j = EDGE_CORNERS.T
    changes = changes[mesh.tet_edges]
    changes = np.where(mesh.tets[:, i] < mesh.tets[:, j], changes, -changes)
    values = np.zeros((mesh.tet_count, 4))
    for edge in range(6):
        values[:, j[edge]] += changes[:, edge] / 4
        values[:, i[edge]] -= changes[:, edge] / 4
    return values


def evaluate_in_tets(phases: TetPhases, tets: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Evaluate the phase at points of (k,) tetrahedra with (k, 4) barycentric weights.

    Returns (k,) radians, continuous up to whole turns; on the singular curve the value is arbitrary.
    """
    linear = np.einsum("ki,ki->k", weights, phases.values[tets])
    singular = phases.punctured[tets]
    linear[singular] += _cone(phases.numbers[tets[singular]], weights[singular])
    return linear


def _cone(numbers: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Evaluate omega in punctured tetrahedra, 0 at the first corner."""
    rows = np.arange(len(weights))
    face = weights.argmin(axis=1)
    corners = FACE_CORNERS[face]
    height = np.maximum(1 - 4 * weights[rows, face], 1e-12)
    on_face = (weights[rows[:, None], corners] - weights[rows, face, None]) / height[:, None]
    number = numbers[rows, face]
    steps = [_remainders(numbers, corners[:, k], corners[:, (k + 1) % 3]) - TURN / 3 * number for k in range(2)]
    start = _remainders(numbers, np.zeros(len(rows), int), corners[:, 0])
    rise = on_face[:, 1] * steps[0] + on_face[:, 2] * (steps[0] + steps[1])
    return start + rise + number * ell(on_face)


def _remainders(numbers: np.ndarray, tails: np.ndarray, heads: np.ndarray) -> np.ndarray:
    """Compute (k,) delta from corner to corner, 0 from a corner to itself."""
    ahead, behind = _FACES_AT[tails, heads].T
    rows = np.arange(len(numbers))
    return TURN / 4 * np.where(tails == heads, 0, numbers[rows, ahead] - numbers[rows, behind])


def _faces_at() -> np.ndarray:
    """Tabulate (4, 4, 2) the face that runs from corner i to j, and the one that runs from j to i."""
    table = np.zeros((4, 4, 2), int)
    for face, corners in enumerate(FACE_CORNERS):
        for i, j in zip(corners, np.roll(corners, -1), strict=True):
            table[i, j, 0] = table[j, i, 1] = face
    return table


_FACES_AT = _faces_at()
