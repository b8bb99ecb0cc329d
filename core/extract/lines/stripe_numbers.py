# SPDX-License-Identifier: GPL-3.0-or-later
"""The number of the stripe at a point and a coordinate along the stripe, stored so that a shader can read them.

A shader knows the phase of a point up to whole periods of its face. So each face stores a value for each of
:data:`SLOTS` periods, in the slot of the period's number modulo :data:`SLOTS`, and the shader reads the slot of its
period; baked images read the same slot (:class:`StripeNumbers`). A stripe is identified by the line along its middle,
which ends at defects. Parts of faces that no line crosses belong to the same stripe as the part that they touch nearest
to its middle. The remaining parts are edges of stripes whose middle lies beyond the boundary: each connected component
of them is a stripe too.

The coordinate of a vertex along a stripe is that of the nearest place on the stripe's line. It depends on the vertex
and the stripe alone, so that it is continuous across faces. Closed lines have a whole number of periods, so that
periodic textures are continuous where the line closes. Lines are reversed and shifted one after the other, from
neighbour to neighbour, so that adjacent stripes agree as well as possible.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial import cKDTree

from ...geometry.polygons import Polygons
from ...graphs import find, label_rows
from ...interpolate import TURN, FacePhases, evaluate
from .isolines import Isolines

SLOTS = 3
# Small triangles along a triangle's side in which the phase and the coordinate are compared.
_PARTS = 4
# Most points of a line over which the nearest one is searched.
_MOST_STEPS = 40
# Largest deviation of an edge's two shifts from one whole period; beyond it the faces do not touch.
_SAME = 0.05
# Weight of points outside a slot's part of a face in the vote on which side the phase grows.
_OUTSIDE = 1e-3
# Tolerance, in periods, with which an edge meets a stripe or its middle.
_MET = 1e-3


@dataclass(frozen=True)
class StripeTable:
    """Numbers and coordinates of stripes, stored on a mesh.

    Attributes
    ----------
    numbers : (p, SLOTS) :func:`slot_numbers`, negative where the phase grows to the right of the coordinate's
        direction, seen from outside
    along : (c, SLOTS) coordinates at the corners, in periods; 0 on stripes without a line
    """

    numbers: np.ndarray
    along: np.ndarray


@dataclass(frozen=True)
class StripeNumbers:
    """Numbers of stripes at any place, as the shader reads them; slots are (p, SLOTS), from :func:`slot_numbers`."""

    phase: FacePhases
    polygons: Polygons
    slots: np.ndarray

    @property
    def count(self) -> int:
        """The largest number."""
        return int(self.slots.max(initial=0))

    def at(self, triangles: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(k,) number at (k, 3) barycentric places of (k,) triangles."""
        periods = np.rint(evaluate(self.phase, self.polygons, triangles, weights) / TURN).astype(int)
        return self.slots[self.polygons.triangle_faces[triangles], periods % SLOTS]


def stripe_table(phase: FacePhases, polygons: Polygons, lines: Isolines, spacing: float) -> StripeTable:
    """The :class:`StripeTable` of stripes with a phase on polygons.

    Parameters
    ----------
    lines : along the middles of the stripes, with points a small part of the spacing apart, on the polygons' vertices
    spacing : length of one period of the coordinate
    """
    numbers = slot_numbers(phase, polygons, lines)
    arcs = _Arcs.of(lines, spacing)
    faces, slots = np.nonzero((numbers > 0) & (numbers <= len(lines.sizes)))
    # A row for each corner of a face and each of its stripes.
    row = np.repeat(np.arange(len(faces)), polygons.sizes[faces])
    first = np.cumsum(polygons.sizes[faces]) - polygons.sizes[faces]
    corner = polygons.starts[faces][row] + np.arange(len(row)) - first[row]
    line = numbers[faces, slots][row] - 1
    vertices = lines.mesh.vertices[polygons.corner_vertices[corner]]
    feet = vertices + _ways_to_middle(phase, polygons, lines.mesh.vertices, faces[row], slots[row], corner)
    places, tangents = arcs.nearest(vertices, feet, line)
    places, tangents = _align_lines(arcs, corner, line, places, tangents)
    whole = arcs.wholes[line]
    start = places[first][row]
    places = np.where(whole > 0, start + (places - start + whole / 2) % np.maximum(whole, 1) - whole / 2, places)
    along = np.zeros((len(polygons.corner_vertices), SLOTS))
    along[corner, slots[row]] = places
    signed = _sides(phase, polygons, along) * numbers
    return StripeTable(polygons.at_faces(signed), polygons.at_corners(along))


def slot_numbers(phase: FacePhases, polygons: Polygons, lines: Isolines) -> np.ndarray:
    """(p, SLOTS) number of the stripe in each slot of a face, arguments as of :func:`stripe_table`.

    Numbers start at 1, in the order of the lines, then of the components without a line; 0 marks an unused slot.
    """
    pairs, away = _contacts(phase, polygons)
    numbers = _spread_numbers(_longest_line(phase, polygons, lines), pairs, away)
    rest = pairs[(numbers[pairs] == 0).all(axis=1)]  # on stripes without a line
    met = np.unique(rest[rest[:, 0] == rest[:, 1]])  # slots that an edge meets
    graph = coo_array((np.ones(len(rest)), rest.T), shape=(len(numbers),) * 2)
    labels = connected_components(graph, directed=False)[1][met]
    numbers[met] = len(lines.sizes) + 1 + np.unique(labels, return_inverse=True)[1]
    numbers = numbers.reshape(-1, SLOTS)
    # A face with a defect may contain a small part of a period that does not reach the face's edges.
    speck = _with_defect(phase, polygons)[:, None] & (numbers == 0)
    return polygons.at_faces(np.where(speck, numbers.max(axis=1, keepdims=True), numbers))


def _ways_to_middle(
    phase: FacePhases,
    polygons: Polygons,
    vertices: np.ndarray,
    faces: np.ndarray,
    slots: np.ndarray,
    corners: np.ndarray,
) -> np.ndarray:
    """(k, 3) estimated vectors from corners to the middle of a face's stripe; zero in faces with a defect.

    They distinguish the turns of a line that runs beside itself.
    """
    face = np.repeat(np.arange(len(polygons.starts)), polygons.sizes)
    sizes = polygons.sizes[:, None]
    places, theta = vertices[polygons.corner_vertices], phase.corner_phase / TURN
    centred = places - (np.add.reduceat(places, polygons.starts) / sizes)[face]
    rise = theta - (np.add.reduceat(theta, polygons.starts) / sizes[:, 0])[face]
    spread = np.add.reduceat(centred[:, :, None] * centred[:, None], polygons.starts)
    slope = np.add.reduceat(centred * rise[:, None], polygons.starts)
    gradient = np.einsum("fij,fj->fi", np.linalg.pinv(spread, rcond=1e-6, hermitian=True), slope)
    squares = np.einsum("fi,fi->f", gradient, gradient)
    gradient[_with_defect(phase, polygons) | (squares < np.finfo(float).tiny)] = 0
    missing = (slots - theta[corners] + SLOTS / 2) % SLOTS - SLOTS / 2
    return missing[:, None] * (gradient / np.maximum(squares, np.finfo(float).tiny)[:, None])[faces]


def _with_defect(phase: FacePhases, polygons: Polygons) -> np.ndarray:
    """(p,) bool: faces with a defect."""
    return np.logical_or.reduceat(phase.corner_place.any(axis=1), polygons.starts)


def _longest_line(phase: FacePhases, polygons: Polygons, lines: Isolines) -> np.ndarray:
    """(p SLOTS,) number of the line with the most points in a slot's part of a face, 0 for no line."""
    both = np.concatenate([polygons.triangles, lines.mesh.triangles[lines.triangles]])
    at = find(*np.split(label_rows(np.sort(both, axis=1)), [len(polygons.triangles)]))
    same = at >= 0  # false where a face has been split meanwhile
    triangles = at[same]
    corners = lines.mesh.triangles[lines.triangles[same]]
    match = polygons.triangles[triangles][:, :, None] == corners[:, None, :]
    weights = np.einsum("nk,njk->nj", lines.weights[same], match)
    periods = np.rint(evaluate(phase, polygons, triangles, weights) / TURN).astype(int)
    slots = polygons.triangle_faces[triangles] * SLOTS + periods % SLOTS
    pairs, counts = np.unique(np.column_stack([slots, lines.numbers[same] + 1]), axis=0, return_counts=True)
    order = np.argsort(counts, kind="stable")
    numbers = np.zeros(len(polygons.starts) * SLOTS, int)
    numbers[pairs[order, 0]] = pairs[order, 1]  # of several assignments the last one stays
    return numbers


def _contacts(phase: FacePhases, polygons: Polygons) -> tuple[np.ndarray, np.ndarray]:
    """(q, 2) slots of faces that touch along an edge, numbered face * SLOTS + slot, and (q,) distances to their
    stripe's middle, in periods.

    A slot that an edge meets by more than :data:`_MET` touches itself.
    """
    triangles = polygons.triangles
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    values = _along_edges(phase, polygons)
    turned = ends[:, 0] > ends[:, 1]
    values[turned] = values[turned, ::-1]
    order = np.lexsort(np.sort(ends, axis=1).T)
    edges = np.sort(ends, axis=1)[order]
    same = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    first, second = np.concatenate([order[same], order]), np.concatenate([order[same + 1], order])
    mine, other = values[first], values[second]
    # Between faces the phase may change its sign and jump by whole periods.
    sign = np.where(_misfit(other - mine) <= _misfit(other + mine), 1, -1)
    shift = other - sign[:, None] * mine
    fits = _misfit(shift) < _SAME
    shift = np.rint(shift.mean(axis=1)).astype(int)
    low, high = mine.min(axis=1), mine.max(axis=1)
    least = np.where(first == second, _MET, 0.0)
    pairs, away = [], []
    for step in range(int(np.ceil((high - low).max(initial=0))) + 2):
        period = np.rint(low).astype(int) + step
        meets = fits & (np.minimum(high - period, period - low) >= least - 0.5)
        pair = [
            polygons.triangle_faces[half // 3] * SLOTS + k % SLOTS
            for half, k in ((first, period), (second, sign * period + shift))
        ]
        pairs.append(np.column_stack(pair)[meets])
        away.append(np.maximum(np.maximum(low - period, period - high), 0)[meets])
    return np.concatenate(pairs), np.concatenate(away)


def _along_edges(phase: FacePhases, polygons: Polygons) -> np.ndarray:
    """(3 m, 2) phases at the ends of the triangles' edges, in periods; along edges the phase is always linear."""
    count = len(polygons.triangle_faces)
    tail, head = np.eye(3), np.roll(np.eye(3), -1, axis=0)
    inner = []
    for share in (0.25, 0.75):
        weights = np.tile((1 - share) * tail + share * head, (count, 1))
        inner.append(evaluate(phase, polygons, np.repeat(np.arange(count), 3), weights) / TURN)
    near, far = inner
    return np.column_stack([1.5 * near - 0.5 * far, 1.5 * far - 0.5 * near])


def _misfit(shift: np.ndarray) -> np.ndarray:
    """(q,) distance of the (q, 2) shifts at both ends of an edge from one whole number."""
    whole = np.rint(shift.mean(axis=1))
    return np.abs(shift - whole[:, None]).max(axis=1)


def _spread_numbers(numbers: np.ndarray, pairs: np.ndarray, away: np.ndarray) -> np.ndarray:
    """Carry numbers over to slots without one, in place: along the middles of stripes first, then to their sides."""
    order = np.argsort(-np.tile(away, 2), kind="stable")
    inner, outer = np.concatenate([pairs, pairs[:, ::-1]])[order].T
    away = np.tile(away, 2)[order]
    for reach in (_MET, np.inf):
        while True:
            spreading = (away <= reach) & (numbers[inner] > 0) & (numbers[outer] == 0)
            if not spreading.any():
                break
            # Of several assignments the last one stays, the nearest to the middle.
            numbers[outer[spreading]] = numbers[inner[spreading]]
    return numbers


@dataclass(frozen=True)
class _Arcs:
    """Lines parametrised by arc length, with a search tree of their points.

    Attributes
    ----------
    points, steps : (n, 3), (n,) points, and distances to the next ones in periods
    ways : (n,) distances from the start of the line, in periods
    following, lines : (n,) next point, and line
    wholes : (l,) whole number of periods of closed lines, 0 for open ones
    apart : distance between consecutive lines in the tree's fourth coordinate, larger than all distances in space, so
        that a query finds only points of the same line
    """

    points: np.ndarray
    steps: np.ndarray
    ways: np.ndarray
    following: np.ndarray
    lines: np.ndarray
    wholes: np.ndarray
    apart: float
    tree: cKDTree

    @classmethod
    def of(cls, lines: Isolines, spacing: float) -> "_Arcs":
        """Measure lines in periods; a closed line has the whole number of them, at least 1, that is nearest."""
        wholes = np.where(lines.closed, np.maximum(np.rint(lines.lengths / spacing), 1), 0)
        scale = np.where(lines.closed, wholes / np.maximum(lines.lengths, np.finfo(float).tiny), 1 / spacing)
        points, numbers = lines.points, lines.numbers
        apart = 2 * np.linalg.norm(np.ptp(lines.mesh.vertices, axis=0))
        tree = cKDTree(np.column_stack([points, apart * numbers]))
        steps, ways = lines.steps * scale[numbers], lines.arc_lengths * scale[numbers]
        return cls(points, steps, ways, lines.next, numbers, wholes, apart, tree)

    def nearest(self, places: np.ndarray, feet: np.ndarray, lines: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(k,) coordinates and (k, 3) unit tangents of the points of the given lines nearest to (k, 3) places.

        Searched on the turn of the line beside the (k, 3) feet, which are near the middle of the stripe.
        """
        _, point = self.tree.query(np.column_stack([feet, self.apart * lines]))
        before = np.arange(len(self.points))
        goes_on = np.flatnonzero(self.following != before)
        before[self.following[goes_on]] = goes_on
        point = self._slide_along_lines(point, before, places)
        best = np.full(len(places), np.inf)
        ways, tangents = np.zeros(len(places)), np.zeros((len(places), 3))
        for start in (point, before[point]):
            leg = self.points[self.following[start]] - self.points[start]
            squares = np.einsum("ij,ij->i", leg, leg)
            share = np.einsum("ij,ij->i", places - self.points[start], leg) / np.maximum(squares, np.finfo(float).tiny)
            # An open line is extended straight beyond its ends.
            is_first, is_last = before[start] == start, self.following[self.following[start]] == self.following[start]
            share = np.clip(share, np.where(is_first, -np.inf, 0), np.where(is_last, np.inf, 1))
            off = np.linalg.norm(self.points[start] + share[:, None] * leg - places, axis=1)
            nearer = (off < best) & (squares > 0)
            best[nearer] = off[nearer]
            ways[nearer] = (self.ways[start] + share * self.steps[start])[nearer]
            tangents[nearer] = (leg / np.sqrt(np.maximum(squares, np.finfo(float).tiny))[:, None])[nearer]
        return ways, tangents

    def _slide_along_lines(self, points: np.ndarray, before: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Indices of the points that are reached from (k,) points by steps along their lines, each nearer to a place of
        (k, 3)."""
        off = np.linalg.norm(self.points[points] - places, axis=1)
        for _ in range(_MOST_STEPS):
            moved = False
            for neighbours in (self.following, before):
                there = neighbours[points]
                distance = np.linalg.norm(self.points[there] - places, axis=1)
                nearer = distance < off
                points, off = np.where(nearer, there, points), np.where(nearer, distance, off)
                moved |= nearer.any()
            if not moved:
                break
        return points


def _align_lines(
    arcs: _Arcs, corners: np.ndarray, lines: np.ndarray, places: np.ndarray, tangents: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and tangents with each line reversed and shifted to match its parent in a maximum spanning tree."""
    order = np.lexsort((lines, corners))
    same = corners[order][1:] == corners[order][:-1]
    a, b = order[:-1][same], order[1:][same]
    count = len(arcs.wholes)
    agreement = np.einsum("ij,ij->i", tangents[a], tangents[b])
    bonds = coo_array((agreement, (lines[a], lines[b])), shape=(count, count)).tocsr()
    bonds = bonds + bonds.T
    strength = abs(bonds)
    strength.data = 1 / (1 + strength.data)
    tree = minimum_spanning_tree(strength)
    tree = tree + tree.T
    signs, shifts = np.ones(count), np.zeros(count)
    of_pair = _Groups.of(np.minimum(lines[a], lines[b]) * count + np.maximum(lines[a], lines[b]))
    done = np.zeros(count, bool)
    for root in range(count):
        if done[root]:
            continue
        reached, parents = breadth_first_order(tree, root, directed=False)
        done[reached] = True
        for line in reached[1:]:
            parent = parents[line]
            pairs = of_pair.members(min(line, parent) * count + max(line, parent))
            signs[line] = signs[parent] * (1.0 if agreement[pairs].sum() >= 0 else -1.0)
            mine = np.where(lines[a[pairs]] == line, a[pairs], b[pairs])
            other = np.where(lines[a[pairs]] == line, b[pairs], a[pairs])
            asked = signs[parent] * places[other] + shifts[parent] - signs[line] * places[mine]
            shifts[line] = np.angle(np.exp(1j * TURN * asked).sum()) / TURN
    return signs[lines] * places + shifts[lines], signs[lines][:, None] * tangents


@dataclass(frozen=True)
class _Groups:
    """Indices grouped by their keys."""

    order: np.ndarray
    keys: np.ndarray

    @classmethod
    def of(cls, keys: np.ndarray) -> "_Groups":
        order = np.argsort(keys, kind="stable")
        return cls(order, keys[order])

    def members(self, key: int) -> np.ndarray:
        low, high = np.searchsorted(self.keys, [key, key + 1])
        return self.order[low:high]


def _sides(phase: FacePhases, polygons: Polygons, along: np.ndarray) -> np.ndarray:
    """(p, SLOTS) 1 where the phase grows to the left of the coordinate in most of a slot's part, else -1."""
    lattice = np.array([(i, j, _PARTS - i - j) for i in range(_PARTS + 1) for j in range(_PARTS + 1 - i)])
    index = {tuple(place): number for number, place in enumerate(lattice.tolist())}
    up, down = np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1)]), np.array([(-1, 0, 0), (0, -1, 0), (0, 0, -1)])
    found = []
    for steps, total in ((up, _PARTS - 1), (down, _PARTS + 1)):
        for i in range(total + 1):
            for j in range(total + 1 - i):
                corners = [index.get(tuple(corner)) for corner in (np.array((i, j, total - i - j)) + steps).tolist()]
                if None not in corners:
                    found.append(corners)
    small = np.array(found)
    weights = lattice / _PARTS
    count = len(polygons.triangle_faces)
    triangles = np.repeat(np.arange(count), len(weights))
    inside = np.tile(weights, (count, 1))
    thetas = evaluate(phase, polygons, triangles, inside).reshape(count, -1)[:, small]
    thetas = thetas - TURN * np.rint((thetas - thetas[:, :, :1]) / TURN)
    periods = np.rint(thetas.mean(axis=2) / TURN).astype(int) % SLOTS
    coordinates = np.einsum("wk,mks->mws", weights, along[polygons.triangle_corners])[:, small]
    way, growth = np.diff(coordinates, axis=2), np.diff(thetas, axis=2)[..., None]
    turned = way[:, :, 0] * growth[:, :, 1] - way[:, :, 1] * growth[:, :, 0]
    # Points outside a slot's part only decide where it has almost no points.
    weight = np.where(periods[:, :, None] == np.arange(SLOTS), 1.0, _OUTSIDE)
    votes = np.zeros((len(polygons.starts), SLOTS))
    np.add.at(votes, polygons.triangle_faces, (weight * turned).sum(axis=1))
    return np.where(votes < 0, -1, 1)
