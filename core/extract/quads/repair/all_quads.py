# SPDX-License-Identifier: GPL-3.0-or-later
"""Replaces all other faces of a quad mesh by quads.

Two odd faces and the quads between them are merged into one polygon, which is divided into quads again; so is every
larger even face. A polygon with 2 k corners can always be divided into k - 1 quads; of all divisions, the one with the
corners nearest to right angles is used. Where the path between two odd faces crosses an edge that must stay, the edge
is halved and each side becomes a polygon. An edge of the boundary is halved if no other odd face is as near.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from heapq import heappop, heappush
from itertools import count
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ....geometry import TriangleMesh
from ....geometry.barycentric import barycentric
from ....unit_vectors import cross
from ..trace.quad_mesh import QuadMesh

# Most corners of a polygon that is divided again: the work grows with their fourth power.
MOST_CORNERS = 24
# Cost of halving an edge that stays, in faces; twice as much on the boundary, where it serves one odd face only.
HALVING = 6
# Edges shorter than this part of the mean edge are not halved.
SHORTEST = 0.05
# Cost of a corner that is turned over, in squares of right angles.
TURNED = 40.0

Edge = tuple[int, int]
# A corner of a polygon: a vertex, or the middle of an edge.
_Corner = TypeVar("_Corner", int, int | Edge)
_Cut = tuple[tuple[int, int, int, int], ...]


@dataclass
class Faces:
    """Faces that can be exchanged, on vertices with normals.

    Attributes
    ----------
    corners : corners of each face by its number
    left : the face to the left of each half-edge
    numbers : numbers for further faces
    kept : edges that stay
    vertices, normals : (n, 3)
    halved : for each new vertex, the ends of the edge that it halves
    apart : vertices that no new edge may join to one another
    """

    corners: dict[int, list[int]]
    left: dict[Edge, int]
    numbers: Iterator[int]
    kept: set[Edge]
    vertices: np.ndarray
    normals: np.ndarray
    apart: set[int]
    halved: list[Edge] = field(default_factory=list)

    @classmethod
    def of(cls, quads: QuadMesh, normals: np.ndarray, keep: ArrayLike, apart: ArrayLike = ()) -> "Faces":
        edges = np.asarray(keep, int).reshape(-1, 2).tolist()
        alone = set(np.asarray(apart, int).tolist())
        result = cls({}, {}, count(), set(map(edge_of, edges)), quads.vertices, normals, alone)
        for corners in np.split(quads.corner_vertices, quads.starts[1:]):
            result.add(corners.tolist())
        return result

    def add(self, corners: list[int]) -> int:
        number = next(self.numbers)
        self.corners[number] = corners
        for way in _half_edges(corners):
            self.left[way] = number
        return number

    def remove(self, number: int) -> None:
        for way in _half_edges(self.corners.pop(number)):
            del self.left[way]

    def put_on(self, quads: QuadMesh) -> QuadMesh:
        """The quad mesh of these faces on the vertices of another one."""
        faces = list(self.corners.values())
        return quads.with_faces(np.concatenate(faces), np.array([len(corners) for corners in faces]))

    def beside(self, number: int) -> list[tuple[Edge, int | None]]:
        """The half-edges of a face, and the face on the other side of each, None beyond the boundary."""
        return [((a, b), self.left.get((b, a))) for a, b in _half_edges(self.corners[number])]

    def length(self, edge: Edge) -> float:
        first, second = self.vertices[list(edge)]
        return float(np.linalg.norm(second - first))

    def halve(self, edge: Edge) -> int:
        """Halve an edge, so that both halves stay; the number of the new vertex."""
        new = len(self.vertices)
        self.halved.append(edge)
        ends = list(edge)
        self.vertices = np.vstack([self.vertices, self.vertices[ends].mean(axis=0)])
        self.normals = np.vstack([self.normals, self.normals[ends].sum(axis=0)])
        self.kept |= {(end, new) for end in ends}
        if self.apart.issuperset(edge):
            self.apart.add(new)
        return new


def edge_of(pair: Iterable[int]) -> Edge:
    """The edge between two vertices, the lower one first."""
    first, second = sorted(pair)
    return first, second


def _half_edges(corners: Sequence[int]) -> Iterator[Edge]:
    return zip(corners, [*corners[1:], corners[0]], strict=True)


def all_quads(
    quads: QuadMesh, mesh: TriangleMesh, keep: ArrayLike = (), apart: ArrayLike = ()
) -> tuple[QuadMesh, np.ndarray]:
    """The quad mesh on a surface with quads instead of other faces, as far as possible.

    The (k, 2) edges to keep stay, whole or halved, and no new edge joins two of the vertices ``apart``. Also returns
    the (n, 2) given vertices that each vertex comes from: the ends of the edge that it halves, or twice itself.
    """
    origins = np.repeat(np.arange(len(quads.vertices))[:, None], 2, axis=1)
    if (quads.sizes == 4).all():
        return quads, origins
    faces = Faces.of(quads, mesh.face_normals[quads.triangles], keep, apart)
    shortest = SHORTEST * quads.edge_lengths.mean()
    odd = sorted(number for number, corners in faces.corners.items() if len(corners) % 2)
    while odd:
        parts = _strip(faces, odd[0], set(odd[1:]), shortest)
        done = {number for part in parts for number in part.numbers} if _cut_polygons_again(faces, parts) else odd[:1]
        odd = [number for number in odd if number not in done]
    for number in [n for n, corners in faces.corners.items() if len(corners) > 4 and len(corners) % 2 == 0]:
        _cut_polygons_again(faces, [_Part((number,), faces.corners[number])])
    _join_doublets(quads, faces)
    new = slice(len(quads.vertices), None)
    halved = np.array(faces.halved, int).reshape(-1, 2)
    result = faces.put_on(with_vertices(quads, mesh, faces.vertices[new], faces.normals[new], faces.vertices[halved]))
    used = np.unique([corner for corners in faces.corners.values() for corner in corners])
    return result, np.concatenate([origins, halved])[used]


def with_vertices(
    quads: QuadMesh, mesh: TriangleMesh, middles: np.ndarray, normals: np.ndarray, ends: np.ndarray
) -> QuadMesh:
    """The quad mesh with further vertices, projected onto the surface where it looks along (k, 3) normals.

    Where one of the (k, 2, 3) ends of their edge would be there already, as at corners, they go to the nearest place.
    """
    if len(middles) == 0:
        return quads
    places, triangles = mesh.finder.nearest_facing(middles, normals)
    apart = np.linalg.norm(places[:, None] - ends, axis=2).min(axis=1)
    meets = apart < SHORTEST * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    places[meets], triangles[meets] = mesh.finder.nearest(middles[meets])
    return replace(
        quads,
        vertices=np.concatenate([quads.vertices, places]),
        triangles=np.concatenate([quads.triangles, triangles]),
        weights=np.concatenate([quads.weights, barycentric(mesh, triangles, places)]),
    )


@dataclass(frozen=True)
class _Part:
    """Faces that are to be divided again, and the polygon that they form; a pair stands for the middle of an edge."""

    numbers: tuple[int, ...]
    polygon: Sequence[int | Edge]


def _strip(faces: Faces, first: int, targets: set[int], shortest: float) -> tuple[_Part, ...]:
    """The parts of the path from an odd face to the nearest other one or the boundary, separated by edges that stay.

    Empty if every path has a polygon that passes a vertex twice. Edges shorter than ``shortest`` are not halved.
    """
    start: tuple[_Part, ...] = (_Part((first,), faces.corners[first]),)
    waiting: list[tuple[int, int, int | None, tuple[_Part, ...]]] = [(0, 0, first, start)]
    done, order = set(), count(1)
    while waiting:
        cost, _, number, parts = heappop(waiting)
        if number in targets or number is None:
            return parts
        if number in done:
            continue
        done.add(number)
        *before, last = parts
        passed = {n for part in parts for n in part.numbers}
        for (a, b), other in faces.beside(number):
            if other in passed or other in done:
                continue
            middle = edge_of((a, b))
            polygons: list[list[int | Edge] | None]
            if other is None or middle in faces.kept:
                if faces.length(middle) < shortest:
                    continue
                polygons, numbers = [join_faces(last.polygon, [b, a, middle], a, b)], [last.numbers]
                if other is not None:
                    polygons.append(join_faces(faces.corners[other], [a, b, middle], b, a))
                    numbers.append((other,))
                step = 1 + HALVING * (2 if other is None else 1)
            else:
                polygons, numbers = [join_faces(last.polygon, faces.corners[other], a, b)], [(*last.numbers, other)]
                step = 1
            onwards = [_Part(n, polygon) for n, polygon in zip(numbers, polygons, strict=True) if polygon is not None]
            if len(onwards) == len(polygons):
                heappush(waiting, (cost + step, next(order), other, (*before, *onwards)))
    return ()


def join_faces(polygon: Sequence[_Corner], corners: Sequence[_Corner], a: int, b: int) -> list[_Corner] | None:
    """The polygon merged with the face across its half-edge from a to b; None where they meet elsewhere, too."""
    others = [corner for corner in corners if corner not in (a, b)]
    if len(polygon) + len(others) > MOST_CORNERS or not set(others).isdisjoint(polygon):
        return None
    at = corners.index(a)
    after = [corners[(at + k) % len(corners)] for k in range(1, len(corners) - 1)]
    place = polygon.index(a)
    if polygon[(place + 1) % len(polygon)] != b:
        return None
    return list(polygon[: place + 1]) + after + list(polygon[place + 1 :])


def _cut_polygons_again(faces: Faces, parts: Sequence[_Part]) -> bool:
    """Replace faces by the best quads of their polygons; False, without a change, if an edge would be doubled."""
    halves = {corner: faces.halve(corner) for part in parts for corner in part.polygon if isinstance(corner, tuple)}
    polygons = [[halves[c] if isinstance(c, tuple) else c for c in part.polygon] for part in parts]
    cuts = [_cut_polygon(faces, part.numbers, polygon) for part, polygon in zip(parts, polygons, strict=True)]
    if not parts or None in cuts:
        return False
    quads = [[polygon[k] for k in quad] for polygon, cut in zip(polygons, cuts, strict=True) for quad in cut or ()]
    ways = [way for quad in quads for way in _half_edges(quad)]
    if len(set(ways)) < len(ways):
        return False
    for number in [number for part in parts for number in part.numbers]:
        faces.remove(number)
    for quad in quads:
        faces.add(quad)
    return True


def _cut_polygon(faces: Faces, numbers: Sequence[int], polygon: list[int]) -> _Cut | None:
    """The best quads of a polygon of faces, as indices of its corners; None where an edge would be doubled."""
    size = len(polygon)
    if len(set(polygon)) < size or size > MOST_CORNERS:
        return None
    inside = {way for number in numbers for way in _half_edges(faces.corners[number])}
    points, up = faces.vertices[polygon], faces.normals[polygon]
    taken = [
        [({a, b} <= faces.apart or (a, b) in faces.left) and (a, b) not in inside for b in polygon] for a in polygon
    ]

    # Costs by the corners before, at and after.
    away = points[:, None] - points
    across = cross(away.swapaxes(0, 1)[None], away[:, :, None])
    angles = np.arctan2(np.linalg.norm(across, axis=3), np.einsum("bax,cax->bac", away, away))
    corners = (angles / (np.pi / 2) - 1) ** 2 + TURNED * (np.einsum("bacx,ax->bac", across, up) <= 0)

    @cache
    def best(i: int, j: int) -> tuple[float, _Cut]:
        """Cost and quads, by corners, of the part of the polygon from corner i to corner j, closed by the edge (i, j).

        The cost is infinite where that part cannot be divided, or the edge would be doubled.
        """
        if j - i == 1:
            return 0.0, ()
        if (j - i) % 2 == 0 or ((i, j) != (0, size - 1) and (taken[i][j] or taken[j][i])):
            return np.inf, ()
        found: tuple[float, _Cut] = (np.inf, ())
        for k in range(i + 1, j, 2):
            for m in range(k + 1, j, 2):
                parts = best(i, k), best(k, m), best(m, j)
                cost = sum(part[0] for part in parts)
                if cost < found[0]:
                    cost += float(corners[[j, i, k, m], [i, k, m, j], [k, m, j, i]].sum())
                if cost < found[0]:
                    found = cost, (*parts[0][1], *parts[1][1], *parts[2][1], (i, k, m, j))
        return found

    cost, cut = best(0, size - 1)
    return cut if np.isfinite(cost) else None


def _join_doublets(quads: QuadMesh, faces: Faces) -> None:
    """Merge two quads that share two consecutive edges and the only faces at the vertex between, unless edges stay."""
    edges, counts = quads.edges
    stays = set(edges[counts == 1].ravel().tolist()) | {vertex for edge in faces.kept for vertex in edge}
    around: dict[int, set[int]] = {}
    for number, corners in faces.corners.items():
        for corner in corners:
            around.setdefault(corner, set()).add(number)
    waiting = [vertex for vertex, numbers in around.items() if len(numbers) == 2 and vertex not in stays]
    while waiting:
        vertex = waiting.pop()
        numbers = around[vertex]
        if len(numbers) != 2:
            continue
        first, second = (faces.corners[number] for number in numbers)
        if len(first) != 4 or len(second) != 4 or len(set(first) | set(second)) != 5:
            continue
        place = first.index(vertex)
        other = next(corner for corner in second if corner not in first)
        joined = [*first[:place], other, *first[place + 1 :]]
        for number in tuple(numbers):
            for corner in faces.corners[number]:
                around[corner].discard(number)
            faces.remove(number)
        new = faces.add(joined)
        for corner in joined:
            around[corner].add(new)
        waiting += [corner for corner in joined if len(around[corner]) == 2 and corner not in stays]
