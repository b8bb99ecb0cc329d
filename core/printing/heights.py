# SPDX-License-Identifier: GPL-3.0-or-later
"""Heights of beads: the distance from each place on a layer down to the next layer, or to the end of the solid."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..extract.layers.surfaces import LayerSurfaces
from ..geometry import TriangleMesh
from ..geometry.tet_mesh import TetMesh
from ..graphs import pairs_within
from .subdivision import places_in, subdivide

# In place of a layer's number: the end of the solid is next, and neither within the depth of the search.
OUTSIDE, NOTHING = -1, -2
# Depth of the search and length of its steps, in spacings.
_DEPTH, _STRIDE = 3.0, 0.5
# Longest edge of the triangles that are searched, in spacings, and their largest number.
_SIZE, _MOST = 0.75, 1_000_000
# A layer does not lie on itself within this many spacings: its triangles around the point are not below it.
_ITSELF = 0.3
_SLACK, _ON_LAYER = 1e-9, 1e-6
# Rays on each side that distances of layers are measured along.
_RAYS = 4000
# Spheres around triangles are wider by this, for rounding; trees have triangles of sizes within this factor.
_WIDER, _SIZES = 1e-6, 2.0


@dataclass(frozen=True)
class Below:
    """The layer or boundary below each of n places.

    Attributes
    ----------
    heights : (n,) distance down to it, scene units
    layers : (n,) number of the layer, OUTSIDE if the solid ends first, or NOTHING
    """

    heights: np.ndarray
    layers: np.ndarray

    def at(self, points: np.ndarray) -> "Below":
        """Select some of the places."""
        return Below(self.heights[points], self.layers[points])


def below(
    surfaces: LayerSurfaces, solid: TetMesh, points: np.ndarray, normals: np.ndarray, layers: np.ndarray, spacing: float
) -> Below:
    """Find what lies below (n, 3) points on the layers of given numbers, (n,), along rays against their (n, 3) normals.

    The search ends at three spacings, the mean distance of layers, with NOTHING at that height.
    """
    meshes = (surfaces.mesh, solid.boundary_surface[0])
    kinds = (surfaces.layers, np.full(meshes[1].triangle_count, OUTSIDE))
    return _search(meshes, kinds, points, normals, layers, spacing, _DEPTH)


def sample_distances(surfaces: LayerSurfaces, solid: TetMesh, spacing: float) -> tuple[np.ndarray, float]:
    """Measure distances between layers along rays, up and down from places spread evenly over the layers.

    Returns (k,) distances, in scene units, and the share of the rays which reach a layer of those that the solid's end
    does not stop.
    """
    mesh, even = surfaces.mesh, (np.arange(_RAYS) + 0.5) / _RAYS
    reached = np.cumsum(mesh.areas)
    triangles = np.searchsorted(reached, even * reached[-1])
    points, normals, own = (
        places_in(mesh, triangles, np.arange(_RAYS)),
        mesh.face_normals[triangles],
        surfaces.layers[triangles],
    )
    found = [below(surfaces, solid, points, side * normals, own, spacing) for side in (1, -1)]
    kinds, heights = (np.concatenate([getattr(one, name) for one in found]) for name in ("layers", "heights"))
    distances = heights[kinds >= 0]
    return distances, len(distances) / max(int((kinds != OUTSIDE).sum()), 1)


def ways_to_end(solid: TetMesh, points: np.ndarray, normals: np.ndarray, spacing: float, depth: float) -> np.ndarray:
    """(n,) ways from points against their normals to the end of the solid, ``depth`` times the spacing at most."""
    mesh = solid.boundary_surface[0]
    kinds = (np.full(mesh.triangle_count, OUTSIDE),)
    return _search((mesh,), kinds, points, normals, np.full(len(points), NOTHING), spacing, depth).heights


def _search(
    meshes: Sequence[TriangleMesh],
    labels: Sequence[np.ndarray],
    points: np.ndarray,
    normals: np.ndarray,
    layers: np.ndarray,
    spacing: float,
    depth: float,
) -> Below:
    """Find the first triangle of some meshes against the normals, with its label: a layer, or OUTSIDE."""
    sides = [subdivide(mesh, _SIZE * spacing, _MOST) for mesh in meshes]
    layer_of = np.concatenate([label[parents] for label, (_, parents) in zip(labels, sides, strict=True)])
    a, b, c = np.moveaxis(np.concatenate([mesh.vertices[mesh.triangles] for mesh, _ in sides]), 1, 0)
    centres = (a + b + c) / 3
    squares = np.max([np.square(corner - centres).sum(axis=1) for corner in (a, b, c)], axis=0)
    trees = _trees_by_size(centres, squares)
    heights = np.full(len(points), depth * spacing)
    found = np.full(len(points), NOTHING)
    going, stride = np.arange(len(points)), _STRIDE * spacing
    for number in range(math.ceil(depth / _STRIDE)):
        middles = points[going] - (number + 0.5) * stride * normals[going]
        for part in np.array_split(np.arange(len(going)), max(1, len(going) // 4096)):
            rays = going[part]
            pairs = []
            for own, tree, around in trees:
                which, targets = pairs_within(tree, middles[part], stride / 2 + around)
                targets = own[targets]
                # Of spheres around triangles, rays meet few.
                away = centres[targets] - points[rays[which]]
                along = np.einsum("kx,kx->k", away, -normals[rays[which]])
                aside = np.einsum("kx,kx->k", away, away) - along**2
                near = aside <= (1 + _WIDER) * squares[targets] + (_WIDER * spacing) ** 2
                near &= along <= (number + 1) * stride + (1 + _WIDER) * around
                pairs.append((which[near], targets[near]))
            which, targets = map(np.concatenate, zip(*pairs, strict=True))
            order = np.lexsort((targets, which))
            which, targets = which[order], targets[order]
            distances = _distances(points[rays[which]], -normals[rays[which]], a[targets], b[targets], c[targets])
            kinds = layer_of[targets]
            outward = np.einsum(
                "kx,kx->k", np.cross(b[targets] - a[targets], c[targets] - a[targets]), normals[rays[which]]
            )
            hit = (distances <= (number + 1) * stride) & (distances >= -_SLACK * spacing)
            hit &= np.where(
                kinds == OUTSIDE, outward <= 0, (kinds != layers[rays[which]]) | (distances > _ITSELF * spacing)
            )
            # Where a layer lies on the end of the solid, the layer counts.
            late = distances[hit] + _ON_LAYER * spacing * (kinds[hit] == OUTSIDE)
            order = np.flatnonzero(hit)[np.argsort(-late, kind="stable")]
            # Of several assignments the last one stays, which is the nearest.
            heights[rays[which[order]]], found[rays[which[order]]] = np.maximum(distances[order], 0), kinds[order]
        going = going[found[going] == NOTHING]
    return Below(heights, found)


def _trees_by_size(centres: np.ndarray, squares: np.ndarray) -> list[tuple[np.ndarray, cKDTree, float]]:
    """Triangles of about one size, the tree of their centres, and their largest radius: a few large ones do not widen
    the search for all."""
    radii = np.sqrt(squares)
    largest = radii.max(initial=0)
    size = np.minimum(np.log(np.maximum(largest, 1e-300) / np.maximum(radii, 1e-300)) / np.log(_SIZES), 3).astype(int)
    groups = [np.flatnonzero(size == one) for one in np.unique(size)]
    return [(own, cKDTree(centres[own]), float(radii[own].max())) for own in groups]


def _distances(points: np.ndarray, directions: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """(k,) distances from points along unit directions to triangles, infinite if missed (Möller and Trumbore 1997)."""
    ab, ac = b - a, c - a
    across = np.cross(directions, ac)
    volume = np.einsum("kx,kx->k", ab, across)
    safe = np.where(volume == 0, 1, volume)
    away = points - a
    u = np.einsum("kx,kx->k", away, across) / safe
    side = np.cross(away, ab)
    v = np.einsum("kx,kx->k", directions, side) / safe
    distances = np.einsum("kx,kx->k", ac, side) / safe
    inside = (volume != 0) & (u >= -_SLACK) & (v >= -_SLACK) & (u + v <= 1 + _SLACK)
    return np.where(inside, distances, np.inf)
