# SPDX-License-Identifier: GPL-3.0-or-later
"""Continuous phases inside every face, singular ones included.

Along an edge the phase changes by sigma = angle + wrap(arg phi_j - arg phi_i - angle). The phase at a
point is

    theta = interpolated corner phase + N * ell(b) + D(b)

- In a regular face the corners' phases differ by sigma and theta is linear on each triangle.
- With a *dislocation* the sigma around a triangle sum to 2 pi N. The corners share out -2 pi N, and
  ell, which turns once around the centre and linearly along the edges (lArg of Knöppel et al. 2015),
  gives it back. In a quad split along its diagonal AC, ell grows by pi along the two outer edges of a
  triangle and not at all along the diagonal, so that both triangles agree on A and C.
- A face with a *disclination* has no consistent sheet: going round, the values come back as
  x -> -x + 2 pi M. It is a fan around its centre, whose value must be pi M; the corners all carry
  that value, and D interpolates the differences to it along the rim.

Only cos(theta) is continuous from face to face: sheets may differ by a sign, values by 2 pi.
"""

from dataclasses import dataclass

import numpy as np

from .defects import wrap
from .geometry import TriangleMesh

TURN = 2 * np.pi


@dataclass(frozen=True)
class EdgePhases:
    """Phase changes along the edges of a mesh.

    ``changes`` are (e,) radians from the lower to the higher vertex, in the sheet of the lower; ``signs``
    are -1 where the sheet turns over along the edge.
    """

    mesh: TriangleMesh
    arguments: np.ndarray
    changes: np.ndarray
    signs: np.ndarray

    @classmethod
    def of(cls, mesh, phases, angles, flips):
        """From (n,) complex phases and the edges' transports ``exp(1j angle) (conj if flip)``."""
        i, j = mesh.edges.T
        arguments = np.angle(phases)
        signs = np.where(flips, -1, 1)
        asked = signs * angles  # the transport seen in the sheet of the lower vertex
        changes = asked + wrap(signs * arguments[j] - arguments[i] - asked)
        return cls(mesh, arguments, changes, signs)

    def between(self, tails, heads):
        """Change from tail to head in the sheet of the tail, and the edge's sign."""
        edge = self.mesh.edges_between(tails, heads)
        signs = self.signs[edge]
        # Walked backwards, from the sheet of the higher vertex: -sigma, turned over with the sheet.
        changes = np.where(tails < heads, self.changes[edge], -signs * self.changes[edge])
        return changes, signs

    def around(self, corners):
        """Values met on a walk around (f, k) vertices, in the sheet of the first.

        Returns (f, k + 1) phases, starting at the first vertex's argument and ending there again,
        and (f,) the product of the signs.
        """
        values = [self.arguments[corners[:, 0]]]
        sheet = np.ones(len(corners), int)
        for k in range(corners.shape[1]):
            change, sign = self.between(corners[:, k], corners[:, (k + 1) % corners.shape[1]])
            values.append(values[-1] + sheet * change)
            sheet = sheet * sign
        return np.column_stack(values), sheet


def dislocation_numbers(edge_phases, triangles):
    """Integer N of each triangle, 0 where it holds a disclination, and whether it does."""
    values, sheet = edge_phases.around(triangles)
    numbers = np.rint((values[:, 3] - values[:, 0]) / TURN).astype(int)
    return np.where(sheet > 0, numbers, 0), sheet < 0


@dataclass(frozen=True)
class FacePhases:
    """What a shader or a sampler needs to evaluate the phase anywhere (see :func:`evaluate`).

    Attributes
    ----------
    corner_phase : (c,) radians, the first corner of a face without disclination in [-pi, pi]
    corner_place : (c, 3) zero in regular faces; in a singular triangle the corner weights; in a
        singular quad ABCD split along AC (s, t, -1) with s = (0, 1, 0, -1) and t = (0, 0, 1, 0)
    index, index_2 : (p,) dislocation numbers of a face's first and second triangle
    disclination : (p, 4) values along the rim less the centre's value; zero without a disclination
    unfit : indices of the faces that only splitting them into triangles can represent
    """

    corner_phase: np.ndarray
    corner_place: np.ndarray
    index: np.ndarray
    index_2: np.ndarray
    disclination: np.ndarray
    unfit: np.ndarray


def face_phases(edge_phases, polygons):
    """Corner and face values that make cos(theta) continuous over all faces that can carry them.

    Parameters
    ----------
    edge_phases : EdgePhases, of the mesh of ``polygons.triangles``
    polygons : Polygons
    """
    numbers, torn = dislocation_numbers(edge_phases, polygons.triangles)
    singular = np.zeros(len(polygons.starts), bool)
    singular[polygons.triangle_faces[(numbers != 0) | torn]] = True
    torn_count = np.bincount(polygons.triangle_faces[torn], minlength=len(singular))
    unfit = singular & ((polygons.sizes > 4) | (torn_count > 1))
    result = FacePhases(
        corner_phase=_walked_phases(edge_phases, polygons),
        corner_place=np.zeros((len(polygons.corner_vertices), 3)),
        index=np.zeros(len(singular), int),
        index_2=np.zeros(len(singular), int),
        disclination=np.zeros((len(singular), 4)),
        unfit=np.flatnonzero(unfit),
    )
    fit = singular & ~unfit
    _fill_triangles(result, edge_phases, polygons, np.flatnonzero(fit & (polygons.sizes == 3)), numbers)
    _fill_quads(result, edge_phases, polygons, np.flatnonzero(fit & (polygons.sizes == 4)))
    _fill_fans(result, edge_phases, polygons, np.flatnonzero(fit & (torn_count == 1)))
    return result


def _walked_phases(edge_phases, polygons):
    """Corner phases by a walk along each face's rim: right wherever nothing in it is singular."""
    phases = np.zeros(len(polygons.corner_vertices))
    phases[polygons.starts] = edge_phases.arguments[polygons.corner_vertices[polygons.starts]]
    sheet = np.ones(len(polygons.starts), int)
    for step in range(1, polygons.sizes.max(initial=0)):
        going = polygons.sizes > step
        corner = polygons.starts[going] + step
        change, sign = edge_phases.between(polygons.corner_vertices[corner - 1], polygons.corner_vertices[corner])
        phases[corner] = phases[corner - 1] + sheet[going] * change
        sheet[going] *= sign
    return phases


def _fill_triangles(result, edge_phases, polygons, faces, numbers):
    """Dislocations of triangle faces: the corners share out -2 pi N evenly."""
    corners = polygons.starts[faces, None] + np.arange(3)
    values, _ = edge_phases.around(polygons.corner_vertices[corners])
    number = numbers[polygons.first_triangles[faces]]
    result.corner_phase[corners] = values[:, :3] - TURN / 3 * number[:, None] * np.arange(3)
    result.corner_place[corners] = np.eye(3)
    result.index[faces] = number


def _diagonal_corners(polygons, faces):
    """(f, 4) corners A, B, C, D of quads, the first triangle being ABC and the second CDA."""
    triangles = polygons.triangle_corners[polygons.first_triangles[faces, None] + np.arange(2)]
    corners = polygons.starts[faces, None] + np.arange(4)
    shared = (corners[:, :, None, None] == triangles[:, None]).any(axis=3).all(axis=2)
    first = np.argmax(shared, axis=1)
    return polygons.starts[faces, None] + (first[:, None] + np.arange(4)) % 4


def _fill_quads(result, edge_phases, polygons, faces):
    """Dislocations of quads: -pi N on the outer edges, nothing along the diagonal."""
    corners = _diagonal_corners(polygons, faces)
    vertices = polygons.corner_vertices[corners]
    first, _ = edge_phases.around(vertices[:, [0, 1, 2]])
    second, _ = edge_phases.around(vertices[:, [0, 2, 3]])
    number = np.rint((first[:, 3] - first[:, 0]) / TURN).astype(int)
    number_2 = np.rint((second[:, 3] - second[:, 0]) / TURN).astype(int)
    a, b, c, d = first[:, 0], first[:, 1] - np.pi * number, second[:, 1], second[:, 2] - np.pi * number_2
    phases = np.column_stack([a, b, c, d])
    starts = np.take_along_axis(phases, np.argmin(corners, axis=1)[:, None], axis=1)
    result.corner_phase[corners] = phases - TURN * np.floor((starts + np.pi) / TURN)
    result.corner_place[corners] = [[0, 0, -1], [1, 0, -1], [0, 1, -1], [-1, 0, -1]]
    result.index[faces], result.index_2[faces] = number, number_2


def _fill_fans(result, edge_phases, polygons, faces):
    """Disclinations: the rim's values less the centre's, which is half of what the walk misses."""
    for size in (3, 4):
        sized = faces[polygons.sizes[faces] == size]
        corners = polygons.starts[sized, None] + np.arange(3) if size == 3 else _diagonal_corners(polygons, sized)
        values, _ = edge_phases.around(polygons.corner_vertices[corners])
        half_turns = np.rint((values[:, -1] + values[:, 0]) / TURN)
        result.disclination[sized, :size] = values[:, :-1] - np.pi * half_turns[:, None]
        result.corner_phase[corners] = np.pi * (half_turns % 2)[:, None]
        result.index[sized] = result.index_2[sized] = 0


def ell(weights):
    """lArg of Knöppel et al. 2015: 0 at the first corner, 2 pi / 3 more along each edge.

    Parameters
    ----------
    weights : (..., 3) barycentric; at the centre the value is arbitrary
    """
    a, b, c = np.moveaxis(weights, -1, 0)
    smallest = np.argmin(np.stack([c, a, b]), axis=0)
    low = np.choose(smallest, [c, a, b])
    rise = np.choose(smallest, [b - a, c - b, a - c])
    height = np.maximum(1 - 3 * low, 1e-12)
    return np.pi / 3 * (1 + 2 * smallest + rise / height)


def evaluate(phases, polygons, triangles, weights):
    """Phase at points of triangles: the formula that the shader evaluates, here for arrays.

    Parameters
    ----------
    phases : FacePhases
    polygons : Polygons
    triangles : (k,) triangle indices
    weights : (k, 3) barycentric weights of the triangles' corners

    Returns
    -------
    (k,) radians
    """
    corners = polygons.triangle_corners[triangles]
    faces = polygons.triangle_faces[triangles]
    theta = np.einsum("ki,ki->k", weights, phases.corner_phase[corners])
    place = np.einsum("ki,kix->kx", weights, phases.corner_place[corners])
    rim = phases.disclination[faces]
    is_quad = place[:, 2] < -0.5
    s, t = place[:, 0], place[:, 1]
    left = 1 - np.abs(s) - t
    first = s >= 0
    quad_weights = np.column_stack([np.where(first, left, t), np.abs(s), np.where(first, t, left)])
    b = np.where(is_quad[:, None], quad_weights, place)
    number = np.where(is_quad & ~first, phases.index_2[faces], phases.index[faces])
    turn = ell(b) + is_quad * np.pi / 3 * (b[:, 1] + 2 * b[:, 2])
    return theta + number * turn + np.where(is_quad, _quad_fan(s, t, rim), _triangle_fan(b, rim))


def _triangle_fan(b, x):
    a, b, c = b.T
    parts = [(a - c) * x[:, 0] + (b - c) * x[:, 1], (b - a) * x[:, 1] + (c - a) * x[:, 2]]
    parts.append((c - b) * x[:, 2] - (a - b) * x[:, 0])
    return np.choose(np.argmin(np.stack([c, a, b]), axis=0), parts)


def _quad_fan(s, t, x):
    along = 1 - np.abs(s) - 2 * t
    near_a = np.maximum(along, 0) * np.where(s >= 0, x[:, 0], -x[:, 0])
    outer = np.where(s >= 0, s * x[:, 1], -s * x[:, 3])
    return near_a + np.maximum(-along, 0) * x[:, 2] + outer
