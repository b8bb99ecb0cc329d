# SPDX-License-Identifier: GPL-3.0-or-later
"""Ramps cut into sheets: around a screw dislocation layers are one surface, which lies upon itself.

Levels L are numbers at the vertices of the layers that rise by one from what lies below and hardly change along a
layer: the least of sum_below (L_i - L_j - 1)^2 + w sum_edges (L_i - L_j)^2. On a ramp they rise slowly around the
dislocation; it is cut where they are half way between two sheets.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import cg
from scipy.spatial import cKDTree

from ..extract.layers.surfaces import LayerSurfaces
from ..extract.lines.isolines import End, Isolines
from ..geometry.tet_mesh import TetMesh
from .heights import Below, below
from .order import carrying_pairs

# Weight w of edges, and of what holds levels where nothing lies below or above.
_ALONG, _FREE = 10.0, 1e-6
# Levels differ by whole numbers.
_EXACT = 1e-6
# A layer that lies upon itself is a ramp where its levels differ by more. Shorter parts of lines on another sheet, in
# steps, stay with what is beside them.
_RAMP, _SHORT = 0.75, 1.5


@dataclass(frozen=True)
class Sheets:
    """Parts of layers that do not lie upon themselves.

    Attributes
    ----------
    layers : (s,) the layer of each sheet
    of : (p,) the sheet of each vertex of the layers
    foot : cKDTree of the vertices, layers far apart along a fourth axis
    apart : how far
    """

    layers: np.ndarray
    of: np.ndarray
    foot: cKDTree
    apart: float

    @classmethod
    def find(cls, surfaces: LayerSurfaces, solid: TetMesh, spacing: float) -> "Sheets | None":
        """The sheets of layers, ordered by their levels; None where no layer is a ramp."""
        vertices, mesh = surfaces.vertices, surfaces.mesh
        layers = np.zeros(len(vertices), int)
        layers[surfaces.triangles] = surfaces.layers[:, None]
        apart = 1e3 * (1 + np.abs(vertices).max(initial=0))
        foot = cKDTree(np.column_stack([vertices, apart * layers]))
        found = below(surfaces, solid, vertices, mesh.vertex_normals, layers, spacing)
        around = lie_upon_themselves(layers, found.layers, surfaces.count)
        if not around.any():
            return None
        carried = np.flatnonzero(found.layers >= 0)
        carrying = _feet(foot, apart, vertices, mesh.vertex_normals, found)[carried]
        levels = _levels(len(vertices), carried, carrying, mesh.edges)
        low, high = np.full(surfaces.count, np.inf), np.full(surfaces.count, -np.inf)
        np.minimum.at(low, layers, levels)
        np.maximum.at(high, layers, levels)
        is_ramp = around & (high - low > _RAMP)
        if not is_ramp.any():
            return None
        # Most of a ramp is at whole numbers beside this one.
        middle = np.angle(mesh.vertex_masses @ np.exp(2j * np.pi * levels)) / (2 * np.pi)
        turns = np.where(is_ramp[layers], np.rint(levels - middle), 0).astype(int)
        (of_layers, _), of = np.unique(np.stack([layers, turns]), axis=1, return_inverse=True)
        of = of.reshape(-1)
        order = np.argsort(np.bincount(of, levels) / np.bincount(of), kind="stable")
        return cls(of_layers[order], np.argsort(order)[of], foot, apart)

    def at(self, lines: Isolines) -> np.ndarray:
        """(n,) sheets of points of lines on the layers."""
        corners = lines.mesh.triangles[lines.triangles, lines.weights.argmax(axis=1)]
        return self.of[corners]

    def below(self, points: np.ndarray, normals: np.ndarray, found: Below) -> np.ndarray:
        """(n,) sheets below points; OUTSIDE and NOTHING stay."""
        feet = _feet(self.foot, self.apart, points, normals, found)
        return np.where(found.layers >= 0, self.of[feet], found.layers)


def lie_upon_themselves(layers: np.ndarray, lower: np.ndarray, count: int) -> np.ndarray:
    """(count,) bool: whether each layer lies upon itself, directly or through other layers.

    At each of n places, ``layers`` is the layer there and ``lower`` the one below.
    """
    carried, carrying = carrying_pairs(layers, lower, count)
    graph = coo_matrix((np.ones(len(carried)), (carried, carrying)), shape=(count, count))
    group = connected_components(graph, connection="strong")[1]
    around = np.bincount(group)[group] > 1
    around[carried[carried == carrying]] = True
    return around


def _feet(foot: cKDTree, apart: float, points: np.ndarray, normals: np.ndarray, found: Below) -> np.ndarray:
    """(n,) vertices of the layers nearest to the ends of rays down from points."""
    places = points - found.heights[:, None] * normals
    return foot.query(np.column_stack([places, apart * np.maximum(found.layers, 0)]))[1]


def _levels(count: int, carried: np.ndarray, carrying: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """(count,) levels of vertices of which some lie upon others, see above."""
    i, j = np.append(carried, edges[:, 0]), np.append(carrying, edges[:, 1])
    weights = np.append(np.ones(len(carried)), np.full(len(edges), _ALONG))
    rises = np.append(np.ones(len(carried)), np.zeros(len(edges)))
    rows = np.concatenate([i, j, i, j, np.arange(count)])
    columns = np.concatenate([i, j, j, i, np.arange(count)])
    values = np.concatenate([weights, weights, -weights, -weights, np.full(count, _FREE)])
    matrix = coo_matrix((values, (rows, columns)), shape=(count, count)).tocsr()
    right = np.bincount(i, weights * rises, count) - np.bincount(j, weights * rises, count)
    # Layers upon one another are as wide a graph as a solid, of which a factorization takes gigabytes.
    return cg(matrix, right, rtol=_EXACT, M=diags_array(1 / matrix.diagonal()))[0]


def split_lines(lines: Isolines, sheets: np.ndarray, step: float) -> tuple[Isolines, np.ndarray, np.ndarray]:
    """Lines cut where their (n,) sheets change; parts that are shorter than a step or so stay with the part before.

    Returns the parts, (k,) the sheet of each, and (m,) the former index of each of their points; where two
    parts meet, both have the point.
    """
    starts, closed, ways = lines.starts, lines.closed, lines.steps
    points, sizes, of, ends = [], [], [], []
    for line, (start, size) in enumerate(zip(starts.tolist(), lines.sizes.tolist(), strict=True)):
        row = np.arange(start, start + size)
        changes = np.flatnonzero(sheets[row] != np.roll(sheets[row], 1))
        if closed[line] and len(changes):
            row = np.roll(row, -changes[0])
        runs = np.split(row, np.flatnonzero(np.diff(sheets[row])) + 1)
        joined, labels = [runs[0]], [sheets[runs[0][0]]]
        for run in runs[1:]:
            was_short, label = ways[joined[-1]].sum() < _SHORT * step, sheets[run[0]]
            if was_short or label == labels[-1] or ways[run].sum() < _SHORT * step:
                joined[-1] = np.append(joined[-1], run)
                labels[-1] = label if was_short else labels[-1]
            else:
                joined.append(run)
                labels.append(label)
        if len(joined) == 1:
            row = np.arange(start, start + size)
            points.append(row)
            ends.append(lines.ends[line])
        else:
            after = [*(run[0] for run in joined[1:]), row[0]]
            for run, following in zip(joined, after, strict=True):
                is_last = run is joined[-1] and not closed[line]
                points.append(run if is_last else np.append(run, following))
                ends.append(np.array([End.BOUNDARY, End.BOUNDARY]))
        of += labels
        sizes += [len(run) for run in points[-len(joined) :]]
    taken = np.concatenate([*points, np.zeros(0, int)]).astype(int)
    made = lines.with_points(taken, np.array(sizes, int), np.array(ends, int).reshape(-1, 2))
    return made, np.array(of, int), taken
