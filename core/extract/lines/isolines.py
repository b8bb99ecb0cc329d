# SPDX-License-Identifier: GPL-3.0-or-later
"""Isolines of a pattern as polylines on the surface: middles or edges of stripes, and grid lines of quads.

A line runs from edge to edge, straight inside each triangle. It closes, or ends on the boundary, at a disclination that
lies on it, or in a triangle with a dislocation: a dislocation with number N ends |N| lines of each level in a period.
Several lines meet at the centre; a single one goes straight on until it is beside the centre. Counting decides which
crossings a line joins (:mod:`.edge_crossings`); in a triangle with a dislocation they are joined by the shortest lines,
which do not cross.
"""

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import depth_first_order

from ...errors import SettingError, round_up
from ...geometry import TriangleMesh
from ...geometry.barycentric import barycentric
from ...graphs import components, ragged_arange
from ...interpolate import EdgePhases
from .edge_crossings import MOST, Crossings, Rims, chord_ends, chords_of, crossings_of, on_rim, rims_of
from .levels import GRID, Levels, stripe_levels
from .prepared_pattern import PreparedPattern, move_off_lines, prepare_pattern

# The direction of a line at its end is measured over this many pieces before its last triangle.
_BACK = 3
# Lines shorter than this, in mean edge lengths, go around a vertex that they should pass, and are left out.
_SPECK = 1e-4


class End(IntEnum):
    """How a line ends."""

    CLOSED = 0
    BOUNDARY = 1
    DISLOCATION = 2
    DISCLINATION = 3


@dataclass(frozen=True)
class Isolines:
    """Lines as runs of consecutive points; a closed line does not repeat its first point.

    Attributes
    ----------
    triangles, weights : (n,), (n, 3) triangle that each point lies in and its barycentric coordinates there; as traced,
        the segment to the next point is straight in that triangle
    sizes : (l,) number of points of each line
    ends : (l, 2) :class:`End` at the first and last point
    """

    mesh: TriangleMesh
    triangles: np.ndarray
    weights: np.ndarray
    sizes: np.ndarray
    ends: np.ndarray

    @property
    def closed(self) -> np.ndarray:
        """(l,) bool."""
        return self.ends[:, 0] == End.CLOSED

    @property
    def starts(self) -> np.ndarray:
        """(l,) first point of each line."""
        return np.cumsum(self.sizes) - self.sizes

    @property
    def numbers(self) -> np.ndarray:
        """(n,) line that each point is on."""
        return np.repeat(np.arange(len(self.sizes)), self.sizes)

    @property
    def next(self) -> np.ndarray:
        """(n,) the point after each one: the first after the last of a closed line, itself at the end of others."""
        following = np.arange(1, len(self.triangles) + 1)
        last = self.starts + self.sizes - 1
        following[last] = np.where(self.closed, self.starts, last)
        return following

    @property
    def previous(self) -> np.ndarray:
        """(n,) the point before each one: the last before the first of a closed line, itself at the begin of others."""
        before = np.arange(-1, len(self.triangles) - 1)
        before[self.starts] = np.where(self.closed, self.starts + self.sizes - 1, self.starts)
        return before

    @property
    def runs(self) -> list[np.ndarray]:
        """(k,) points of each line; a closed line ends with its first point again."""
        lines = zip(self.starts, self.sizes, self.closed, strict=True)
        return [np.r_[start : start + size, [start] if closed else []].astype(int) for start, size, closed in lines]

    @property
    def points(self) -> np.ndarray:
        """(n, 3) positions."""
        return np.einsum("nk,nkx->nx", self.weights, self.mesh.vertices[self.mesh.triangles[self.triangles]])

    @property
    def normals(self) -> np.ndarray:
        """(n, 3) unit normals, interpolated from the vertices."""
        corners = self.mesh.triangles[self.triangles]
        normals = np.einsum("nk,nkx->nx", self.weights, self.mesh.vertex_normals[corners])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        flat = self.mesh.face_normals[self.triangles]
        return np.where(lengths > 1e-6, normals / np.maximum(lengths, 1e-6), flat)

    @property
    def steps(self) -> np.ndarray:
        """(n,) distance from each point to the :attr:`next`."""
        points = self.points
        return np.linalg.norm(points[self.next] - points, axis=1)

    @property
    def arc_lengths(self) -> np.ndarray:
        """(n,) distance from the first point of the line, along the line."""
        return self.sum_before(self.steps)

    def sum_before(self, values: np.ndarray) -> np.ndarray:
        """(n,) sum of the (n,) values of the line's points before each point."""
        way = np.concatenate([[0.0], np.cumsum(values)])
        return way[:-1] - way[self.starts][self.numbers]

    @property
    def lengths(self) -> np.ndarray:
        """(l,) length of each line."""
        return np.bincount(self.numbers, self.steps, len(self.sizes))

    def chosen(self, lines: np.ndarray) -> "Isolines":
        """Some of the lines, by an (l,) bool, or by indices, in their order."""
        lines = np.arange(len(self.sizes))[lines]
        return self.with_points(self.points_of(lines), self.sizes[lines], self.ends[lines])

    def points_of(self, lines: np.ndarray) -> np.ndarray:
        """(m,) numbers of the points of (k,) lines, one line after the other."""
        line, place = ragged_arange(self.sizes[lines])
        return self.starts[lines][line] + place

    def with_points(self, points: np.ndarray, sizes: np.ndarray, ends: np.ndarray) -> "Isolines":
        """Lines of (l,) sizes and (l, 2) ends through (m,) of the points."""
        return Isolines(self.mesh, self.triangles[points], self.weights[points], sizes, ends)

    def resampled(self, distance: float) -> "Isolines":
        """The traced lines with evenly spaced points, about ``distance`` apart; at least three on closed lines.

        Segments may now cross edges. Raises SettingError for more than :data:`MOST` points.
        """
        traced, starts, lengths = self.steps, self.starts, self.lengths
        if lengths.sum() / distance > MOST:
            raise SettingError(
                f"points at a distance of {distance:g} on lines {lengths.sum():.3g} long are more than {MOST:.0e}: "
                f"make it {round_up(lengths.sum() / MOST, 2)} or more"
            )
        counts = np.maximum(np.rint(lengths / distance).astype(int), np.where(self.closed, 3, 1))
        sizes = counts + ~self.closed
        line, place = ragged_arange(sizes)
        along = lengths[line] * place / counts[line]
        way = np.concatenate([[0.0], np.cumsum(traced)])
        last = starts + self.sizes - np.where(self.closed, 1, 2)
        point = np.searchsorted(way[1:-1], way[starts[line]] + along, side="right")
        point = np.clip(point, starts[line], last[line])
        passed = way[point] - way[starts[line]]
        share = np.clip((along - passed) / np.maximum(traced[point], np.finfo(float).tiny), 0, 1)[:, None]
        weights = (1 - share) * self.weights[point] + share * self.ahead[point]
        return replace(self, triangles=self.triangles[point], weights=weights, sizes=sizes)

    @property
    def ahead(self) -> np.ndarray:
        """(n, 3) barycentric coordinates of each point's next point, in the point's own triangle; for traced lines."""
        here, there = (self.mesh.triangles[self.triangles[points]] for points in (slice(None), self.next))
        return np.einsum("nk,nkj->nj", self.weights[self.next], there[:, :, None] == here[:, None])

    def without_repeats(self, distance: float) -> "Isolines":
        """The lines without points that follow the last kept one by less than a distance; ends are kept."""
        starts, last = self.starts, self.starts + self.sizes - 1
        way = np.append(0.0, np.cumsum(self.steps))
        onward = np.searchsorted(way[:-1], way[:-1] + distance)
        onward = np.maximum(onward, np.arange(1, len(way))).tolist()
        # The last kept point of a closed line is also a distance away from the first one.
        before = np.searchsorted(way[:-1], way[last + 1] - distance, side="right") - 1
        stops = np.where(self.closed, np.minimum(before, last), last)
        kept: list[int] = []
        sizes = []
        for start, stop, closed in zip(starts.tolist(), stops.tolist(), self.closed.tolist(), strict=True):
            run = [start]
            while onward[run[-1]] <= stop:
                run.append(onward[run[-1]])
            if not closed and run[-1] != stop:
                run[max(len(run) - 1, 1) :] = [stop]  # the end of an open line replaces the point before it
            kept += run
            sizes.append(len(run))
        return self.with_points(np.array(kept, int), np.array(sizes, int), self.ends)


def isolines(edge_phases: EdgePhases, width: float = 0.0) -> Isolines:
    """The isolines of stripes, or both families of a quad pattern's grid lines.

    Of stripes, the ``width`` is the part of a period that is filled, whose edges are drawn; 0 for the middles of
    stripes, 1 for the middles of gaps. Raises SettingError for another width, a width of quads, or too many lines.
    """
    levels = _levels(edge_phases, width)
    # Lines on the boundary are moved inside, so that they are drawn.
    prepared = prepare_pattern(move_off_lines(edge_phases, levels, lines_outside=False))
    crossings = crossings_of(prepared.phases, levels)
    lines = _with_straight_ends(_join_pieces(edge_phases.mesh, prepared, _pieces(prepared, crossings)))
    at_defect = np.isin(lines.ends, [End.DISLOCATION, End.DISCLINATION]).any(axis=1)
    return lines.chosen(at_defect | (lines.lengths > _SPECK * edge_phases.mesh.edge_lengths.mean()))


def _levels(edge_phases: EdgePhases, width: float) -> Levels:
    if not (np.isfinite(width) and 0 <= width <= 1):
        raise SettingError(f"the width is {width:g}: give a part of a period from 0 (middles) to 1 (middles of gaps)")
    if edge_phases.phase_count == 1:
        return stripe_levels(width)
    if width != 0:
        raise SettingError("quads are drawn by their grid lines, which have no width: set the width to 0")
    return GRID


@dataclass(frozen=True)
class _Pieces:
    """Straight pieces of lines, each inside a triangle of a :class:`PreparedPattern`.

    Attributes
    ----------
    triangles : (h,)
    nodes : (h, 2) nodes at the ends; every line that ends at a centre has its own node there
    places : (h, 2, 3) barycentric coordinates of the ends
    kinds : (n,) :class:`End` of a line that ends at a node
    """

    triangles: np.ndarray
    nodes: np.ndarray
    places: np.ndarray
    kinds: np.ndarray


def _pieces(prepared: PreparedPattern, crossings: Crossings) -> _Pieces:
    """Pieces between crossings and centres."""
    rims = rims_of(prepared, crossings)
    chords = chords_of(prepared, crossings, rims)
    pairs, on_rims = _join_at_dislocations(prepared, crossings, rims)
    to_centre = pairs < 0
    nodes = np.concatenate([chords.ends, np.where(to_centre, -1, rims.crossings[pairs])])
    ends = np.where(to_centre[:, :, None], 1 / 3, on_rims)
    rim_count = len(crossings.edges)
    kinds = np.full(nodes.shape, End.BOUNDARY)
    kinds[nodes >= rim_count] = End.DISCLINATION
    kinds[nodes < 0] = End.DISLOCATION
    at_centre = kinds != End.BOUNDARY
    nodes[at_centre] = rim_count + np.arange(np.count_nonzero(at_centre))
    return _Pieces(
        np.concatenate([chords.triangles, rims.triangles[pairs[:, 0]]]),
        nodes,
        np.concatenate([chord_ends(prepared, crossings, chords), ends]),
        np.concatenate([np.full(rim_count, End.BOUNDARY), kinds[at_centre]]),
    )


def _join_at_dislocations(prepared: PreparedPattern, crossings: Crossings, rims: Rims) -> tuple[np.ndarray, np.ndarray]:
    """(p, 2) places on :class:`Rims` that lines join in triangles with a dislocation, and their (p, 2, 3) coordinates.

    Around the triangle the phase grows through some crossings and falls through others. Each crossing is joined with
    one of the other kind, or with the centre (-1), so that the total length is least: then no two pieces cross.
    """
    mesh = prepared.mesh
    found = np.flatnonzero(rims.numbers[rims.triangles, rims.phases])
    found = found[np.lexsort((rims.phases[found], rims.triangles[found]))]
    triangles, phases, sides = rims.triangles[found], rims.phases[found], rims.sides[found]
    weights = on_rim(mesh, triangles, sides, crossings.shares[rims.crossings[found]])
    away = np.einsum("nk,nkx->nx", weights - 1 / 3, mesh.vertices[mesh.triangles[triangles]])
    grows = rims.values[triangles, sides + 1, phases] > rims.values[triangles, sides, phases]
    first = np.flatnonzero(np.diff(triangles, prepend=-1) | np.diff(phases, prepend=-1))
    joined = [np.empty((0, 2), int)]
    for group in np.split(np.arange(len(found)), first[1:]):  # few triangles have a dislocation
        many, few = group[grows[group]], group[~grows[group]]
        if len(many) < len(few):
            many, few = few, many
        to_few = np.linalg.norm(away[many, None] - away[few], axis=2)
        to_centre = np.repeat(np.linalg.norm(away[many], axis=1)[:, None], len(many) - len(few), axis=1)
        rows, columns = linear_sum_assignment(np.hstack([to_few, to_centre]))
        joined.append(np.column_stack([many[rows], np.append(few, np.full(len(many) - len(few), -1))[columns]]))
    pairs = np.concatenate(joined)
    return np.where(pairs < 0, -1, found[pairs]), weights[pairs]


def _join_pieces(mesh: TriangleMesh, prepared: PreparedPattern, pieces: _Pieces) -> Isolines:
    """:class:`Isolines` of pieces joined at their nodes; each node has one or two pieces."""
    count = len(pieces.kinds)
    degrees = np.bincount(pieces.nodes.ravel(), minlength=count)
    labels = components(count, pieces.nodes)
    # A depth-first search walks along each line from one of its ends, or from any node of a closed line.
    candidates = np.lexsort((degrees != 1, labels))
    first = candidates[np.flatnonzero(np.diff(labels[candidates], prepend=-1))]
    joined = np.append(pieces.nodes, np.column_stack([np.full(len(first), count), first]), axis=0)
    hub = coo_matrix((np.ones(len(joined)), joined.T), shape=(count + 1, count + 1)).tocsr()
    order = depth_first_order(hub, count, directed=False, return_predecessors=False)[1:]
    place = np.empty(count, int)
    place[order] = np.arange(count)
    sizes = np.diff(np.append(np.flatnonzero(np.diff(labels[order], prepend=-1)), count))
    starts = np.cumsum(sizes) - sizes
    ends = pieces.kinds[order[np.column_stack([starts, starts + sizes - 1])]]
    ends[degrees[order[starts]] == 2] = End.CLOSED
    # Each point belongs to the piece that follows it; the last point of an open line to the piece before it.
    at = place[pieces.nodes]
    beside = np.abs(at[:, 0] - at[:, 1]) == 1
    from_low = at.min(axis=1)
    taken = np.where(beside, from_low, at.max(axis=1))
    again = np.setdiff1d(np.arange(len(taken)), np.unique(taken, return_index=True)[1])
    taken[again] = at[again].max(axis=1)  # lines of two points
    piece = np.empty(count, int)
    piece[taken] = np.arange(len(taken))
    last = (starts + sizes - 1)[ends[:, 0] != End.CLOSED]
    piece[last] = piece[last - 1]
    end = (at[piece, 1] == np.arange(count)).astype(int)
    triangles = pieces.triangles[piece]
    weights = np.einsum("nk,nkx->nx", pieces.places[piece, end], prepared.places[triangles])
    return Isolines(mesh, prepared.parents[triangles], weights, sizes, ends)


def _with_straight_ends(lines: Isolines) -> Isolines:
    """The lines with each end that is alone at a dislocation extended straight until it is beside the centre."""
    starts, last = lines.starts, lines.starts + lines.sizes - 1
    at = np.column_stack([starts, last])[lines.ends == End.DISLOCATION]
    _, which, counts = np.unique(lines.triangles[at], return_inverse=True, return_counts=True)
    at = at[(counts[which] == 1) & (lines.sizes[lines.numbers[at]] > _BACK + 2)]
    line = lines.numbers[at]
    towards = np.where(at == starts[line], 1, -1)
    entry = at + towards
    before = np.clip(entry + _BACK * towards, starts[line], last[line])
    points = lines.points
    ahead, to_centre = points[entry] - points[before], points[at] - points[entry]
    triangles = lines.triangles[at]
    normals = lines.mesh.face_normals[triangles]
    ahead -= np.einsum("ij,ij->i", ahead, normals)[:, None] * normals
    share = np.einsum("ij,ij->i", ahead, to_centre) / np.maximum(np.einsum("ij,ij->i", ahead, ahead), 1e-300)
    end = points[entry] + np.maximum(share, 0)[:, None] * ahead
    begin = barycentric(lines.mesh, triangles, points[entry])
    end = _inside(barycentric(lines.mesh, triangles, end), begin)
    free = ~_is_crossed(lines, np.minimum(at, entry), begin, end)
    weights = lines.weights.copy()
    weights[at[free]] = end[free]
    return replace(lines, weights=weights)


def _is_crossed(lines: Isolines, pieces: np.ndarray, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(k,) bool: whether the segment from begin to end crosses another line in the triangle of each piece."""
    others = np.flatnonzero(lines.next != np.arange(len(lines.triangles)))
    others = others[np.argsort(lines.triangles[others], kind="stable")]
    first, stop = (np.searchsorted(lines.triangles[others], lines.triangles[pieces], side=s) for s in ("left", "right"))
    which, place = ragged_arange(stop - first)
    other = others[first[which] + place]
    p, q, r, s = begin[which], end[which], lines.weights[other], lines.ahead[other]
    apart = (_side(p, q, r) != _side(p, q, s)) & (_side(r, s, p) != _side(r, s, q))
    return np.bincount(which, apart & (other != pieces[which]), len(pieces)) > 0


def _side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
    """(k,) bool: places r lie to the left of the segments from p to q, in barycentric coordinates."""
    return (q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) > (q[:, 1] - p[:, 1]) * (r[:, 0] - p[:, 0])


def _inside(weights: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Barycentric coordinates with segments from places inside the triangles cut off at the triangles' edges."""
    start = np.maximum(start, 0)
    falling = start - weights
    share = np.where(weights < 0, start / np.where(weights < 0, falling, 1), 1).min(axis=1, keepdims=True)
    return np.maximum(start + np.clip(share, 0, 1) * (weights - start), 0)
