# SPDX-License-Identifier: GPL-3.0-or-later
"""Beads that cover layers: contours or planes a step apart, and beads where contours leave a gap."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ..extract.layers.surfaces import LayerSurfaces
from ..extract.layers.toolpaths import refuse_many_points, rim_distances, toolpaths
from ..extract.lines.isolines import End, Isolines
from ..geometry import TriangleMesh
from ..geometry.barycentric import barycentric
from ..geometry.nearest import NearestTriangles
from ..graphs import components, sum_by
from ..unit_vectors import unit_vectors
from .coverage import NARROWEST, REACH, WIDEST, BeadDistances, share_area
from .flat import RimDistances, is_flat, rim_pieces
from .medial_axis import Polyline, beads_through, level_pieces, medial_beads, medial_points
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
# Contours on both sides of the medial line that are nearer to it, in steps, are one bead where they are so long; others
# move apart as far as their sides overlap. Farther from places of the line by this, in steps, contours are others.
_CROWDED, _LONG, _OTHER = 0.2, 1.5, 0.1
# How often uncovered areas are filled; smaller pieces of them than _TIP, in squares of a step, are tips of corners.
_ROUNDS, _TIP = 3, 0.12
# Kind of beads that fill gaps.
_GAP = 2
# Lines, and layers and kinds of these, and half the widths that they have to fill at their points.
_Found: TypeAlias = tuple[Isolines, np.ndarray, np.ndarray, np.ndarray]
# Finds the nearest places on the layers, and the triangles that these are in.
_Nearest: TypeAlias = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


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
    rim, medial = distances_to_rims(surfaces, step), medial_points(mesh, distances, step)
    level = level_pieces(mesh, numbers, medial, rim, step)
    lines, layers = _without_crowded(lines, layers, level, step)
    lines = without_straight_points(lines, (_LONGEST if flat else 1) * step)
    first = lines.starts
    inner = np.einsum("lk,lk->l", lines.weights[first], distances[mesh.triangles[lines.triangles[first]]]) > step
    lines = _on_parents(lines, surfaces.mesh, parents)
    on_layers = NearestTriangles(lines.mesh.vertices, lines.mesh.triangles).nearest
    lines, halves = _moved_apart(lines, layers, level, on_layers, step)
    found = lines, layers, inner.astype(int), halves
    at = np.zeros(mesh.vertex_count, int)
    at[mesh.triangles] = numbers[:, None]
    away = contours = _away(lines, layers, step)
    more = medial_beads(mesh, numbers, medial, away, step)
    for left in reversed(range(_ROUNDS + 1)):
        if more:
            added = _put_on_layers(lines.mesh, more, away, rim, on_layers, step)
            found, away = join_lines([found, added]), _away(added[0], added[1], step, away)
        if not left:
            break
        gaps = away(mesh.vertices, at, (1 + 1e-9) * REACH * step) > REACH * step
        far = gaps & _is_large(mesh, gaps, ~np.isin(at, found[1]), _TIP * step**2)
        more = beads_through(mesh, numbers, far, step)
        if not more:
            break
    lines, layers, kinds, halves = found
    is_gap = (kinds == _GAP)[lines.numbers]
    return Beads(lines, layers, kinds, *share_area(mesh, numbers, lines, layers, is_gap, halves, step, contours))


def plane_beads(surfaces: LayerSurfaces, values: np.ndarray, step: float) -> Beads:
    """:class:`Beads` where (p,) values at the vertices of layers are multiples of a step."""
    lines, layers = toolpaths(surfaces.mesh, surfaces.layers, values, step)
    lines = lines.without_repeats(_SAME * step)
    mesh, parents = subdivide(surfaces.mesh, _SIZE * step, _MOST_TRIANGLES)
    is_gap, halves = np.zeros(len(lines.triangles), bool), np.full(len(lines.triangles), step / 2)
    shared = share_area(mesh, surfaces.layers[parents], lines, layers, is_gap, halves, step)
    return Beads(lines, layers, np.ones(len(layers), int), *shared)


def _without_crowded(
    lines: Isolines, layers: np.ndarray, level: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray], step: float
) -> tuple[Isolines, np.ndarray]:
    """Lines and their layers without long parts beside :func:`level_pieces` where only one bead fits."""
    begins, ends, of, ways = level
    near = ways < _CROWDED
    beside = (_CROWDED + _OTHER) * step
    distances = BeadDistances(begins[near], ends[near], of[near], step)
    dropped = distances.nearest(lines.points, layers[lines.numbers], beside)[0]
    long = cut_lines(lines, dropped < beside, _LONG * step)[2]
    kept = np.ones(len(dropped), bool)
    kept[long] = False
    lines, numbers, _ = cut_lines(lines, kept, step)
    return lines, layers[numbers]


def _moved_apart(
    lines: Isolines,
    layers: np.ndarray,
    level: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    on_layers: _Nearest,
    step: float,
) -> tuple[Isolines, np.ndarray]:
    """Contours beside :func:`level_pieces` in the middle between these and the next contours, and half their widths."""
    begins, ends, of, ways = level
    halves = np.full(len(lines.triangles), step / 2)
    away, nearest = BeadDistances(begins, ends, of, step).nearest(
        lines.points, layers[lines.numbers], (0.5 + _OTHER) * step
    )
    way = np.where(nearest >= 0, ways[nearest], 1.0) if len(ways) else np.ones(len(halves))
    moved = np.flatnonzero((way >= _CROWDED) & (way < 0.5) & (away < (way + _OTHER) * step))
    if not len(moved):
        return lines, halves
    points = lines.points
    sides = unit_vectors(np.cross(lines.normals[moved], (points[lines.next] - points[lines.previous])[moved]))
    sides *= np.sign(np.einsum("kx,kx->k", sides, points[moved] - begins[nearest[moved]]))[:, None]
    ways_on = step * (0.5 - way[moved]) / 2
    halves[moved] -= ways_on
    found, triangles = on_layers(points[moved] + ways_on[:, None] * sides)
    made, weights = lines.triangles.copy(), lines.weights.copy()
    made[moved], weights[moved] = triangles, barycentric(lines.mesh, triangles, found)
    return replace(lines, triangles=made, weights=weights), halves


def without_straight_points(lines: Isolines, longest: float) -> Isolines:
    """Leave out points on straight parts of lines, so that those that stay are at most ``longest`` apart."""
    ways = lines.points[lines.next] - lines.points
    lengths = np.linalg.norm(ways, axis=1)
    units = unit_vectors(ways)
    turns = np.arccos(np.clip(np.einsum("nx,nx->n", units, units[lines.previous]), -1, 1))
    number, way, turned = lines.numbers, np.cumsum(lengths) - lengths, np.cumsum(turns)
    bins = np.column_stack([number, way // longest, turned // _TURNED])
    kept = np.append(True, (np.diff(bins, axis=0) != 0).any(axis=1)) | (turns > _TURNED)
    kept[lines.starts + lines.sizes - 1] = True
    sizes = np.bincount(number[kept], minlength=len(lines.sizes))
    return lines.with_points(np.flatnonzero(kept), sizes, lines.ends)


def _away(lines: Isolines, layers: np.ndarray, step: float, others: BeadDistances | None = None) -> BeadDistances:
    """:class:`BeadDistances` of lines, and of others."""
    points = lines.points
    return BeadDistances(points, points[lines.next], layers[lines.numbers], step, others)


def _widths(lines: Isolines) -> np.ndarray:
    """Compute (l,) mean widths inside closed lines: twice the area over the length."""
    points = lines.points
    crosses = np.cross(points - points[lines.starts][lines.numbers], points[lines.next] - points)
    return np.linalg.norm(sum_by(lines.numbers, crosses, len(lines.sizes)), axis=1) / np.maximum(
        lines.lengths, np.finfo(float).tiny
    )


def _is_large(mesh: TriangleMesh, far: np.ndarray, bare: np.ndarray, area: float) -> np.ndarray:
    """(n,) bool: far vertices in connected pieces of at least an area, and those on bare layers."""
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


def _put_on_layers(
    mesh: TriangleMesh, more: list[Polyline], away: BeadDistances, rim: BeadDistances, on_layers: _Nearest, step: float
) -> _Found:
    """Beads that fill gaps as lines on the layers' mesh, with their layers, kinds and half widths."""
    points = np.concatenate([bead.points for bead in more])
    sizes, of = np.array([len(bead.points) for bead in more]), np.array([bead.layer for bead in more])
    at = np.repeat(of, sizes)

    def clear(places: np.ndarray) -> np.ndarray:
        return np.minimum(away(places, at) - step / 2, rim(places, at))

    # Into the middle between what is beside them.
    along = np.concatenate([np.gradient(bead.points, axis=0) for bead in more])
    sides = unit_vectors(np.cross(mesh.face_normals[on_layers(points)[1]], along))
    reach = np.maximum(clear(points), 0)[:, None] / 2 * sides
    off = np.clip((clear(points + reach) - clear(points - reach)) / 2, -_OTHER * step, _OTHER * step)
    points = points + off[:, None] * sides
    free = clear(points)
    places, triangles = on_layers(points)
    ends = np.array([[End.CLOSED if bead.closed else End.BOUNDARY] * 2 for bead in more])
    added = Isolines(mesh, triangles, barycentric(mesh, triangles, places), sizes, ends)
    halves = np.clip(free, NARROWEST * step / 2, WIDEST * step / 2)
    return added, of, np.full(len(more), _GAP), halves


def join_lines(parts: Sequence[_Found]) -> _Found:
    """Lines on one mesh as one set, ordered by layer."""
    lines, layers, kinds, widths = zip(*parts, strict=True)
    names = ("triangles", "weights", "sizes", "ends")
    joined = Isolines(lines[0].mesh, *(np.concatenate([getattr(part, name) for part in lines]) for name in names))
    of = np.concatenate(layers)
    order = np.argsort(of, kind="stable")
    widths = np.concatenate(widths)[joined.points_of(order)]
    return joined.chosen(order), of[order], np.concatenate(kinds)[order], widths


def cut_lines(lines: Isolines, kept: np.ndarray, shortest: float) -> tuple[Isolines, np.ndarray, np.ndarray]:
    """Cut lines into the runs of points that are ``kept``, (n,) bool, without runs of cut lines below a length.

    Returns the runs as lines, (k,) the line that each was cut from, and (m,) the former index of each of their points.
    """
    numbers, starts, sizes = lines.numbers, lines.starts, lines.sizes
    whole = np.bincount(numbers[~kept], minlength=len(sizes)) == 0
    # Closed lines that are cut begin after a point that is left out.
    first = np.full(len(sizes), len(kept))
    np.minimum.at(first, numbers[~kept], np.flatnonzero(~kept))
    shift = np.where(lines.closed & ~whole, first - starts, 0)
    order = starts[numbers] + (np.arange(len(kept)) - starts[numbers] + shift[numbers]) % sizes[numbers]
    is_kept = kept[order]
    begins = is_kept & ~np.append(False, is_kept[:-1] & (numbers[1:] == numbers[:-1]))
    points = order[is_kept]
    part = np.cumsum(begins)[is_kept] - 1
    of = numbers[begins]
    ends = np.where(whole[of][:, None], lines.ends[of], End.BOUNDARY)
    made = lines.with_points(points, np.bincount(part, minlength=len(of)), ends)
    long = whole[of] | (made.lengths >= shortest)
    return made.chosen(long), of[long], points[long[part]]
