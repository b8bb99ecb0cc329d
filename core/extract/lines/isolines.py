# SPDX-License-Identifier: GPL-3.0-or-later
"""Isolines of a pattern as polylines on the surface: middles or edges of stripes, and grid lines of quads.

A line runs from edge to edge, straight inside each triangle. It closes, or ends on the boundary, at a disclination that
lies on it, or in a triangle with a dislocation: with the number N of that, |N| lines of each level in a period end
there. Several meet at the centre; a single one goes straight on to where it passes the centre. Which crossings a line
joins is decided by counting (:mod:`.edge_crossings`). In a triangle with a dislocation they are joined in the shortest
way in which no two lines cross.
"""

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import depth_first_order

from ...errors import SettingError
from ...geometry import TriangleMesh
from ...graphs import components, ragged_arange
from ...interpolate import EdgePhases
from .edge_crossings import MOST, chord_ends, chords_of, crossings_of, on_rim, rims_of
from .levels import GRID, stripe_levels
from .prepared_pattern import move_off_lines, prepare_pattern

# Pieces back from where a line enters the triangle that it ends in, over which its direction is taken.
_BACK = 3
# Lines shorter than this part of the edges' mean length go around a vertex that they should pass.
_SPECK = 1e-4


class End(IntEnum):
    """What is at the end of a line."""

    CLOSED = 0
    BOUNDARY = 1
    DISLOCATION = 2
    DISCLINATION = 3


@dataclass(frozen=True)
class Isolines:
    """Lines as runs of points; those of a line follow one another, and those of a closed one go around once.

    Attributes
    ----------
    mesh : TriangleMesh
    triangles, weights : (n,), (n, 3) triangle that each point lies in and its barycentric coordinates there; as traced,
        the way to the next point is straight in that triangle
    sizes : (l,) points of each line
    ends : (l, 2) :class:`End` at the first and last point
    """

    mesh: TriangleMesh
    triangles: np.ndarray
    weights: np.ndarray
    sizes: np.ndarray
    ends: np.ndarray

    @property
    def closed(self):
        """(l,) bool."""
        return self.ends[:, 0] == End.CLOSED

    @property
    def starts(self):
        """(l,) first point of each line."""
        return np.cumsum(self.sizes) - self.sizes

    @property
    def numbers(self):
        """(n,) line that each point is on."""
        return np.repeat(np.arange(len(self.sizes)), self.sizes)

    @property
    def next(self):
        """(n,) the point after each one: the first after the last of a closed line, itself at the end of others."""
        following = np.arange(1, len(self.triangles) + 1)
        last = self.starts + self.sizes - 1
        following[last] = np.where(self.closed, self.starts, last)
        return following

    @property
    def runs(self):
        """List of (k,) points of each line, the first one again where it is closed."""
        lines = zip(self.starts, self.sizes, self.closed, strict=True)
        return [np.r_[start : start + size, [start] if closed else []].astype(int) for start, size, closed in lines]

    @property
    def points(self):
        """(n, 3) positions."""
        return np.einsum("nk,nkx->nx", self.weights, self.mesh.vertices[self.mesh.triangles[self.triangles]])

    @property
    def normals(self):
        """(n, 3) unit normals, interpolated from the vertices."""
        corners = self.mesh.triangles[self.triangles]
        normals = np.einsum("nk,nkx->nx", self.weights, self.mesh.vertex_normals[corners])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        flat = self.mesh.face_normals[self.triangles]
        return np.where(lengths > 1e-6, normals / np.maximum(lengths, 1e-6), flat)

    @property
    def steps(self):
        """(n,) distance from each point to the :attr:`next`."""
        return np.linalg.norm(self.points[self.next] - self.points, axis=1)

    @property
    def arc_lengths(self):
        """(n,) way from the first point of the line."""
        way = np.concatenate([[0.0], np.cumsum(self.steps)])
        return way[:-1] - way[self.starts][self.numbers]

    @property
    def lengths(self):
        """(l,)"""
        return np.bincount(self.numbers, self.steps, len(self.sizes))

    def chosen(self, lines):
        """The lines of an (l,) bool."""
        points = lines[self.numbers]
        return Isolines(self.mesh, self.triangles[points], self.weights[points], self.sizes[lines], self.ends[lines])

    def resampled(self, distance):
        """Points at even distance along traced lines, as near to ``distance`` as a whole number of steps comes.

        Closed lines get three points at least. The way between two points may lead over an edge.
        """
        traced, starts = self.steps, self.starts
        lengths = np.bincount(self.numbers, traced, len(self.sizes))
        if lengths.sum() / distance > MOST:
            raise SettingError(
                f"points at a distance of {distance:g} on lines {lengths.sum():.3g} long are more than {MOST:.0e}: "
                f"make it {lengths.sum() / MOST:.2g} or more"
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
    def ahead(self):
        """(n, 3) barycentric coordinates of the point after each one, in the triangle of that one, as traced."""
        here, there = (self.mesh.triangles[self.triangles[points]] for points in (slice(None), self.next))
        return np.einsum("nk,nkj->nj", self.weights[self.next], there[:, :, None] == here[:, None])

    def without_repeats(self, distance):
        """Without the points that are less than a distance along the line from the last one that stays; ends stay."""
        starts, last = self.starts, self.starts + self.sizes - 1
        way = np.append(0.0, np.cumsum(self.steps))
        onward = np.searchsorted(way[:-1], way[:-1] + distance)
        onward = np.maximum(onward, np.arange(1, len(way))).tolist()
        # The last point of a closed line that stays is a distance from where it closes, too.
        before = np.searchsorted(way[:-1], way[last + 1] - distance, side="right") - 1
        stops = np.where(self.closed, np.minimum(before, last), last)
        kept: list[int] = []
        sizes = []
        for start, stop, closed in zip(starts.tolist(), stops.tolist(), self.closed.tolist(), strict=True):
            run = [start]
            while onward[run[-1]] <= stop:
                run.append(onward[run[-1]])
            if not closed and run[-1] != stop:
                # The end of an open line takes the place of the point before it.
                run[max(len(run) - 1, 1) :] = [stop]
            kept += run
            sizes.append(len(run))
        points = np.array(kept, int)
        return replace(self, triangles=self.triangles[points], weights=self.weights[points], sizes=np.array(sizes, int))


def isolines(edge_phases: EdgePhases, width: float = 0.0) -> Isolines:
    """The :class:`Isolines` of :class:`EdgePhases`: of stripes, or both families of a quad pattern's grid lines.

    Parameters
    ----------
    edge_phases : EdgePhases
    width : of stripes, the part of a period that is stripe and whose edges are drawn; 0 for the middles of stripes, 1
        for the middles of gaps

    Raises
    ------
    SettingError
        for another width, and a width of quads
    """
    levels = _levels(edge_phases, width)
    # A line on the boundary is a line too.
    fans = prepare_pattern(move_off_lines(edge_phases, levels, lines_outside=False))
    crossings = crossings_of(fans.phases, levels)
    lines = _with_straight_ends(_join_pieces(edge_phases.mesh, fans, _pieces(fans, crossings)))
    at_defect = np.isin(lines.ends, [End.DISLOCATION, End.DISCLINATION]).any(axis=1)
    return lines.chosen(at_defect | (lines.lengths > _SPECK * edge_phases.mesh.edge_lengths.mean()))


def _levels(edge_phases, width):
    if not (np.isfinite(width) and 0 <= width <= 1):
        raise SettingError(f"the width is {width:g}: give a part of a period from 0 (middles) to 1 (middles of gaps)")
    if edge_phases.phase_count == 1:
        return stripe_levels(width)
    if width != 0:
        raise SettingError("quads are drawn by their grid lines, which have no width: set the width to 0")
    return GRID


@dataclass(frozen=True)
class _Pieces:
    """Straight pieces of lines, each inside a triangle of :class:`Fans`.

    Attributes
    ----------
    triangles : (h,)
    nodes : (h, 2) what is at either end; every line that ends at a centre has a node of its own there
    places : (h, 2, 3) barycentric coordinates of the ends
    kinds : (n,) :class:`End` that a line has at a node where it ends
    """

    triangles: np.ndarray
    nodes: np.ndarray
    places: np.ndarray
    kinds: np.ndarray


def _pieces(fans, crossings):
    """All :class:`_Pieces` between crossings and centres."""
    rims = rims_of(fans, crossings)
    chords = chords_of(fans, crossings, rims)
    pairs, on_rims = _join_at_dislocations(fans, crossings, rims)
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
        np.concatenate([chord_ends(fans, crossings, chords), ends]),
        np.concatenate([np.full(rim_count, End.BOUNDARY), kinds[at_centre]]),
    )


def _join_at_dislocations(fans, crossings, rims):
    """Pairs of places on :class:`Rims` that lines join in triangles with a dislocation, and (p, 2, 3) where these are.

    Around the triangle the phase grows through some crossings and falls through others; what is left over ends at the
    centre, for which -1 stands. Each is joined with one of the other kind or with the centre, so that the sum of the
    ways is least: if two of them crossed, there would be shorter ones.
    """
    mesh = fans.mesh
    found = np.flatnonzero(rims.numbers[rims.triangles, rims.phases])
    found = found[np.lexsort((rims.phases[found], rims.triangles[found]))]
    triangles, phases, sides = rims.triangles[found], rims.phases[found], rims.sides[found]
    weights = on_rim(mesh, triangles, sides, crossings.shares[rims.crossings[found]])
    away = np.einsum("nk,nkx->nx", weights - 1 / 3, mesh.vertices[mesh.triangles[triangles]])
    grows = rims.values[triangles, sides + 1, phases] > rims.values[triangles, sides, phases]
    first = np.flatnonzero(np.diff(triangles, prepend=-1) | np.diff(phases, prepend=-1))
    joined = [np.empty((0, 2), int)]
    # Few triangles hold one.
    for group in np.split(np.arange(len(found)), first[1:]):
        many, few = group[grows[group]], group[~grows[group]]
        if len(many) < len(few):
            many, few = few, many
        to_few = np.linalg.norm(away[many, None] - away[few], axis=2)
        to_centre = np.repeat(np.linalg.norm(away[many], axis=1)[:, None], len(many) - len(few), axis=1)
        rows, columns = linear_sum_assignment(np.hstack([to_few, to_centre]))
        joined.append(np.column_stack([many[rows], np.append(few, np.full(len(many) - len(few), -1))[columns]]))
    pairs = np.concatenate(joined)
    return np.where(pairs < 0, -1, found[pairs]), weights[pairs]


def _join_pieces(mesh, fans, pieces):
    """:class:`Isolines` of pieces joined at their nodes, of which each has one or two."""
    count = len(pieces.kinds)
    degrees = np.bincount(pieces.nodes.ravel(), minlength=count)
    labels = components(count, pieces.nodes)
    # Every line starts at an end, or anywhere, and is walked from there by a search that goes on as far as it can.
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
    # Each point is followed by a piece; the last of an open line is the other end of the one before.
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
    weights = np.einsum("nk,nkx->nx", pieces.places[piece, end], fans.places[triangles])
    return Isolines(mesh, fans.parents[triangles], weights, sizes, ends)


def _with_straight_ends(lines):
    """Lines that end alone at a dislocation go on straight there until they are beside the centre."""
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
    normals = lines.mesh.face_normals[lines.triangles[at]]
    ahead -= np.einsum("ij,ij->i", ahead, normals)[:, None] * normals
    share = np.einsum("ij,ij->i", ahead, to_centre) / np.maximum(np.einsum("ij,ij->i", ahead, ahead), 1e-300)
    end = points[entry] + np.maximum(share, 0)[:, None] * ahead
    corners = lines.mesh.vertices[lines.mesh.triangles[lines.triangles[at]]]
    begin = _barycentric(corners, points[entry])
    end = _inside(_barycentric(corners, end), begin)
    free = ~_is_crossed(lines, np.minimum(at, entry), begin, end)
    weights = lines.weights.copy()
    weights[at[free]] = end[free]
    return replace(lines, weights=weights)


def _is_crossed(lines, pieces, begin, end):
    """(k,) bool: whether another piece of line in the triangle of each piece crosses the way from begin to end."""
    others = np.flatnonzero(lines.next != np.arange(len(lines.triangles)))
    others = others[np.argsort(lines.triangles[others], kind="stable")]
    first, stop = (np.searchsorted(lines.triangles[others], lines.triangles[pieces], side=s) for s in ("left", "right"))
    which, place = ragged_arange(stop - first)
    other = others[first[which] + place]
    p, q, r, s = begin[which], end[which], lines.weights[other], lines.ahead[other]
    apart = (_side(p, q, r) != _side(p, q, s)) & (_side(r, s, p) != _side(r, s, q))
    return np.bincount(which, apart & (other != pieces[which]), len(pieces)) > 0


def _side(p, q, r):
    """Whether places r lie to the left of the way from p to q, in barycentric coordinates."""
    return (q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) > (q[:, 1] - p[:, 1]) * (r[:, 0] - p[:, 0])


def _barycentric(corners, points):
    """(k, 3) coordinates of (k, 3) points in the planes of triangles (k, 3, 3)."""
    sides = corners[:, 1:] - corners[:, :1]
    gram = np.einsum("kax,kbx->kab", sides, sides)
    right = np.einsum("kax,kx->ka", sides, points - corners[:, 0])
    two = np.linalg.solve(gram, right[:, :, None])[:, :, 0]
    return np.column_stack([1 - two.sum(axis=1), two])


def _inside(weights, start):
    """Coordinates of places as far as they are in their triangles on the way from a place that is."""
    start = np.maximum(start, 0)
    falling = start - weights
    share = np.where(weights < 0, start / np.where(weights < 0, falling, 1), 1).min(axis=1, keepdims=True)
    return np.maximum(start + np.clip(share, 0, 1) * (weights - start), 0)
