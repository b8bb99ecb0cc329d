# SPDX-License-Identifier: GPL-3.0-or-later
"""How high above what lies below it a bead is laid: the way down from it to the next layer, or out of the solid."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..extract.layers.surfaces import LayerSurfaces
from ..geometry.tet_mesh import TetMesh
from ..graphs import pairs_within
from .subdivision import subdivide

# What is below beside layers: the end of the solid, and nothing as far as it was looked for.
OUTSIDE, NOTHING = -1, -2
# Spacings that are looked down, and that are gone at once.
_DEPTH, _STRIDE = 3.0, 0.5
# Longest edge of the triangles that are looked for, in spacings, and how many of them there may be.
_SIZE, _MOST = 0.75, 1_000_000
# A layer does not lie on itself within this many spacings: its triangles around the point are not below it.
_ITSELF = 0.3
_SLACK, _ON_LAYER = 1e-9, 1e-6


@dataclass(frozen=True)
class Below:
    """What is below places.

    Attributes
    ----------
    heights : (n,) way down to it, scene units
    layers : (n,) the layer, OUTSIDE where the solid ends first, or NOTHING
    """

    heights: np.ndarray
    layers: np.ndarray

    def at(self, points: np.ndarray) -> "Below":
        """Of some of the places."""
        return Below(self.heights[points], self.layers[points])


def below(
    surfaces: LayerSurfaces, solid: TetMesh, points: np.ndarray, normals: np.ndarray, layers: np.ndarray, spacing: float
) -> Below:
    """:class:`Below` of places on layers, against their normals.

    Parameters
    ----------
    surfaces : LayerSurfaces
    solid : TetMesh
    points, normals : (n, 3)
    layers : (n,) on which the points are
    spacing : mean distance of layers; what is farther than three of them counts as NOTHING, at that height
    """
    sides, parents = zip(
        *(subdivide(mesh, _SIZE * spacing, _MOST) for mesh in (surfaces.mesh, solid.boundary_surface[0])), strict=True
    )
    of = np.append(surfaces.layers[parents[0]], np.full(len(parents[1]), OUTSIDE))
    a, b, c = np.moveaxis(np.concatenate([mesh.vertices[mesh.triangles] for mesh in sides]), 1, 0)
    centres = (a + b + c) / 3
    around = np.sqrt(np.max([np.square(corner - centres).sum(axis=1) for corner in (a, b, c)]))
    tree = cKDTree(centres)
    heights = np.full(len(points), _DEPTH * spacing)
    found = np.full(len(points), NOTHING)
    going, stride = np.arange(len(points)), _STRIDE * spacing
    for number in range(round(_DEPTH / _STRIDE)):
        middles = points[going] - (number + 0.5) * stride * normals[going]
        for part in np.array_split(np.arange(len(going)), max(1, len(going) // 4096)):
            rays = going[part]
            which, targets = pairs_within(tree, middles[part], stride / 2 + around)
            ways = _ways(points[rays[which]], -normals[rays[which]], a[targets], b[targets], c[targets])
            kinds = of[targets]
            outward = np.einsum(
                "kx,kx->k", np.cross(b[targets] - a[targets], c[targets] - a[targets]), normals[rays[which]]
            )
            hit = (ways <= (number + 1) * stride) & (ways >= -_SLACK * spacing)
            hit &= np.where(kinds == OUTSIDE, outward <= 0, (kinds != layers[rays[which]]) | (ways > _ITSELF * spacing))
            # A layer on the end of the solid comes before that.
            late = ways[hit] + _ON_LAYER * spacing * (kinds[hit] == OUTSIDE)
            order = np.flatnonzero(hit)[np.argsort(-late, kind="stable")]
            # Of several assignments the last one stays, which is the nearest.
            heights[rays[which[order]]], found[rays[which[order]]] = np.maximum(ways[order], 0), kinds[order]
        going = going[found[going] == NOTHING]
    return Below(heights, found)


def _ways(points: np.ndarray, directions: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """(k,) ways from points along unit directions to triangles, infinite past them (Möller and Trumbore 1997)."""
    ab, ac = b - a, c - a
    across = np.cross(directions, ac)
    volume = np.einsum("kx,kx->k", ab, across)
    safe = np.where(volume == 0, 1, volume)
    away = points - a
    u = np.einsum("kx,kx->k", away, across) / safe
    side = np.cross(away, ab)
    v = np.einsum("kx,kx->k", directions, side) / safe
    ways = np.einsum("kx,kx->k", ac, side) / safe
    inside = (volume != 0) & (u >= -_SLACK) & (v >= -_SLACK) & (u + v <= 1 + _SLACK)
    return np.where(inside, ways, np.inf)
