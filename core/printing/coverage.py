# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of layers beads cover, and how wide they have to be for that, by samples on the layers."""

import numpy as np
from scipy.sparse import coo_matrix, diags_array
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree

from ..algebra.workers import WORKERS
from ..extract.lines.isolines import Isolines
from ..geometry import TriangleMesh
from ..geometry.polylines import divide_pieces
from ..graphs import ragged_arange
from .subdivision import places_in

# Places of a bead that distances are taken to are a step over this apart: a distance of half a step is 1 % too long.
_PARTS = 8
# Farther than this from the middle of the next bead, in steps, a gap is looked at. A place is not covered where it is
# farther than half the width of the bead times the second, and than where its side is wanted times the third: what
# samples are off by.
REACH, COVERED, WANTED = 0.6, 1.04, 1.01
# Width of the narrowest and of the widest bead, in steps.
NARROWEST, WIDEST = 0.25, 1.5
# Widths are averaged over this number of steps. Samples along a step, and their largest number.
_EVEN = 3.0
_SAMPLES, _MOST = 2.5, 3_000_000
# Barycentric coordinates of the middles of a triangle's quarters.
MIDDLES = np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4], [2, 2, 2]]) / 6


class BeadDistances:
    """Distances to the beads of the same layer.

    Parameters
    ----------
    begins, ends : (k, 3) of straight pieces of beads
    layers : (k,) of these
    step : between beads
    others : distances to more beads, which :meth:`__call__` takes into account and :meth:`nearest` does not
    """

    def __init__(
        self,
        begins: np.ndarray,
        ends: np.ndarray,
        layers: np.ndarray,
        step: float,
        others: "BeadDistances | None" = None,
    ) -> None:
        self._others = others
        piece, points = divide_pieces(begins, ends, step / _PARTS)
        points, layers = np.concatenate([points, ends]), np.concatenate([layers[piece], layers])
        self._pieces = np.append(piece, np.arange(len(ends)))
        # Layers are far apart along a fourth axis.
        self._apart = 1e3 * (1 + np.abs(points).max(initial=0))
        at = np.column_stack([points, self._apart * layers])
        self._tree = cKDTree(at, balanced_tree=False, compact_nodes=False) if len(points) else None

    def __call__(self, points: np.ndarray, layers: np.ndarray, within: float = np.inf) -> np.ndarray:
        """(n,) distances from (n, 3) points to beads of their (n,) layers; infinite if none is within reach."""
        own = self.nearest(points, layers, within)[0]
        return own if self._others is None else np.minimum(own, self._others(points, layers, within))

    def nearest(self, points: np.ndarray, layers: np.ndarray, within: float = np.inf) -> tuple[np.ndarray, np.ndarray]:
        """Distances as of a call, without the other beads, and the (n,) nearest piece: -1 if none is within reach."""
        if self._tree is None or len(points) == 0:
            return np.full(len(points), np.inf), np.full(len(points), -1)
        places = np.column_stack([points, self._apart * layers])
        found, at = self._tree.query(places, distance_upper_bound=within, workers=WORKERS)
        near = found < self._apart / 2
        return np.where(near, found, np.inf), np.where(near, self._pieces[np.where(near, at, 0)], -1)


def share_area(
    mesh: TriangleMesh,
    layers: np.ndarray,
    lines: Isolines,
    numbers: np.ndarray,
    is_gap: np.ndarray,
    halves: np.ndarray,
    step: float,
    contours: BeadDistances | None = None,
) -> tuple[np.ndarray, np.ndarray, float]:
    """Assign the area of layers, given by the (t,) layer of each triangle, to the beads with the nearest sides.

    Parameters
    ----------
    lines, numbers : the middles of the beads, and (l,) their layers
    is_gap : (n,) bool, points of beads that fill gaps
    halves : (n,) distance from the middle at which the sides of beads are wanted
    step : between beads
    contours : distances to the lines that fill no gap, where they are there already

    Returns
    -------
    widths : (n,) at the lines' points, with which the beads have the area that is nearest to them
    covered : (c,) share of each layer's area that is between the sides of a bead
    covered_share : of all layers
    """
    samples, triangle = _samples(mesh, step)
    areas = mesh.areas[triangle] / np.bincount(triangle)[triangle]
    points, following, of = lines.points, lines.next, numbers[lines.numbers]
    found, piece = np.full(len(samples), np.inf), np.full(len(samples), -1)
    # Places count that are nearer to where a side is wanted than half a step, or in the widest bead.
    within = COVERED * WIDEST * step + halves.max(initial=0)
    for rows, known in ((np.flatnonzero(~is_gap), contours), (np.flatnonzero(is_gap), None)):
        if len(rows):
            away = known or BeadDistances(points[rows], points[following[rows]], of[rows], step)
            distances, nearest = away.nearest(samples, layers[triangle], within)
            over = distances - halves[rows[nearest]]
            better = over < found
            found[better], piece[better] = over[better], rows[nearest[better]]
    # What is farther than half a bead beside the bead stays empty.
    near = found <= step / 2
    own = np.bincount(piece[near], areas[near], len(lines.triangles)) / 2
    own = own + np.bincount(following, own, len(own))
    widths = np.clip(even_along(lines, own, _EVEN * step), NARROWEST * step, WIDEST * step)
    # Places without a bead have the piece -1.
    half, wanted = np.append(widths / 2, 0)[piece], np.append(halves, 0)[piece]
    is_inside = found + wanted <= np.maximum(COVERED * half, WANTED * wanted)
    inside = np.bincount(triangle, areas * is_inside, mesh.triangle_count)
    covered, areas = np.bincount(layers, inside), np.bincount(layers, mesh.areas)
    return widths, covered / np.maximum(areas, np.finfo(float).tiny), float(covered.sum() / areas.sum())


def _samples(mesh: TriangleMesh, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Places spread evenly over triangles, one at least on each, and (k,) the triangle of each."""
    each = max((step / _SAMPLES) ** 2, mesh.areas.sum() / _MOST)
    counts = np.maximum(np.ceil(mesh.areas / each).astype(int), 1)
    triangle, place = ragged_arange(counts)
    return places_in(mesh, triangle, place + triangle), triangle


def even_along(lines: Isolines, amounts: np.ndarray, length: float) -> np.ndarray:
    """(n,) density along lines of (n,) amounts at their points, evened out over a length; its integral is their sum."""
    masses = point_lengths(lines)
    steps, following = lines.steps, lines.next
    inner = np.flatnonzero(following != np.arange(len(following)))
    links = length**2 / 4 / np.maximum(steps[inner], 1e-3 * length)
    ends = np.stack([inner, following[inner]])
    off = coo_matrix(
        (-np.append(links, links), np.concatenate([ends, ends[::-1]], axis=1)), shape=(len(steps), len(steps))
    ).tocsc()
    masses = np.maximum(masses, 1e-9 * length)
    return spsolve((off + diags_array(masses - np.asarray(off.sum(axis=1)).ravel())).tocsc(), amounts)


def point_lengths(lines: Isolines) -> np.ndarray:
    """(n,) length of line at each point: half the length of the pieces that meet there."""
    lengths = lines.steps / 2
    return lengths + np.bincount(lines.next, lengths, len(lengths))
