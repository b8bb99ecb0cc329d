# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids for the benchmarks, each with two surfaces that layers are to follow: bunnies, and a ring with a wavy top."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from synch_fields.bench.meshes import read_obj
from synch_fields.core.fields.layers import LayerGroup
from synch_fields.core.files.tets import read_tets
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.filling.stuffing import fill_surface
from synch_fields.core.geometry.filling.surface_distance import SurfaceDistance
from synch_fields.core.geometry.tet_mesh import TetMesh, positive

# Corners of a prism's three tetrahedra when its lower triangle's vertices increase.
PRISM = ((0, 1, 2, 5), (0, 1, 4, 5), (0, 3, 4, 5))
# Share of a bunny's height that counts as its base, and of that above which lie the tips of the ears.
BASE, TIPS = 0.03, 0.94
# How much of the wedge's growth is across.
SLANT = 0.8


@dataclass(frozen=True)
class Shape:
    """A solid, standing on its z axis, with (n,) bool for its vertices on the lower and the upper chosen surface."""

    name: str
    mesh: TetMesh
    low: np.ndarray
    high: np.ndarray

    @property
    def size(self):
        """Diagonal of the box."""
        return float(np.linalg.norm(np.ptp(self.mesh.vertices, axis=0)))

    @property
    def groups(self):
        """A layer on either surface."""
        surface = self.mesh.boundary_triangles
        both = ((self.low, "low"), (self.high, "high"))
        return [
            LayerGroup(np.flatnonzero(chosen), surface[chosen[surface].all(axis=1)], 0.0, name) for chosen, name in both
        ]


def solid_bunny(folder):
    """The tetrahedra of bunny.mesh."""
    return _standing("bunny.mesh", read_tets(Path(folder) / "bunny.mesh"))


def stuffed_bunny(folder, size):
    """The Stanford bunny with its holes closed, stuffed with tetrahedra of a size in its own unit: a unit of area."""
    distance = SurfaceDistance(closed(read_obj(Path(folder) / "stanford-bunny.obj")))
    return _standing("stanford-bunny, stuffed", fill_surface(distance, distance.bounds, size))


def closed(mesh):
    """A surface with triangles between the vertices around each of its holes, which are nearly plane."""
    tails, heads = mesh.triangles.ravel(), np.roll(mesh.triangles, -1, axis=1).ravel()
    # Along the rim with the hole on the left.
    following = dict(zip(heads[mesh.twins < 0].tolist(), tails[mesh.twins < 0].tolist(), strict=True))
    lids = []
    while following:
        vertex, rim = next(iter(following)), []
        while vertex in following:
            rim.append(vertex)
            vertex = following.pop(vertex)
        lids += _ears(np.array(rim), mesh.vertices[rim])
    return TriangleMesh(mesh.vertices, np.vstack([mesh.triangles, *lids]))


def _ears(rim, points):
    """Triangles of a polygon, cut off one after the other where they are fattest."""
    across = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    plane = np.linalg.svd(across[None])[2][1:]
    if np.linalg.det([*plane, across]) < 0:
        plane = plane[::-1]
    flat, triangles = points @ plane.T, []
    left = np.arange(len(rim))
    while len(left) >= 3:
        before, after = np.roll(left, 1), np.roll(left, -1)
        a, b, c = flat[before], flat[left], flat[after]
        inside = _turn(a[:, None], b[:, None], flat[left]) >= 0
        inside &= _turn(b[:, None], c[:, None], flat[left]) >= 0
        inside &= _turn(c[:, None], a[:, None], flat[left]) >= 0
        is_ear = (_turn(a, b, c) > 0) & (inside.sum(axis=1) <= 3)
        sides = ((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2).sum(axis=1)
        best = int(np.argmax(np.where(is_ear, _turn(a, b, c) / sides, -np.inf)))
        triangles.append(rim[[before[best], left[best], after[best]]])
        left = np.delete(left, best)
    return triangles


def _turn(a, b, c):
    """Twice the signed area of triangles in the plane."""
    u, v = b - a, c - a
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def _standing(name, mesh):
    """A bunny with its y axis, which points up, turned to z."""
    mesh = TetMesh(mesh.vertices[:, [0, 2, 1]] * [1, -1, 1], mesh.tets)
    height = mesh.vertices[:, 2] - mesh.vertices[:, 2].min()
    share = height / height.max()
    return Shape(name, mesh, _corners(mesh, share < BASE), _corners(mesh, share > TIPS))


def _corners(mesh, chosen):
    """(n,) bool: corners of the boundary triangles that have three chosen ones."""
    triangles = mesh.boundary_triangles
    return np.isin(np.arange(mesh.vertex_count), triangles[chosen[triangles].all(axis=1)])


def ring(around=96, across=20, layers=20):
    """A ring with a flat bottom and a wavy top, the two marked: three times as thick in some places as in others."""
    turn, share, height = (
        np.linspace(0, top, n) for top, n in ((2 * np.pi, around + 1), (1, across + 1), (1, layers + 1))
    )
    turn, share, height = np.meshgrid(turn[:-1], share, height, indexing="ij")
    radius = 0.42 + 0.58 * share
    top = 0.42 + 0.16 * np.cos(2 * turn) + 0.1 * np.sin(3 * turn + 0.6) * share + 0.08 * np.cos(np.pi * share)
    places = np.stack([radius * np.cos(turn), radius * np.sin(turn), height * top], axis=-1).reshape(-1, 3)
    number = np.arange(around * (across + 1) * (layers + 1)).reshape(around, across + 1, layers + 1)
    mesh = _of_columns(places, np.concatenate([number, number[:1]]))
    height = height.ravel()
    return Shape("ring with a wavy top", mesh, height == 0, height == 1)


def box(counts):
    """Vertices of the surface of a unit cube cut into cells, and its quads."""
    numbers, quads = {}, []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, counts[axis]):
            for i, j in np.ndindex(counts[u], counts[v]):
                corners = []
                for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                    place = [0, 0, 0]
                    place[axis], place[u], place[v] = side, a, b
                    corners.append(numbers.setdefault(tuple(place), len(numbers)))
                quads.append(corners if side else corners[::-1])
    return np.array(list(numbers)) / counts, quads


def curved_shell():
    """A dome, a quarter as thick as its inner radius: layers from its inner side outwards."""
    places, quads = box((24, 24, 3))
    across = np.tan(1.4 * (places[:, :2] - 0.5))
    rays = np.column_stack([across, np.ones(len(places))])
    rays *= ((1 + 0.25 * places[:, 2]) / np.linalg.norm(rays, axis=1))[:, None]
    return rays, quads, {"Inner": places[:, 2] == 0}, "distance:Inner", "Inner=layer:0.5"


def bent_bar():
    """A bar that stands on one end and bends by 75 degrees: layers from end to end."""
    places, quads = box((24, 6, 6))
    turn, radius = np.radians(75) * places[:, 0], 1 + 0.6 * places[:, 2]
    bent = np.column_stack([-radius * np.cos(turn), 0.6 * places[:, 1], radius * np.sin(turn)])
    groups = {"Low": places[:, 0] == 0, "High": places[:, 0] == 1}
    return bent, quads, groups, "harmonic:Low:High", "Low=layer:0.5,High=layer:0.5"


def cup():
    """A cup that widens upwards, with a floor, from the outline of half of it that turns around Z."""
    outline = np.array([(0, 0), (20, 0), (27, 60), (23.5, 60), (17, 4), (0, 4)], float)
    count = 96
    turn = 2 * np.pi * np.arange(count) / count
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    places = [np.column_stack([radius * ring, np.full(count, z)]) for radius, z in outline[1:-1]]
    vertices = np.concatenate([*places, [[0, 0, 0], [0, 0, 4]]])
    one, other = np.arange(count), np.roll(np.arange(count), -1)
    quads = [
        np.stack([row + one, row + other, row + count + other, row + count + one], axis=1)
        for row in count * np.arange(3)
    ]
    low, high = len(vertices) - 2, len(vertices) - 1
    fans = [
        np.stack([np.full(count, low), other, one], axis=1),
        np.stack([np.full(count, high), 3 * count + one, 3 * count + other], axis=1),
    ]
    return vertices, [*np.concatenate(quads).tolist(), *np.concatenate(fans).tolist()], {}, "axis:Z", ""


def wedge(along=40, across=12, layers=16):
    """A block of a thickness of 1 in its middle, which grows along a slanted direction from 0.6 at one corner to 1.4 at
    the other, with its bottom and top marked."""
    x, y, height = np.meshgrid(*(np.linspace(0, 1, n + 1) for n in (along, across, layers)), indexing="ij")
    x, y = 2.5 * (x - 0.5), y - 0.5
    thickness = 1 + 0.4 * (x + SLANT * y) / (1.25 + SLANT / 2)
    places = np.stack([x, y, (height - 0.5) * thickness], axis=-1).reshape(-1, 3)
    height = height.ravel()
    mesh = _of_columns(places, np.arange(height.size).reshape(along + 1, across + 1, layers + 1))
    return Shape("wedge", mesh, height == 0, height == 1)


def _of_columns(places, number):
    """The tetrahedra between vertices at places whose numbers are an array of three axes, the last of them upwards."""
    layers = number.shape[2]
    a, b, c, d = number[:-1, :-1, :-1], number[1:, :-1, :-1], number[1:, 1:, :-1], number[:-1, 1:, :-1]
    assert (number[..., 1:] == number[..., :1] + np.arange(1, layers)).all()
    sides = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    lower = np.sort(sides, axis=1)
    prism = np.column_stack([lower, lower + 1])
    return TetMesh(places, positive(places, np.concatenate([prism[:, corners] for corners in PRISM])))
