# SPDX-License-Identifier: GPL-3.0-or-later
"""Continuous phases inside every face, singular ones included.

Along an edge the phase changes by sigma = angle + wrap(arg phi_j - arg phi_i - angle). The phase at a
point is

    theta = interpolated corner phase + N * ell(b) + D(b)

- In a regular face the corners' phases differ by sigma and theta is linear on each triangle.
- With a *dislocation* the sigma around a triangle sum to 2 pi N. The corners share out -2 pi N, and
  ell, which turns once around the centre and linearly along the edges (lArg of Knöppel et al. 2015),
  restores it. In a quad split along its diagonal AC, ell grows by pi along the two outer edges of a
  triangle and not at all along the diagonal, so that both triangles agree on A and C.
- A face with a *disclination* has no consistent sheet: a walk around it maps the values x -> -x + 2 pi M for lines and
  (x, y) -> (y, -x) + 2 pi (M, M') for crosses. The face is a fan around its centre, whose values are the fixed points
  of this map, multiples of pi; all corners carry them, and D interpolates the differences to them along the rim.

From face to face only cos(theta) is continuous for stripes, and for quads the pair {cos(theta_x), cos(theta_y)},
so that their product is: sheets may differ by a turn (:mod:`core.matchings`), values by 2 pi.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Generic

import numpy as np

from .defects import wrap
from .geometry import TriangleMesh
from .geometry.polygons import Polygons
from .geometry.tet_mesh import TetMesh
from .matchings import after_turns

if TYPE_CHECKING:
    from typing_extensions import TypeVar

    Mesh = TypeVar("Mesh", bound=TriangleMesh | TetMesh, default=TriangleMesh)  # before Python 3.13 without a default
else:
    from typing import TypeVar

    Mesh = TypeVar("Mesh")

TURN = 2 * np.pi


@dataclass(frozen=True)
class EdgePhases(Generic[Mesh]):
    """Phases at the vertices of a mesh and their changes along its edges, k of each.

    Attributes
    ----------
    arguments : (n, k) radians
    changes : (e, k) radians from the lower to the higher vertex, for the phases of the lower
    matchings : (e,) how the phases continue as those of the higher vertex (see :mod:`core.matchings`)
    """

    mesh: Mesh
    arguments: np.ndarray
    changes: np.ndarray
    matchings: np.ndarray

    @classmethod
    def of(cls, mesh: Mesh, phases: np.ndarray, asked: np.ndarray, matchings: np.ndarray) -> "EdgePhases[Mesh]":
        """Build from (n, k) complex phases and the (e, k) changes that the edges ask for."""
        i, j = mesh.edges.T
        arguments = np.angle(phases)
        reached = after_turns(_take_rows(arguments, j), -matchings)
        return cls(mesh, arguments, asked + wrap(reached - _take_rows(arguments, i) - asked), matchings)

    def __getstate__(self) -> dict[str, object]:
        """Without what is quickly made again: for another process."""
        return {name: value for name, value in self.__dict__.items() if not name.startswith("_")}

    @property
    def phase_count(self) -> int:
        return self.arguments.shape[1]

    @cached_property
    def dislocations(self: "EdgePhases[TriangleMesh]") -> tuple[np.ndarray, np.ndarray]:
        """The :func:`dislocation_numbers` of the triangles of the mesh."""
        return dislocation_numbers(self, self.mesh.triangles)

    def between(
        self, tails: np.ndarray, heads: np.ndarray, edges: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Compute (f, k) changes from tail to head for the phases of the tail, and (f,) the matchings on the way.

        ``edges`` are the (f,) edges between them, where they are known.
        """
        edges = self.mesh.edges_between(tails, heads) if edges is None else edges
        changes, matched = self._both_ways
        ways = edges + len(self.changes) * (tails > heads)
        return _take_rows(changes, ways), matched.take(ways)

    @cached_property
    def _both_ways(self) -> tuple[np.ndarray, np.ndarray]:
        """(2 e, k) changes and (2 e,) matchings, of all edges from the lower vertex to the higher and then back."""
        back = -after_turns(self.changes, self.matchings)
        return np.concatenate([self.changes, back]), np.concatenate([self.matchings, -self.matchings])

    def around(self, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Continue the phases of the first of (f, v) vertices along a walk around all of them.

        Returns (f, v + 1, k) phases, from the first vertex's arguments to the values on the return there,
        and (f,) the sum of the matchings: 0 where every phase returns as itself.
        """
        if isinstance(self.mesh, TriangleMesh) and corners is self.mesh.triangles:
            return self._around_triangles
        return self._walk(corners, [None] * corners.shape[1])

    @cached_property
    def _around_triangles(self) -> tuple[np.ndarray, np.ndarray]:
        assert isinstance(self.mesh, TriangleMesh)
        values, turns = self._walk(self.mesh.triangles, list(self.mesh.triangle_edges.T))
        values.flags.writeable = turns.flags.writeable = False
        return values, turns

    def _walk(self, corners: np.ndarray, edges: Sequence[np.ndarray | None]) -> tuple[np.ndarray, np.ndarray]:
        """:meth:`around` (f, v) corners, along edges where they are known."""
        values = [_take_rows(self.arguments, corners[:, 0])]
        turns = np.zeros(len(corners), int)
        for step, edge in enumerate(edges):
            change, matched = self.between(corners[:, step], corners[:, (step + 1) % corners.shape[1]], edge)
            values.append(values[-1] + after_turns(change, -turns))
            turns = turns + matched
        return np.stack(values, axis=1), turns % (2 * self.phase_count)


def _take_rows(values: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Take rows of (n, k) values; an index takes six times as long for one column."""
    return values.ravel().take(rows)[:, None] if values.shape[1] == 1 else values.take(rows, axis=0)


def dislocation_numbers(
    edge_phases: EdgePhases[TriangleMesh] | EdgePhases[TetMesh], triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the (f, k) integers N for the phases of each triangle's first corner, 0 where it has a disclination, and
    (f,) bool whether it has one."""
    values, turns = edge_phases.around(triangles)
    numbers = np.rint((values[:, 3] - values[:, 0]) / TURN).astype(int)
    return np.where(turns[:, None] == 0, numbers, 0), turns != 0


def disclination_centres(values: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Compute (f, k) phases at the centres of disclinations, fixed by the walk around them: multiples of pi.

    ``values`` and ``turns``, not 0, are those of :meth:`EdgePhases.around`.
    """
    count = values.shape[2]
    own = after_turns(values[:, 0], -turns)
    missed = TURN * np.rint((values[:, -1] - own) / TURN)
    # Solve p = A^-g p + missed for every g.
    powers = np.stack([after_turns(np.eye(count), -np.full(count, g)).T for g in range(2 * count)])
    inverses = np.zeros_like(powers)
    inverses[1:] = np.linalg.inv(np.eye(count) - powers[1:])
    return np.einsum("fab,fb->fa", inverses[turns], missed)


@dataclass(frozen=True)
class FacePhases:
    """Values from which a shader or a sampler evaluates one phase anywhere (see :func:`evaluate`).

    Attributes
    ----------
    corner_phase : (c,) radians, the first corner of a face without disclination in [-pi, pi]
    corner_place : (c, 3) zero in regular faces; in a singular triangle the corner weights; in a
        singular quad ABCD split along AC (s, t, -1) with s = (0, 1, 0, -1) and t = (0, 0, 1, 0)
    index, index_2 : (p,) dislocation numbers of a face's first and second triangle
    disclination : (p, 4) values along the rim less the centre's value; zero without a disclination
    closing : (p,) the same at the first corner of the rim, where the walk returns to it
    unfit : indices of the faces that have to be split into triangles
    """

    corner_phase: np.ndarray
    corner_place: np.ndarray
    index: np.ndarray
    index_2: np.ndarray
    disclination: np.ndarray
    closing: np.ndarray
    unfit: np.ndarray


def face_phases(edge_phases: EdgePhases, polygons: Polygons) -> tuple[FacePhases, ...]:
    """Compute corner and face values that make the pattern continuous over all faces that can carry them.

    The mesh is that of ``polygons.triangles``. Returns k records, for the phases of each face's first corner.
    """
    is_mesh = np.array_equal(polygons.triangles, edge_phases.mesh.triangles)
    numbers, torn = edge_phases.dislocations if is_mesh else dislocation_numbers(edge_phases, polygons.triangles)
    singular = np.zeros(len(polygons.starts), bool)
    singular[polygons.triangle_faces[numbers.any(axis=1) | torn]] = True
    torn_count = np.bincount(polygons.triangle_faces[torn], minlength=len(singular))
    unfit = polygons.at_faces(singular & ((polygons.sizes > 4) | (torn_count > 1)))
    faces, count = len(singular), edge_phases.phase_count
    result = FacePhases(
        corner_phase=_walked_phases(edge_phases, polygons),
        corner_place=np.zeros((len(polygons.corner_vertices), 3)),
        index=np.zeros((faces, count), int),
        index_2=np.zeros((faces, count), int),
        disclination=np.zeros((faces, 4, count)),
        closing=np.zeros((faces, count)),
        unfit=np.flatnonzero(unfit),
    )
    fit = singular & ~unfit
    _fill_triangles(result, edge_phases, polygons, np.flatnonzero(fit & (polygons.sizes == 3)))
    _fill_quads(result, edge_phases, polygons, np.flatnonzero(fit & (polygons.sizes == 4)))
    _fill_fans(result, edge_phases, polygons, np.flatnonzero(fit & (torn_count == 1)))
    at_corners = {name: polygons.at_corners(getattr(result, name)) for name in ("corner_phase", "corner_place")}
    of_faces = ("index", "index_2", "disclination", "closing")
    result = replace(result, **at_corners, **{name: polygons.at_faces(getattr(result, name)) for name in of_faces})
    return tuple(
        replace(result, **{name: getattr(result, name)[..., phase] for name in ("corner_phase", *of_faces)})
        for phase in range(count)
    )


def _walked_phases(edge_phases: EdgePhases, polygons: Polygons) -> np.ndarray:
    """Compute (c, k) corner phases by a walk along each face's rim: correct for faces without singularity.

    Faces without triangles get the phases of their vertices.
    """
    phases = np.zeros((len(polygons.corner_vertices), edge_phases.phase_count))
    phases[polygons.starts] = edge_phases.arguments[polygons.corner_vertices[polygons.starts]]
    drawn = polygons.drawn
    at_vertices = ~drawn[polygons.corner_faces]
    phases[at_vertices] = edge_phases.arguments[polygons.corner_vertices[at_vertices]]
    turns, halves, mesh = np.zeros(len(polygons.starts), int), polygons.rim_half_edges, edge_phases.mesh
    known = np.array_equal(polygons.triangles, mesh.triangles)
    for going, corner in polygons.rim_steps:
        before, after = polygons.corner_vertices[corner - 1], polygons.corner_vertices[corner]
        half = halves[corner - 1]
        edges = mesh.triangle_edges.ravel()[half] if known and half.min(initial=0) >= 0 else None
        change, matched = edge_phases.between(before, after, edges)
        phases[corner] = phases[corner - 1] + after_turns(change, -turns[going])
        turns[going] += matched
    return phases


def _fill_triangles(result: FacePhases, edge_phases: EdgePhases, polygons: Polygons, faces: np.ndarray) -> None:
    """Fill in dislocations of triangle faces: the corners share -2 pi N evenly."""
    corners = polygons.starts[faces, None] + np.arange(3)
    values, _ = edge_phases.around(polygons.corner_vertices[corners])
    number = np.rint((values[:, 3] - values[:, 0]) / TURN).astype(int)
    result.corner_phase[corners] = values[:, :3] - TURN / 3 * number[:, None] * np.arange(3)[:, None]
    result.corner_place[corners] = np.eye(3)
    result.index[faces] = number


def _diagonal_corners(polygons: Polygons, faces: np.ndarray) -> np.ndarray:
    """Find the (f, 4) corners A, B, C, D of quads with first triangle ABC and second CDA."""
    triangles = polygons.triangle_corners[polygons.first_triangles[faces, None] + np.arange(2)]
    corners = polygons.starts[faces, None] + np.arange(4)
    shared = (corners[:, :, None, None] == triangles[:, None]).any(axis=3).all(axis=2)
    first = np.argmax(shared, axis=1)
    return polygons.starts[faces, None] + (first[:, None] + np.arange(4)) % 4


def _fill_quads(result: FacePhases, edge_phases: EdgePhases, polygons: Polygons, faces: np.ndarray) -> None:
    """Fill in dislocations of quads: -pi N on the outer edges, nothing along the diagonal."""
    corners = _diagonal_corners(polygons, faces)
    vertices = polygons.corner_vertices[corners]
    first, _ = edge_phases.around(vertices[:, [0, 1, 2]])
    second, _ = edge_phases.around(vertices[:, [0, 2, 3]])
    number = np.rint((first[:, 3] - first[:, 0]) / TURN).astype(int)
    number_2 = np.rint((second[:, 3] - second[:, 0]) / TURN).astype(int)
    a, b, c, d = first[:, 0], first[:, 1] - np.pi * number, second[:, 1], second[:, 2] - np.pi * number_2
    phases = np.stack([a, b, c, d], axis=1)
    starts = phases[np.arange(len(faces)), np.argmin(corners, axis=1)][:, None]
    result.corner_phase[corners] = phases - TURN * np.floor((starts + np.pi) / TURN)
    result.corner_place[corners] = [[0, 0, -1], [1, 0, -1], [0, 1, -1], [-1, 0, -1]]
    result.index[faces], result.index_2[faces] = number, number_2


def _fill_fans(result: FacePhases, edge_phases: EdgePhases, polygons: Polygons, faces: np.ndarray) -> None:
    """Fill in disclinations: the rim's values less the centre's, fixed by the walk around it."""
    for size in (3, 4):
        sized = faces[polygons.sizes[faces] == size]
        corners = polygons.starts[sized, None] + np.arange(3) if size == 3 else _diagonal_corners(polygons, sized)
        values, turns = edge_phases.around(polygons.corner_vertices[corners])
        centres = disclination_centres(values, turns)
        result.disclination[sized, :size] = values[:, :-1] - centres[:, None]
        result.closing[sized] = values[:, -1] - centres
        result.corner_phase[corners] = np.pi * (np.rint(centres / np.pi) % 2)[:, None]
        result.index[sized] = result.index_2[sized] = 0


def ell(weights: np.ndarray) -> np.ndarray:
    """Evaluate lArg of Knöppel et al. 2015 at (..., 3) barycentric weights: 0 at the first corner, 2 pi / 3 more along
    each edge, arbitrary at the centre."""
    a, b, c = np.moveaxis(weights, -1, 0)
    smallest = np.argmin(np.stack([c, a, b]), axis=0)
    low = np.choose(smallest, [c, a, b])
    rise = np.choose(smallest, [b - a, c - b, a - c])
    height = np.maximum(1 - 3 * low, 1e-12)
    return np.pi / 3 * (1 + 2 * smallest + rise / height)


def evaluate(phases: FacePhases, polygons: Polygons, triangles: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Evaluate the phase, (k,) radians, at points of (k,) triangles by the shader's formula.

    ``weights`` are the (k, 3) barycentric weights of the triangles' corners.
    """
    corners = polygons.triangle_corners[triangles]
    faces = polygons.triangle_faces[triangles]
    theta = np.einsum("ki,ki->k", weights, phases.corner_phase[corners])
    place = np.einsum("ki,kix->kx", weights, phases.corner_place[corners])
    rim = np.column_stack([phases.disclination[faces], phases.closing[faces]])
    is_quad = place[:, 2] < -0.5
    s, t = place[:, 0], place[:, 1]
    left = 1 - np.abs(s) - t
    first = s >= 0
    quad_weights = np.column_stack([np.where(first, left, t), np.abs(s), np.where(first, t, left)])
    b = np.where(is_quad[:, None], quad_weights, place)
    number = np.where(is_quad & ~first, phases.index_2[faces], phases.index[faces])
    turn = ell(b) + is_quad * np.pi / 3 * (b[:, 1] + 2 * b[:, 2])
    return theta + number * turn + np.where(is_quad, _quad_fan(s, t, rim), _triangle_fan(b, rim))


def _triangle_fan(b: np.ndarray, x: np.ndarray) -> np.ndarray:
    a, b, c = b.T
    parts = [(a - c) * x[:, 0] + (b - c) * x[:, 1], (b - a) * x[:, 1] + (c - a) * x[:, 2]]
    parts.append((c - b) * x[:, 2] + (a - b) * x[:, 4])
    return np.choose(np.argmin(np.stack([c, a, b]), axis=0), parts)


def _quad_fan(s: np.ndarray, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    along = 1 - np.abs(s) - 2 * t
    near_a = np.maximum(along, 0) * np.where(s >= 0, x[:, 0], x[:, 4])
    outer = np.where(s >= 0, s * x[:, 1], -s * x[:, 3])
    return near_a + np.maximum(-along, 0) * x[:, 2] + outer
