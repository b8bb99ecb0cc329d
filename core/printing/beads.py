# SPDX-License-Identifier: GPL-3.0-or-later
"""Beads that cover layers: contours or planes a step apart, and beads where contours leave a gap."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ..extract.layers.surfaces import LayerSurfaces
from ..extract.layers.toolpaths import refuse_many_points, rim_distances, toolpaths
from ..extract.lines.isolines import End, Isolines
from ..geometry import TriangleMesh
from ..geometry.barycentric import barycentric
from ..geometry.nearest import NearestTriangles
from ..graphs import components, ragged_arange
from .coverage import NARROWEST, REACH, BeadDistances, share_area
from .flat import RimDistances, is_flat, rim_pieces
from .medial_axis import Polyline, beads_through, medial_beads
from .subdivision import subdivide, subdivide_by

# Longest edge of the triangles that contours are found on, in steps, and the most triangles.
_SIZE, _MOST_TRIANGLES = 0.4, 1_500_000
# A distance may bend by this much along an edge of flat layers' triangles, in steps.
_BENT = 0.02
# On flat layers, points of a bead are no farther apart, in steps; and it turns by no more between them, in radians.
_LONGEST, _TURNED = 2.5, 0.05
# Points of contours nearer than this are one, in steps.
_SAME = 0.1
# Contours that are shorter, or whose sides are closer, go around what one bead covers, in steps.
_SHORT, _FLAT = 1.5, 0.1
# How often what is left is looked for; pieces of it that are smaller, in squares of a step, are tips of corners.
_ROUNDS, _TIP = 3, 0.12
# Kind of beads that fill gaps.
_GAP = 2
# Lines, and layers and kinds of these, and widths at their points.
_Found: TypeAlias = tuple[Isolines, np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Beads:
    """Beads on layers.

    Attributes
    ----------
    lines : Isolines over the triangles of the layers
    layers : (l,) the layer of each line, ascending
    kinds : (l,) 0 for a contour beside the rim, 1 for other lines, 2 where a bead fills a gap, 3 for sparse infill
    widths : (n,) at the lines' points: about the step, and such that the beads have the area of the layers
    covered : (c,) share of each layer's area that is covered, see :mod:`.coverage`
    covered_share : of all layers
    """

    lines: Isolines
    layers: np.ndarray
    kinds: np.ndarray
    widths: np.ndarray
    covered: np.ndarray
    covered_share: float


def contour_beads(surfaces: LayerSurfaces, step: float) -> Beads:
    """:class:`Beads` one inside the other from the rim of each layer inwards, the first half a step from it.

    Where two contours leave a gap, and where a layer is narrower than a step, a bead lies along the middle.
    """
    flat = is_flat(surfaces)
    if flat:
        rims = RimDistances(surfaces, step)
        coarse = surfaces.mesh
        away_from_rim = rims(coarse.vertices, np.arange(coarse.vertex_count))
        refuse_many_points(coarse, away_from_rim, step)
        mesh, parents, distances = subdivide_by(
            coarse, away_from_rim, rims, _SIZE * step, _BENT * step, _MOST_TRIANGLES
        )
    else:
        mesh, parents = subdivide(surfaces.mesh, _SIZE * step, _MOST_TRIANGLES)
        distances = rim_distances(mesh)
    numbers = surfaces.layers[parents]
    lines, layers = toolpaths(mesh, numbers, distances - step / 2, step)
    wide = (lines.lengths > _SHORT * step) & ~(lines.closed & (_widths(lines) < _FLAT * step))
    lines, layers = lines.chosen(wide).without_repeats(_SAME * step), layers[wide]
    lines = without_straight_points(lines, (_LONGEST if flat else 1) * step)
    first = lines.starts
    inner = np.einsum("lk,lk->l", lines.weights[first], distances[mesh.triangles[lines.triangles[first]]]) > step
    lines = _on_parents(lines, surfaces.mesh, parents)
    found = lines, layers, inner.astype(int), np.full(len(lines.triangles), float(step))
    rim = distances_to_rims(surfaces, step)
    at = np.zeros(mesh.vertex_count, int)
    at[mesh.triangles] = numbers[:, None]
    away = _away(lines, layers, step)
    more = medial_beads(mesh, numbers, distances, away, step)
    for left in reversed(range(_ROUNDS + 1)):
        if more:
            found = _join_beads(found, more, away, rim, step)
            away = _away(found[0], found[1], step)
        if not left:
            break
        gaps = away(mesh.vertices, at)
        far = (gaps > REACH * step) & _is_large(mesh, gaps > REACH * step, np.isinf(gaps), _TIP * step**2)
        more = beads_through(mesh, numbers, far, step)
        if not more:
            break
    lines, layers, kinds, _ = found
    return Beads(lines, layers, kinds, *share_area(mesh, numbers, lines, away, step))


def plane_beads(surfaces: LayerSurfaces, values: np.ndarray, step: float) -> Beads:
    """:class:`Beads` where (p,) values at the vertices of layers are multiples of a step."""
    lines, layers = toolpaths(surfaces.mesh, surfaces.layers, values, step)
    lines = lines.without_repeats(_SAME * step)
    mesh, parents = subdivide(surfaces.mesh, _SIZE * step, _MOST_TRIANGLES)
    shared = share_area(mesh, surfaces.layers[parents], lines, _away(lines, layers, step), step)
    return Beads(lines, layers, np.ones(len(layers), int), *shared)


def without_straight_points(lines: Isolines, longest: float) -> Isolines:
    """Lines without points on straight ways between others that are no farther apart than the longest."""
    points, following = lines.points, lines.next
    ways = points[following] - points
    lengths = np.linalg.norm(ways, axis=1)
    units = ways / np.where(lengths > 0, lengths, 1)[:, None]
    before = np.arange(len(points)) - 1
    before[lines.starts] = np.where(lines.closed, lines.starts + lines.sizes - 1, lines.starts)
    turns = np.arccos(np.clip(np.einsum("nx,nx->n", units, units[before]), -1, 1))
    number, way, turned = lines.numbers, np.cumsum(lengths) - lengths, np.cumsum(turns)
    bins = np.column_stack([number, way // longest, turned // _TURNED])
    kept = np.append(True, (np.diff(bins, axis=0) != 0).any(axis=1)) | (turns > _TURNED)
    kept[lines.starts + lines.sizes - 1] = True
    sizes = np.bincount(number[kept], minlength=len(lines.sizes))
    return replace(lines, triangles=lines.triangles[kept], weights=lines.weights[kept], sizes=sizes)


def _away(lines: Isolines, layers: np.ndarray, step: float) -> BeadDistances:
    """:class:`BeadDistances` of lines."""
    points = lines.points
    return BeadDistances(points, points[lines.next], layers[lines.numbers], step)


def _widths(lines: Isolines) -> np.ndarray:
    """(l,) mean widths of what closed lines go around."""
    points = lines.points
    crosses = np.cross(points - points[lines.starts][lines.numbers], points[lines.next] - points)
    doubled = np.stack([np.bincount(lines.numbers, column, len(lines.sizes)) for column in crosses.T], axis=1)
    return np.linalg.norm(doubled, axis=1) / np.maximum(lines.lengths, np.finfo(float).tiny)


def _is_large(mesh: TriangleMesh, far: np.ndarray, bare: np.ndarray, area: float) -> np.ndarray:
    """(n,) bool: vertices in pieces of those that are far with at least an area, or on layers that are bare."""
    inside = far[mesh.edges].all(axis=1)
    piece = components(mesh.vertex_count, mesh.edges[inside])
    return bare | (np.bincount(piece, mesh.vertex_masses)[piece] >= area)


def _on_parents(lines: Isolines, mesh: TriangleMesh, parents: np.ndarray) -> Isolines:
    """Lines on parts of triangles as lines on these."""
    triangles = parents[lines.triangles]
    return replace(lines, mesh=mesh, triangles=triangles, weights=barycentric(mesh, triangles, lines.points))


def distances_to_rims(surfaces: LayerSurfaces, step: float) -> BeadDistances:
    """:class:`BeadDistances` of the layers' rims."""
    begins, ends, layers = rim_pieces(surfaces)
    return BeadDistances(begins, ends, layers, step)


def _join_beads(found: _Found, more: list[Polyline], away: BeadDistances, rim: BeadDistances, step: float) -> _Found:
    """Lines, layers, kinds and widths with those of more beads, put onto the layers, ordered by layer."""
    if not more:
        return found
    mesh = found[0].mesh
    points = np.concatenate([bead.points for bead in more])
    sizes, of = np.array([len(bead.points) for bead in more]), np.array([bead.layer for bead in more])
    at = np.repeat(of, sizes)
    free = np.minimum(away(points, at) - step / 2, rim(points, at))
    places, triangles = NearestTriangles(mesh.vertices, mesh.triangles).nearest(points)
    ends = np.array([[End.CLOSED if bead.closed else End.BOUNDARY] * 2 for bead in more])
    added = Isolines(mesh, triangles, barycentric(mesh, triangles, places), sizes, ends)
    narrow = np.clip(2 * free, NARROWEST * step, step)
    return join_lines([found, (added, of, np.full(len(more), _GAP), narrow)])


def join_lines(parts: Sequence[_Found]) -> _Found:
    """Lines on one mesh as one set, ordered by layer."""
    lines, layers, kinds, widths = zip(*parts, strict=True)
    sizes, of = np.concatenate([part.sizes for part in lines]), np.concatenate(layers)
    order = np.argsort(of, kind="stable")
    run, place = ragged_arange(sizes[order])
    points = (np.cumsum(sizes) - sizes)[order][run] + place
    joined = Isolines(
        lines[0].mesh,
        np.concatenate([part.triangles for part in lines])[points],
        np.concatenate([part.weights for part in lines])[points],
        sizes[order],
        np.concatenate([part.ends for part in lines])[order],
    )
    return joined, of[order], np.concatenate(kinds)[order], np.concatenate(widths)[points]
