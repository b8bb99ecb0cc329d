# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers of the quads of a pattern.

Phases count periods within one face only: between faces they may change signs, be exchanged, or jump by whole periods.
Adjacency does not depend on that. So each face is divided into pieces in which both phases stay within half a period,
a quad between grid lines, and pieces that contain the same point of an edge are joined. Where a grid line ends in a
dislocation, the cells on both sides of it are one.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ....geometry.polygons import Polygons
from ....interpolate import FacePhases, evaluate

# Sectors along each edge of a triangle with a defect; in each of them the phase is nearly linear.
_PARTS = 8
# Points of edges are moved into the triangle by this barycentric weight.
_INSIDE = 1e-4
# Points nearer to the border of a piece than this, in quads, are not used to join pieces.
_BORDER = 0.02
# Points that are evaluated at once.
_AT_ONCE = 2_000_000
# The pattern is cut along edges whose two sides have values that differ by more.
_SAME = 0.05
# Pieces, places and values of _pieces_at.
_Seen = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Cells:
    """Numbered quads of two phases on polygons.

    Attributes
    ----------
    pieces : (n, 3) sorted: facet of a triangle, and half period of each phase
    numbers : (n,) number of the quad that each piece belongs to, from 1 on
    """

    phases: tuple[FacePhases, ...]
    polygons: Polygons
    pieces: np.ndarray
    numbers: np.ndarray

    @property
    def count(self) -> int:
        """Number of quads."""
        return int(self.numbers.max(initial=0))

    def at(self, triangles: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(p,) number at (p, 3) barycentric places of (p,) triangles; 0 in pieces too small to be sampled."""
        pieces = _pieces_at(_Fans(self.phases, self.polygons), triangles, weights)[0]
        low, spans = self.pieces.min(axis=0), np.ptp(self.pieces, axis=0) + 1
        known = np.ravel_multi_index(tuple((self.pieces - low).T), tuple(spans))
        fits = ((pieces >= low) & (pieces < low + spans)).all(axis=1)
        asked = np.ravel_multi_index(tuple(np.where(fits[:, None], pieces - low, 0).T), tuple(spans))
        found = np.minimum(np.searchsorted(known, asked), len(known) - 1)
        return np.where(fits & (known[found] == asked), self.numbers[found], 0)


def cells(phases: Sequence[FacePhases], polygons: Polygons) -> Cells:
    """The :class:`Cells` of the two :class:`FacePhases` of quads."""
    fans = _Fans(tuple(phases), polygons)
    pairs = np.concatenate([*_across_edges(fans), *_around_centres(fans)])
    pieces, touching = np.unique(pairs.reshape(-1, pairs.shape[2]), axis=0, return_inverse=True)
    first, second = touching.reshape(-1, 2).T
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(len(pieces),) * 2)
    labels = connected_components(graph, directed=False)[1]
    # Number the quads in the order of their first pieces.
    _, starts, labels = np.unique(labels, return_index=True, return_inverse=True)
    numbers = np.empty(len(starts), int)
    numbers[np.argsort(starts)] = np.arange(1, len(starts) + 1)
    return Cells(fans.phases, polygons, pieces, numbers[labels])


@dataclass(frozen=True)
class _Fans:
    """Triangles divided into facets: one each, or the sectors of a fan around the centre of a defect."""

    phases: tuple[FacePhases, ...]
    polygons: Polygons

    @cached_property
    def split(self) -> np.ndarray:
        """(m,) bool: triangles of faces with a defect."""
        return self.phases[0].corner_place[self.polygons.triangle_corners].any(axis=(1, 2))

    @cached_property
    def first(self) -> np.ndarray:
        """(m,) first facet of each triangle."""
        counts = np.where(self.split, 3 * _PARTS, 1)
        return np.cumsum(counts) - counts

    def centres(self, triangles: np.ndarray) -> np.ndarray:
        """(p, 3) barycentric coordinates of the points around which fans lie: the triangle's centre, or for a triangle
        of a quad with a disclination the middle of the quad's diagonal."""
        place = self.phases[0].corner_place[self.polygons.triangle_corners[triangles]]
        faces = self.polygons.triangle_faces[triangles]
        turned = np.any([phase.disclination[faces].any(axis=1) for phase in self.phases], axis=0)
        # In a singular quad the third coordinate is -1, and the first is 0 at both ends of the diagonal.
        on_diagonal = turned & (place[:, 0, 2] < 0)
        return np.where(on_diagonal[:, None], 0.5 * (place[:, :, 0] == 0), 1 / 3)

    def facets(self, triangles: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(p,) facet at each place."""
        facets = self.first[triangles]
        split = np.flatnonzero(self.split[triangles])
        facets[split] += _sector(weights[split], self.centres(triangles[split]))
        return facets


def _sector(weights: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """(p,) sector of a fan: edge opposite to a corner, and part of the edge."""
    away = weights - centres
    # Factor by which each edge is farther from the centre than the place.
    times = np.divide(centres, -away, out=np.full_like(away, np.inf), where=away < 0)
    opposite = np.argmin(times, axis=1)
    rows = np.arange(len(away))
    times = times[rows, opposite]
    rim = centres + away * np.where(np.isfinite(times), times, 0.0)[:, None]
    tail, head = rim[rows, (opposite + 1) % 3], rim[rows, (opposite + 2) % 3]
    return _PARTS * opposite + np.clip((_PARTS * head / (tail + head)).astype(int), 0, _PARTS - 1)


def _rim(positions: np.ndarray) -> np.ndarray:
    """(..., 3) barycentric places on the rim, in the order of the sectors, for positions from 0 to 3."""
    positions = positions % 3
    opposite = np.minimum(positions.astype(int), 2)
    along = (positions - opposite)[..., None]
    corners = np.eye(3)
    return (1 - along) * corners[(opposite + 1) % 3] + along * corners[(opposite + 2) % 3]


def _pieces_at(fans: _Fans, triangles: np.ndarray, weights: np.ndarray) -> _Seen:
    """(p, 3) pieces, (p, 2) places between 0 and 1 in each, and (p, 2) values that do not depend on the side."""
    values = np.stack([evaluate(phase, fans.polygons, triangles, weights) for phase in fans.phases], axis=1)
    counted = values / np.pi
    pieces = np.floor(counted).astype(int)
    cosines = np.cos(values)
    invariants = np.column_stack([cosines.sum(axis=1), cosines.prod(axis=1)])
    return np.column_stack([fans.facets(triangles, weights), pieces]), counted - pieces, invariants


def _samples(fans: _Fans) -> np.ndarray:
    """Places along an edge, from 0 to 1, at both ends and several in each piece."""
    corners = fans.polygons.triangle_corners
    spans = [np.ptp(phase.corner_phase[corners], axis=1).max(initial=0) for phase in fans.phases]
    count = int(np.clip(8 * max(spans) / np.pi, 8, 128))
    return np.concatenate([[0.002], (np.arange(count) + 0.5) / count, [0.998]])


def _blocks(items: np.ndarray, along: np.ndarray) -> list[np.ndarray]:
    """Parts of an array, each with at most about :data:`_AT_ONCE` points if each item has the points ``along``."""
    return np.array_split(items, max(1, len(items) * len(along) // _AT_ONCE))


def _across_edges(fans: _Fans) -> Iterator[np.ndarray]:
    """:func:`_contacts` at points of edges, for one block of edges after the other."""
    triangles = fans.polygons.triangles
    ends = np.stack([triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]], axis=2).reshape(-1, 2)
    low_first = ends[:, 0] < ends[:, 1]
    order = np.lexsort(np.sort(ends, axis=1).T)
    edges = np.sort(ends, axis=1)[order]
    same = np.flatnonzero((edges[:-1] == edges[1:]).all(axis=1))
    along = _samples(fans)
    for block in _blocks(same, along):
        sides = []
        for half in (order[block], order[block + 1]):
            from_low = np.where(low_first[half, None], along, 1 - along)
            weights = _rim(half[:, None] % 3 + from_low)
            sides.append(_pieces_inside(fans, np.repeat(half // 3, len(along)), weights.reshape(-1, 3)))
        differ = np.abs(sides[0][2] - sides[1][2]).max(axis=1).reshape(-1, len(along)).max(axis=1) > _SAME
        yield _contacts(sides, ~np.repeat(differ, len(along)))


def _around_centres(fans: _Fans) -> Iterator[np.ndarray]:
    """:func:`_contacts` at points between the sectors of fans."""
    rays = np.arange(3 * _PARTS) / _PARTS
    along = _samples(fans)
    for split in _blocks(np.flatnonzero(fans.split), np.repeat(along, len(rays))):
        triangles = np.repeat(split, len(rays) * len(along))
        centres = np.broadcast_to(fans.centres(split)[:, None, None], (len(split), len(rays), len(along), 3))
        sides = []
        for aside in (-_INSIDE, _INSIDE):
            rim = _rim(rays + aside)[None, :, None]
            places = centres + along[:, None] * (rim - centres)
            sides.append(_pieces_inside(fans, triangles, places.reshape(-1, 3)))
        yield _contacts(sides, True)


def _pieces_inside(fans: _Fans, triangles: np.ndarray, weights: np.ndarray) -> _Seen:
    """:func:`_pieces_at` points of edges, moved into their triangles."""
    return _pieces_at(fans, triangles, (1 - _INSIDE) * weights + _INSIDE / 3)


def _contacts(sides: list[_Seen], kept: np.ndarray | bool) -> np.ndarray:
    """(q, 2, 3) distinct pairs of pieces on both sides of points that are clear of the pieces' borders."""
    (first, places, _), (second, other_places, _) = sides
    clear = np.minimum(0.5 - np.abs(places - 0.5), 0.5 - np.abs(other_places - 0.5)).min(axis=1) > _BORDER
    return np.unique(np.column_stack([first, second])[clear & kept], axis=0).reshape(-1, 2, first.shape[1])
