# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces that are no quads made quads: a pair of odd ones and the quads between them become one polygon, which is cut
into quads anew; so does every larger even face.

A polygon of 2 k corners always falls into k - 1 quads; of all ways the one with the corners nearest to right angles is
taken. An edge that is to stay is halved where the way between two odd faces crosses it: its two sides become polygons
of their own. So is an edge of the boundary where an odd face has no other one, or none as near.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from heapq import heappop, heappush
from itertools import count

import numpy as np

from ....geometry.barycentric import barycentric
from ....geometry.nearest import NearestTriangles

# Most corners of a polygon that is cut anew: ways to cut it grow with their fourth power.
MOST_CORNERS = 24
# What halving an edge that stays costs, in faces; on the boundary, where it serves one odd face alone, twice as much.
HALVING = 6
# Edges shorter than this part of the mean one are not halved: their halves would be of no length.
SHORTEST = 0.05
# What a corner that is turned over costs, in squares of right angles.
TURNED = 40.0


@dataclass
class Faces:
    """Faces as lists, by their numbers, which faces are at each way along an edge, and which edges stay; places and
    normals of the vertices."""

    corners: dict[int, list[int]]
    left: dict[tuple[int, int], int]
    numbers: Iterator[int]
    kept: set[tuple[int, int]]
    vertices: np.ndarray
    normals: np.ndarray

    @classmethod
    def of(cls, quads, normals, keep):
        faces = np.split(quads.corner_vertices, quads.starts[1:])
        result = cls({}, {}, count(), set(map(edge_of, keep)), quads.vertices, normals)
        for corners in faces:
            result.add(corners.tolist())
        return result

    def add(self, corners):
        number = next(self.numbers)
        self.corners[number] = corners
        for way in _ways(corners):
            self.left[way] = number
        return number

    def remove(self, number):
        for way in _ways(self.corners.pop(number)):
            del self.left[way]

    def put_on(self, quads):
        """The :class:`QuadMesh` of these faces on the vertices of another one."""
        faces = list(self.corners.values())
        return quads.with_faces(np.concatenate(faces), np.array([len(corners) for corners in faces]))

    def beside(self, number):
        """The ways along the edges of a face, and the face on the other side of each, None beyond the boundary."""
        return [((a, b), self.left.get((b, a))) for a, b in _ways(self.corners[number])]

    def length(self, edge):
        first, second = self.vertices[list(edge)]
        return np.linalg.norm(second - first)

    def halve(self, edge):
        """The number of a new vertex in the middle of an edge, whose halves stay."""
        new = len(self.vertices)
        ends = list(edge)
        self.vertices = np.vstack([self.vertices, self.vertices[ends].mean(axis=0)])
        self.normals = np.vstack([self.normals, self.normals[ends].sum(axis=0)])
        self.kept |= {(end, new) for end in ends}
        return new


def edge_of(pair):
    first, second = sorted(pair)
    return first, second


def _ways(corners):
    return zip(corners, [*corners[1:], corners[0]], strict=True)


def all_quads(quads, mesh, keep=()):
    """The :class:`QuadMesh` with quads instead of other faces, as far as its faces allow.

    Parameters
    ----------
    quads : QuadMesh
    mesh : TriangleMesh that it is on
    keep : (k, 2) vertices of edges that stay, or whose halves do
    """
    if (quads.sizes == 4).all():
        return quads
    faces = Faces.of(quads, mesh.face_normals[quads.triangles], np.asarray(keep, int).reshape(-1, 2).tolist())
    ends = quads.vertices[quads.edges[0]]
    shortest = SHORTEST * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).mean()
    odd = sorted(number for number, corners in faces.corners.items() if len(corners) % 2)
    while odd:
        parts = _strip(faces, odd[0], set(odd[1:]), shortest)
        done = {number for part in parts for number in part.numbers} if _cut_polygons_again(faces, parts) else odd[:1]
        odd = [number for number in odd if number not in done]
    for number in [n for n, corners in faces.corners.items() if len(corners) > 4 and len(corners) % 2 == 0]:
        _cut_polygons_again(faces, [_Part((number,), faces.corners[number])])
    _join_doublets(quads, faces)
    return faces.put_on(_with_vertices(quads, mesh, faces.vertices[len(quads.vertices) :]))


def _with_vertices(quads, mesh, places):
    """The quad mesh with further vertices, which are put onto the surface."""
    if len(places) == 0:
        return quads
    places, triangles = NearestTriangles(mesh.vertices, mesh.triangles).nearest(places)
    return replace(
        quads,
        vertices=np.concatenate([quads.vertices, places]),
        triangles=np.concatenate([quads.triangles, triangles]),
        weights=np.concatenate([quads.weights, barycentric(mesh, triangles, places)]),
    )


@dataclass(frozen=True)
class _Part:
    """Faces that are to be cut anew, and the polygon of them all; a corner that is a pair is the middle of an edge."""

    numbers: tuple[int, ...]
    polygon: list


def _strip(faces, first, targets, shortest):
    """The :class:`_Part` s of the way from an odd face to the nearest other one or the boundary, one on each side of
    the edges that stay; none without a way whose polygons pass no vertex twice. Edges shorter than ``shortest`` are not
    halved."""
    begin: tuple[_Part, ...] = (_Part((first,), faces.corners[first]),)
    waiting, done = [(0, 0, first, begin)], set()
    order = count(1)
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
            middle, corners = edge_of((a, b)), faces.corners.get(other)
            if other is None or middle in faces.kept:
                if faces.length(middle) < shortest:
                    continue
                polygons = [join_faces(last.polygon, [b, a, middle], a, b)]
                polygons += [] if other is None else [join_faces(corners, [a, b, middle], b, a)]
                numbers, step = [last.numbers, (other,)], 1 + HALVING * (2 if other is None else 1)
            else:
                polygons, numbers, step = [join_faces(last.polygon, corners, a, b)], [(*last.numbers, other)], 1
            if None not in polygons:
                onwards = (*before, *map(_Part, numbers, polygons))
                heappush(waiting, (cost + step, next(order), other, onwards))
    return ()


def join_faces(polygon, corners, a, b):
    """The polygon with another face beyond its way from a to b, None where they meet elsewhere, too."""
    others = [corner for corner in corners if corner not in (a, b)]
    if len(polygon) + len(others) > MOST_CORNERS or not set(others).isdisjoint(polygon):
        return None
    at = corners.index(a)
    after = [corners[(at + k) % len(corners)] for k in range(1, len(corners) - 1)]
    place = polygon.index(a)
    if polygon[(place + 1) % len(polygon)] != b:
        return None
    return [*polygon[: place + 1], *after, *polygon[place + 1 :]]


def _cut_polygons_again(faces, parts):
    """Replace faces by the best quads of their polygons, and say whether that was done: not where all would double an
    edge."""
    halves = {corner: faces.halve(corner) for part in parts for corner in part.polygon if isinstance(corner, tuple)}
    polygons = [[halves.get(corner, corner) for corner in part.polygon] for part in parts]
    cuts = [_cut_polygon(faces, part.numbers, polygon) for part, polygon in zip(parts, polygons, strict=True)]
    if not parts or None in cuts:
        return False
    quads = [[polygon[k] for k in quad] for polygon, cut in zip(polygons, cuts, strict=True) for quad in cut]
    ways = [way for quad in quads for way in _ways(quad)]
    if len(set(ways)) < len(ways):
        return False
    for number in [number for part in parts for number in part.numbers]:
        faces.remove(number)
    for quad in quads:
        faces.add(quad)
    return True


def _cut_polygon(faces, numbers, polygon):
    """The best quads of a polygon of faces, as places on it, None where all would double an edge."""
    size = len(polygon)
    if len(set(polygon)) < size or size > MOST_CORNERS:
        return None
    inside = {way for number in numbers for way in _ways(faces.corners[number])}
    points, up = faces.vertices[polygon], faces.normals[polygon]
    taken = [[(a, b) in faces.left and (a, b) not in inside for b in polygon] for a in polygon]

    @cache
    def corner(before, at, after):
        ahead, behind = points[after] - points[at], points[before] - points[at]
        cross = np.cross(ahead, behind)
        angle = np.arctan2(np.linalg.norm(cross), ahead @ behind)
        return (angle / (np.pi / 2) - 1) ** 2 + TURNED * (cross @ up[at] <= 0)

    @cache
    def best(i, j):
        """Cost and quads of the part from corner i to j, beyond the way from j to i."""
        if j - i == 1:
            return 0.0, ()
        if (j - i) % 2 == 0 or ((i, j) != (0, size - 1) and (taken[i][j] or taken[j][i])):
            return np.inf, ()
        found = np.inf, ()
        for k in range(i + 1, j, 2):
            for m in range(k + 1, j, 2):
                parts = best(i, k), best(k, m), best(m, j)
                cost = sum(part[0] for part in parts)
                if cost < found[0]:
                    cost += corner(j, i, k) + corner(i, k, m) + corner(k, m, j) + corner(m, j, i)
                if cost < found[0]:
                    found = cost, (*parts[0][1], *parts[1][1], *parts[2][1], (i, k, m, j))
        return found

    cost, cut = best(0, size - 1)
    return cut if np.isfinite(cost) else None


def _join_doublets(quads, faces):
    """Two quads that share two edges in a row, whose middle belongs to no other face, become one unless the edges
    stay."""
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
