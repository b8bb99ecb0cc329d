# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads of a pattern, numbered.

A phase counts periods inside a face only: from face to face the two may change their signs and names, and both by whole
periods. What stays is which regions touch. So each face is taken apart into the pieces in which both phases stay within
half a period, a quad between grid lines, and pieces are joined that hold the same point of an edge. Where a grid line
ends in a dislocation, the cells beside it are one.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ....geometry.polygons import Polygons
from ....interpolate import FacePhases, evaluate

# Sectors along each edge of a triangle with a defect: in one of them, the phase is near to linear.
_PARTS = 8
# How far points of edges are moved into the triangle that they are seen from, as a barycentric weight.
_INSIDE = 1e-4
# Points nearer to the border of a piece than this, in quads, are not asked which one they are in.
_BORDER = 0.02
# Points that are looked at at once.
_AT_ONCE = 2_000_000
# Values on the two sides of an edge that differ by more belong to a pattern that is cut there.
_SAME = 0.05


@dataclass(frozen=True)
class Cells:
    """Numbered quads.

    Attributes
    ----------
    phases : the two FacePhases
    polygons : Polygons
    pieces : (n, 3) sorted: facet of a triangle, and which cell of each phase
    numbers : (n,) of the quad that each piece belongs to, from 1 on
    """

    phases: tuple[FacePhases, ...]
    polygons: Polygons
    pieces: np.ndarray
    numbers: np.ndarray

    @property
    def count(self):
        """How many quads there are."""
        return int(self.numbers.max(initial=0))

    def at(self, triangles, weights):
        """(p,) number at (p, 3) barycentric places of (p,) triangles; 0 in a piece too small to be known."""
        pieces = _pieces_at(_Fans(self.phases, self.polygons), triangles, weights)[0]
        low, spans = self.pieces.min(axis=0), np.ptp(self.pieces, axis=0) + 1
        known = np.ravel_multi_index(tuple((self.pieces - low).T), tuple(spans))
        fits = ((pieces >= low) & (pieces < low + spans)).all(axis=1)
        asked = np.ravel_multi_index(tuple(np.where(fits[:, None], pieces - low, 0).T), tuple(spans))
        found = np.minimum(np.searchsorted(known, asked), len(known) - 1)
        return np.where(fits & (known[found] == asked), self.numbers[found], 0)


def cells(phases, polygons):
    """The :class:`Cells` of the two :class:`FacePhases` of quads."""
    fans = _Fans(tuple(phases), polygons)
    pairs = np.concatenate([*_across_edges(fans), *_around_centres(fans)])
    pieces, touching = np.unique(pairs.reshape(-1, pairs.shape[2]), axis=0, return_inverse=True)
    first, second = touching.reshape(-1, 2).T
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(len(pieces),) * 2)
    labels = connected_components(graph, directed=False)[1]
    # Numbers grow in the order in which the faces meet what they stand for.
    _, starts, labels = np.unique(labels, return_index=True, return_inverse=True)
    numbers = np.empty(len(starts), int)
    numbers[np.argsort(starts)] = np.arange(1, len(starts) + 1)
    return Cells(fans.phases, polygons, pieces, numbers[labels])


@dataclass(frozen=True)
class _Fans:
    """Triangles as facets: one each, or the sectors of a fan around the centre of a defect."""

    phases: tuple[FacePhases, ...]
    polygons: Polygons

    @cached_property
    def split(self):
        """(m,) bool: triangles of faces with a defect."""
        return self.phases[0].corner_place[self.polygons.triangle_corners].any(axis=(1, 2))

    @cached_property
    def first(self):
        """(m,) first facet of each triangle."""
        counts = np.where(self.split, 3 * _PARTS, 1)
        return np.cumsum(counts) - counts

    def centres(self, triangles):
        """(p, 3) barycentric: that of the triangle, or the middle of the diagonal where a quad has a disclination."""
        place = self.phases[0].corner_place[self.polygons.triangle_corners[triangles]]
        faces = self.polygons.triangle_faces[triangles]
        turned = np.any([phase.disclination[faces].any(axis=1) for phase in self.phases], axis=0)
        on_diagonal = turned & (place[:, 0, 2] < 0)
        return np.where(on_diagonal[:, None], 0.5 * (place[:, :, 0] == 0), 1 / 3)

    def facets(self, triangles, weights):
        """(p,) facet at each place."""
        facets = self.first[triangles]
        split = np.flatnonzero(self.split[triangles])
        facets[split] += _sector(weights[split], self.centres(triangles[split]))
        return facets


def _sector(weights, centres):
    """(p,) sector of a fan: edge opposite to a corner, and part of the edge."""
    away = weights - centres
    # How many times further than the place the edge is.
    times = np.divide(centres, -away, out=np.full_like(away, np.inf), where=away < 0)
    opposite = np.argmin(times, axis=1)
    rows = np.arange(len(away))
    times = times[rows, opposite]
    rim = centres + away * np.where(np.isfinite(times), times, 0.0)[:, None]
    tail, head = rim[rows, (opposite + 1) % 3], rim[rows, (opposite + 2) % 3]
    return _PARTS * opposite + np.clip((_PARTS * head / (tail + head)).astype(int), 0, _PARTS - 1)


def _rim(positions):
    """(..., 3) barycentric places on the rim, in the order of the sectors; a position from 0 to 3."""
    positions = positions % 3
    opposite = np.minimum(positions.astype(int), 2)
    along = (positions - opposite)[..., None]
    corners = np.eye(3)
    return (1 - along) * corners[(opposite + 1) % 3] + along * corners[(opposite + 2) % 3]


def _pieces_at(fans, triangles, weights):
    """(p, 3) pieces, (p, 2) place between 0 and 1 in each, and (p, 2) values that are the same from any side."""
    values = np.stack([evaluate(phase, fans.polygons, triangles, weights) for phase in fans.phases], axis=1)
    counted = values / np.pi
    pieces = np.floor(counted).astype(int)
    cosines = np.cos(values)
    return (
        np.column_stack([fans.facets(triangles, weights), pieces]),
        counted - pieces,
        np.column_stack([cosines.sum(axis=1), cosines.prod(axis=1)]),
    )


def _samples(fans):
    """Places along an edge, from 0 to 1: enough to meet each piece several times, and both ends."""
    corners = fans.polygons.triangle_corners
    spans = [np.ptp(phase.corner_phase[corners], axis=1).max(initial=0) for phase in fans.phases]
    count = int(np.clip(8 * max(spans) / np.pi, 8, 128))
    return np.concatenate([[0.002], (np.arange(count) + 0.5) / count, [0.998]])


def _blocks(items, along):
    """Parts of an array small enough for so many points to be looked at for each item."""
    return np.array_split(items, max(1, len(items) * len(along) // _AT_ONCE))


def _across_edges(fans):
    """What :func:`_contacts` finds at points of edges, for one block of edges after the other."""
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
            sides.append(_seen(fans, np.repeat(half // 3, len(along)), weights.reshape(-1, 3)))
        differ = np.abs(sides[0][2] - sides[1][2]).max(axis=1).reshape(-1, len(along)).max(axis=1) > _SAME
        yield _contacts(sides, ~np.repeat(differ, len(along)))


def _around_centres(fans):
    """What :func:`_contacts` finds at points between the sectors of fans."""
    rays = np.arange(3 * _PARTS) / _PARTS
    along = _samples(fans)
    for split in _blocks(np.flatnonzero(fans.split), np.repeat(along, len(rays))):
        triangles = np.repeat(split, len(rays) * len(along))
        centres = np.broadcast_to(fans.centres(split)[:, None, None], (len(split), len(rays), len(along), 3))
        sides = []
        for aside in (-_INSIDE, _INSIDE):
            rim = _rim(rays + aside)[None, :, None]
            places = centres + along[:, None] * (rim - centres)
            sides.append(_seen(fans, triangles, places.reshape(-1, 3)))
        yield _contacts(sides, True)


def _seen(fans, triangles, weights):
    """The pieces at points of edges, from inside a triangle."""
    return _pieces_at(fans, triangles, (1 - _INSIDE) * weights + _INSIDE / 3)


def _contacts(sides, kept):
    """(q, 2, 3) pieces on two sides of the same points, clear of their borders; each pair once."""
    (first, places, _), (second, other_places, _) = sides
    clear = np.minimum(0.5 - np.abs(places - 0.5), 0.5 - np.abs(other_places - 0.5)).min(axis=1) > _BORDER
    return np.unique(np.column_stack([first, second])[clear & kept], axis=0).reshape(-1, 2, first.shape[1])
