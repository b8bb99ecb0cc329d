# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers that are flat: distances from their rims, and which of them lies below a place, without looking for either in
space."""

import numpy as np
from scipy.spatial import cKDTree

from ..extract.layers.surfaces import LayerSurfaces
from ..geometry.tet_mesh import TetMesh
from ..graphs import pairs_within
from .coverage import BeadDistances
from .heights import NOTHING, OUTSIDE, Below

# Normals that differ by less are one, and layers whose places along it differ by less, in spacings, are at one height.
_PARALLEL, _LEVEL = 1e-7, 1e-3
_SLACK = 1e-6
# Places of rims that distances are taken to at first, over the parts of a step.
_MOST = 100_000
# Pairs of a ray and a piece of a rim per batch.
_BATCH = 2_000_000


def is_flat(surfaces: LayerSurfaces) -> bool:
    """Whether all layers are planes across one direction."""
    normals = surfaces.mesh.face_normals
    return bool(len(normals)) and float((normals @ normals[0]).min()) > 1 - _PARALLEL


def rim_pieces(surfaces: LayerSurfaces) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(k, 3) begins and ends of the pieces of all rims, and (k,) the layer of each."""
    mesh = surfaces.mesh
    half = np.flatnonzero(mesh.twins < 0)
    begins, ends = (mesh.vertices[np.roll(mesh.triangles, turn, axis=1).ravel()[half]] for turn in (0, -1))
    return begins, ends, surfaces.layers[half // 3]


class RimDistances:
    """Distances from the rim of the own layer, straight from its pieces."""

    def __init__(self, surfaces: LayerSurfaces, step: float) -> None:
        self._begins, ends, layers = rim_pieces(surfaces)
        self._ways = ends - self._begins
        length = np.linalg.norm(self._ways, axis=1).sum()
        self._near = BeadDistances(self._begins, ends, layers, max(4 * step, length / _MOST))
        self._layers = np.zeros(len(surfaces.vertices), int)
        self._layers[surfaces.triangles] = surfaces.layers[:, None]

    def __call__(self, points: np.ndarray, vertices: np.ndarray) -> np.ndarray:
        """(k,) from (k, 3) points on the layers of (k,) vertices."""
        _, piece = self._near.nearest(points, self._layers[vertices])
        along, away = self._ways[piece], points - self._begins[piece]
        shares = np.einsum("kx,kx->k", away, along) / np.maximum(np.einsum("kx,kx->k", along, along), 1e-300)
        return np.linalg.norm(away - np.clip(shares, 0, 1)[:, None] * along, axis=1)


def flat_below(
    surfaces: LayerSurfaces, solid: TetMesh, points: np.ndarray, normals: np.ndarray, layers: np.ndarray, spacing: float
) -> Below:
    """:class:`.heights.Below` of places on flat layers; parameters as :func:`.heights.below`.

    What lies over the next level is as high as that is away; for the others, the end of the solid is looked for.
    """
    up = surfaces.mesh.face_normals[0]
    side = np.sign(normals[0] @ up)
    flat = across(up)
    begins, ends, of = rim_pieces(surfaces)
    heights = np.zeros(surfaces.count)
    heights[surfaces.layers] = surfaces.vertices[surfaces.triangles[:, 0]] @ up
    order = np.argsort(heights, kind="stable")
    level = np.empty(surfaces.count, int)
    level[order] = np.cumsum(np.append(0, np.diff(heights[order]) > _LEVEL * spacing))
    begins, ends, places = begins @ flat.T, ends @ flat.T, points @ flat.T
    ways, found = np.zeros(len(points)), np.full(len(points), NOTHING)
    for layer in range(surfaces.count):
        own = of == layer
        above = np.flatnonzero(level[layers] == level[layer] + int(side))
        a, b = begins[own], ends[own]
        for part in np.array_split(above, max(1, len(above) * len(a) // _BATCH)):
            inside = part[_encloses(a, b, places[part])]
            ways[inside], found[inside] = np.abs(heights[layers[inside]] - heights[layer]), layer
    left = np.flatnonzero(found == NOTHING)
    if len(left):
        ways[left] = ways_out(solid, points[left], -side * up, flat)
        found[left] = np.where(np.isfinite(ways[left]), OUTSIDE, NOTHING)
        ways[left] = np.where(np.isfinite(ways[left]), ways[left], spacing)
    return Below(ways, found)


def across(direction: np.ndarray) -> np.ndarray:
    """(2, 3) unit vectors across a unit vector and each other."""
    first = np.cross(direction, np.eye(3)[np.abs(direction).argmin()])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(direction, first)])


def ways_out(solid: TetMesh, points: np.ndarray, direction: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """(n,) distances from points along a direction to the solid's boundary, infinite where a ray misses it.

    ``flat`` is (2, 3), two unit vectors across the direction and each other.
    """
    mesh = solid.boundary_surface[0]
    facing = mesh.face_normals @ direction > 0
    corners = mesh.vertices[mesh.triangles[facing]]
    a, b, c = np.moveaxis(corners @ flat.T, 1, 0)
    depths = corners @ direction
    centres = (a + b + c) / 3
    around = np.sqrt(np.max([np.square(corner - centres).sum(axis=1).max() for corner in (a, b, c)]))
    tree, places, ways = cKDTree(centres), points @ flat.T, np.full(len(points), np.inf)
    doubled = _cross(b - a, c - a)
    doubled[doubled == 0] = np.inf
    for part in np.array_split(np.arange(len(points)), max(1, len(points) // 4096)):
        which, target = pairs_within(tree, places[part], around)
        away = places[part][which] - a[target]
        second = _cross(away, (c - a)[target]) / doubled[target]
        third = _cross((b - a)[target], away) / doubled[target]
        inside = (second >= -_SLACK) & (third >= -_SLACK) & (second + third <= 1 + _SLACK)
        first = depths[target, 0]
        at = first + second * (depths[target, 1] - first) + third * (depths[target, 2] - first)
        way = at - (points[part] @ direction)[which]
        hit = inside & (way >= -_SLACK * around)
        np.minimum.at(ways, part[which[hit]], np.maximum(way[hit], 0))
    return ways


def _cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]


def _encloses(begins: np.ndarray, ends: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(n,) bool: whether rims go around points, by how often a ray to the right crosses them."""
    x, y = points[:, :1], points[:, 1:]
    (ax, ay), (bx, by) = begins.T, ends.T
    crosses = (ay > y) != (by > y)
    rise = np.where(by == ay, 1, by - ay)
    return (crosses & (x < ax + (y - ay) / rise * (bx - ax))).sum(axis=1) % 2 == 1
