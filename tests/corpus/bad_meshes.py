# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that people have and nobody means to have: (n, 3) vertices and lists of faces, by what is wrong with them."""

import numpy as np

from ..core.meshes import grid_quads, square_points, torus_points
from .makers import boxes, fans, hourglass, klein_bottle, moebius_strip


def grid(columns=6):
    """A flat square of quads."""
    return square_points(columns), grid_quads(columns, columns).tolist()


def torus(around=12, across=8):
    """A torus of quads."""
    return torus_points(2, 1, around, across), grid_quads(around, across, True, True).tolist()


def fans_around(count):
    """So many sheets of quads that share one line of edges, evenly around it."""
    return fans(4, np.arange(count) * 360 / count)


def ball(rings=6, segments=8, radius=1.0):
    """A sphere of quads and two fans of triangles."""
    polar, turn = np.linspace(0, np.pi, rings + 1)[1:-1], np.arange(segments) * 2 * np.pi / segments
    t, p = (a.ravel() for a in np.meshgrid(polar, turn, indexing="ij"))
    points = np.column_stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)])
    points = radius * np.vstack([points, [[0, 0, 1], [0, 0, -1]]])
    top, bottom, faces = len(points) - 2, len(points) - 1, []
    for k in range(segments):
        after = (k + 1) % segments
        faces.append([top, k, after])
        for ring in range(rings - 2):
            here, there = ring * segments, (ring + 1) * segments
            faces.append([here + k, there + k, there + after, here + after])
        faces.append([bottom, (rings - 2) * segments + after, (rings - 2) * segments + k])
    return points, faces


def box(size=(1.0, 1.0, 1.0)):
    points = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) * size
    return points, [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def joined(*meshes):
    """Several meshes as one, where they are."""
    points, faces, count = [], [], 0
    for vertices, some in meshes:
        points.append(vertices)
        faces += [[count + v for v in face] for face in some]
        count += len(vertices)
    return np.vstack(points), faces


def moved(mesh, *offset):
    return mesh[0] + np.array(offset, float), mesh[1]


def scaled(mesh, *factors):
    return mesh[0] * np.array(factors, float), mesh[1]


def with_place(mesh, vertex, place):
    points = mesh[0].copy()
    points[vertex] = place
    return points, mesh[1]


def with_faces(mesh, *faces):
    return mesh[0], [*mesh[1], *(list(face) for face in faces)]


def with_flipped(mesh, share):
    return mesh[0], [face[::-1] if k % share == 0 else face for k, face in enumerate(mesh[1])]


def triangulated(mesh):
    return mesh[0], [[face[0], face[k], face[k + 1]] for face in mesh[1] for k in range(1, len(face) - 1)]


def caps_at_a_vertex(count):
    """Caps that share one vertex."""
    points, faces = [np.zeros((1, 3))], []
    for cap in range(count):
        turn = np.arange(6) * np.pi / 3
        axis = 2 * np.pi * cap / count
        ring = np.column_stack([1 + 0 * turn, 0.3 * np.cos(turn), 0.3 * np.sin(turn)])
        turned = ring @ np.array([[np.cos(axis), np.sin(axis), 0], [-np.sin(axis), np.cos(axis), 0], [0, 0, 1]])
        start = 1 + 6 * cap
        points.append(turned)
        faces += [[0, start + k, start + (k + 1) % 6] for k in range(6)]
    return np.vstack(points), faces


def star(corners=12, inner=0.3):
    """One concave polygon."""
    turn = np.arange(corners) * 2 * np.pi / corners
    reach = np.where(np.arange(corners) % 2, inner, 1.0)
    return np.column_stack([reach * np.cos(turn), reach * np.sin(turn), 0 * turn]), [list(range(corners))]


def crossed_polygon():
    """A bow tie of one quad, and a pentagram of one pentagon."""
    turn = np.arange(5) * 4 * np.pi / 5
    bow = np.array([[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0]], float), [[0, 1, 2, 3]]
    return joined(bow, (np.column_stack([3 + np.cos(turn), np.sin(turn), 0 * turn]), [[0, 1, 2, 3, 4]]))


def polygon_with_a_hole():
    """A square with a square hole as one face, which runs along a bridge twice."""
    outer = np.array([[0, 0, 0], [3, 0, 0], [3, 3, 0], [0, 3, 0]], float)
    inner = np.array([[1, 1, 0], [1, 2, 0], [2, 2, 0], [2, 1, 0]], float)
    return np.vstack([outer, inner]), [[0, 1, 2, 3], [4, 5, 6, 7]]


def bent_polygon():
    """A hexagon far from flat."""
    turn = np.arange(6) * np.pi / 3
    return np.column_stack([np.cos(turn), np.sin(turn), np.where(np.arange(6) % 2, 0.8, -0.8)]), [list(range(6))]


def needles(columns=12, aspect=1000.0):
    """A strip of triangles a thousand times as long as wide."""
    return triangulated(scaled(grid(columns), 1, aspect / columns, 1))


def slivers(height=1e-9):
    """A grid in which some triangles have next to no area: a vertex in the middle of an edge, nearly."""
    points, faces = triangulated(grid(6))
    points, made = list(points), []
    for number, (i, j, k) in enumerate(faces):
        if number % 7:
            made.append([i, j, k])
            continue
        middle = (points[i] + points[j]) / 2
        points.append(middle + height * (points[k] - middle))
        new = len(points) - 1
        made += [[i, j, new], [j, k, new], [k, i, new]]
    return np.array(points), made


def crowd(count, make=box, gap=1.5):
    """Many pieces in rows."""
    side = int(np.ceil(count ** (1 / 3)))
    places = np.array([(i, j, k) for i in range(side) for j in range(side) for k in range(side)][:count])
    return joined(*(moved(make(), *(gap * place)) for place in places))


def spiked(reach):
    """A ball with one vertex far out."""
    points, faces = ball()
    return with_place((points, faces), 5, points[5] * reach)


def noisy(size):
    points, faces = ball(10, 14)
    return points + np.random.default_rng(3).normal(0, size, points.shape), faces


def sheet_in_torus():
    """A square that ends inside a torus, glued to it along three of its edges."""
    points, faces = torus()
    loop = [8 * 0 + k for k in range(4)]
    new = np.vstack([points, points[loop] * 0.5])
    count = len(points)
    return new, [*faces, *([loop[k], loop[k + 1], count + k + 1, count + k] for k in range(3))]


def collapsed(mesh, share):
    """Faces whose corners lie in one place."""
    points, faces = mesh[0].copy(), mesh[1]
    for face in faces[::share]:
        points[face] = points[face[0]]
    return points, faces


def repeated_corner(mesh):
    """Two neighbours in the same place, under two numbers, all along a line: an unmerged seam."""
    points, faces = mesh
    twin = np.vstack([points, points])
    half = len(faces) // 2
    return twin, [*faces[:half], *([v + len(points) for v in face] for face in faces[half:])]


def stairs(steps=20):
    """Coplanar, right and acute edges in turn."""
    points = [[x, y, z] for k in range(steps) for x, z in ((k, k), (k + 1, k)) for y in (0.0, 1.0)]
    faces = [[2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2] for k in range(2 * steps - 1)]
    return np.array(points, float), faces


NAN, INF = float("nan"), float("inf")
MESHES = {
    # What there is nothing of
    "nothing": lambda: (np.empty((0, 3)), []),
    "vertices alone": lambda: (np.random.default_rng(0).normal(size=(9, 3)), []),
    "one triangle": lambda: (np.eye(3), [[0, 1, 2]]),
    "one quad": lambda: grid(1),
    "two triangles apart": lambda: joined((np.eye(3), [[0, 1, 2]]), (np.eye(3) + 5, [[0, 1, 2]])),
    "two triangles at a vertex": lambda: (np.vstack([np.eye(3), -np.eye(3)[:2]]), [[0, 1, 2], [0, 3, 4]]),
    "loose vertices": lambda: joined(grid(), (np.full((5, 3), 9.0), [])),
    # Numbers that are none, or far away
    "nan in a corner": lambda: with_place(ball(), 3, NAN),
    "nan in a loose vertex": lambda: joined(grid(), (np.full((1, 3), NAN), [])),
    "one coordinate nan": lambda: with_place(ball(), 3, [0, NAN, 0]),
    "inf": lambda: with_place(ball(), 3, [INF, 0, 0]),
    "minus inf": lambda: with_place(grid(), 3, [-INF, INF, 0]),
    "all nan": lambda: (np.full((4, 3), NAN), [[0, 1, 2, 3]]),
    "huge": lambda: scaled(ball(), 1e30, 1e30, 1e30),
    "as large as single precision": lambda: scaled(ball(), 3e38, 3e38, 3e38),
    "tiny": lambda: scaled(ball(), 1e-30, 1e-30, 1e-30),
    "smaller than single precision": lambda: scaled(ball(), 1e-42, 1e-42, 1e-42),
    "all in one place": lambda: scaled(ball(), 0, 0, 0),
    "on a line": lambda: scaled(ball(), 1, 0, 0),
    "flattened": lambda: scaled(ball(), 1, 1, 0),
    "nearly flattened": lambda: scaled(ball(), 1, 1, 1e-7),
    "far from the origin": lambda: moved(ball(), 1e4, -1e4, 1e4),
    "very far from the origin": lambda: moved(ball(), 1e7, 1e7, 0),
    "a vertex far out": lambda: spiked(1e3),
    "a vertex very far out": lambda: spiked(1e9),
    "sizes of all kinds": lambda: joined(ball(), moved(ball(radius=1e-5), 3, 0, 0), moved(ball(radius=1e5), 2e5, 0, 0)),
    # Shapes of faces
    "needles": needles,
    "needles of a million": lambda: needles(12, 1e6),
    "slivers": slivers,
    "slivers without area": lambda: slivers(0.0),
    "zero-length edges": lambda: with_place(grid(), 8, grid()[0][9]),
    "collapsed faces": lambda: collapsed(ball(), 9),
    "everything collapsed but one": lambda: collapsed(grid(3), 1),
    "star": star,
    "sharp star": lambda: star(40, 0.01),
    "crossed polygons": crossed_polygon,
    "a face over another": polygon_with_a_hole,
    "bent polygon": bent_polygon,
    "polygon of 500 corners": lambda: star(500, 0.98),
    "collinear polygon": lambda: (np.column_stack([np.arange(5.0), np.zeros(5), np.zeros(5)]), [[0, 1, 2, 3, 4]]),
    "noisy": lambda: noisy(0.02),
    "crumpled": lambda: noisy(0.5),
    "stairs": stairs,
    "folded flat": lambda: with_place(grid(2), [6, 7, 8], grid(2)[0][[0, 1, 2]]),
    # How faces meet
    "three fans on an edge": lambda: fans_around(3),
    "four fans on an edge": lambda: fans_around(4),
    "nine fans on an edge": lambda: fans_around(9),
    "hourglass": lambda: hourglass(1)[:2],
    "three caps at a vertex": lambda: caps_at_a_vertex(3),
    "boxes at an edge": lambda: boxes([(0, 0, 0), (1, 1, 0)]),
    "boxes at a corner": lambda: boxes([(0, 0, 0), (1, 1, 1)]),
    "boxes at a face": lambda: boxes([(0, 0, 0), (1, 0, 0)]),
    "doubled face": lambda: with_faces(ball(), ball()[1][7]),
    "doubled and turned face": lambda: with_faces(ball(), ball()[1][7][::-1]),
    "doubled mesh": lambda: with_faces(grid(), *grid()[1]),
    "double-sided mesh": lambda: with_faces(grid(), *(face[::-1] for face in grid()[1])),
    "mesh twice in one place": lambda: joined(ball(), ball()),
    "flipped face": lambda: with_flipped(ball(), 10**6),
    "flipped patch": lambda: with_flipped(ball(), 5),
    "every other face flipped": lambda: with_flipped(grid(), 2),
    "inside out": lambda: with_flipped(ball(), 1),
    "unmerged seam": lambda: repeated_corner(ball()),
    "every face apart": lambda: (
        np.vstack([grid()[0][face] for face in grid()[1]]),
        np.arange(144).reshape(-1, 4).tolist(),
    ),
    "sheet in a torus": sheet_in_torus,
    "wall in a box": lambda: with_faces(box(), [0, 1, 7, 6]),
    "a hole of one face": lambda: (ball()[0], ball()[1][1:]),
    "many holes": lambda: (ball(9, 12)[0], ball(9, 12)[1][::2]),
    # Topology
    "Moebius strip": lambda: moebius_strip(16, 3),
    "narrow Moebius strip": lambda: moebius_strip(5, 1),
    "Klein bottle": lambda: klein_bottle(16, 8),
    "torus of few faces": lambda: torus(3, 3),
    "tetrahedron": lambda: (np.vstack([np.zeros(3), np.eye(3)]), [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
    "pillow of two triangles": lambda: (np.eye(3), [[0, 1, 2], [2, 1, 0]]),
    "balls through each other": lambda: joined(ball(), moved(ball(), 0.5, 0.2, 0)),
    # Many pieces
    "thirty boxes": lambda: crowd(30),
    "boxes that touch": lambda: crowd(27, gap=1.0),
    "twenty triangles": lambda: crowd(20, lambda: (np.eye(3), [[0, 1, 2]])),
}
