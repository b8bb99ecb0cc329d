# SPDX-License-Identifier: GPL-3.0-or-later
"""A graph embedded in an oriented surface: the edges around each node are ordered, so that faces can be traversed."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....graphs import components


@dataclass(frozen=True)
class LineGraph:
    """Edges as pairs of darts, 2 e and 2 e + 1, one from each end.

    Attributes
    ----------
    tails : (2 e,) node that each dart leaves
    keys : (2 e,) the darts around a node are counterclockwise in the order of their keys
    outside : (2 e,) bool, darts along the boundary that have the surface on their right
    kept : (n,) bool, nodes that stay although only two edges meet there
    """

    tails: np.ndarray
    keys: np.ndarray
    outside: np.ndarray
    kept: np.ndarray

    @property
    def heads(self) -> np.ndarray:
        """(2 e,) node that each dart leads to."""
        return self.tails.reshape(-1, 2)[:, ::-1].ravel()

    @property
    def degrees(self) -> np.ndarray:
        """(n,) number of darts at each node."""
        return np.bincount(self.tails, minlength=len(self.kept))

    @cached_property
    def next(self) -> np.ndarray:
        """(2 e,) the dart that follows on the rim of the face to the left."""
        order = np.lexsort((self.keys, self.tails))
        clockwise = np.empty(len(order), int)
        first = np.searchsorted(self.tails[order], self.tails[order])
        last = np.searchsorted(self.tails[order], self.tails[order], side="right") - 1
        places = np.arange(len(order))
        clockwise[order] = order[np.where(places == first, last, places - 1)]
        twins = np.arange(len(order)) ^ 1
        return clockwise[twins]

    @cached_property
    def face_labels(self) -> np.ndarray:
        """(2 e,) face to the left of each dart."""
        count = len(self.tails)
        return components(count, np.column_stack([np.arange(count), self.next]))

    def faces(self) -> tuple[np.ndarray, np.ndarray]:
        """(c,) darts of the faces inside the surface, face by face, and (f,) numbers of their sides."""
        labels = self.face_labels
        inner = ~np.isin(labels, labels[self.outside])
        first = np.unique(np.where(inner, labels, -1), return_index=True)[1]
        first = first[inner[first]]
        sizes = np.bincount(labels)[labels[first]]
        darts = np.empty(sizes.sum(), int)
        starts = np.cumsum(sizes) - sizes
        current = first
        for step in range(sizes.max(initial=0)):
            going = step < sizes
            darts[starts[going] + step] = current[going]
            current = self.next[current]
        return darts, sizes

    def with_edges(self, keep: np.ndarray) -> "LineGraph":
        """The graph with the edges of an (e,) bool."""
        darts = np.repeat(keep, 2)
        return LineGraph(self.tails[darts], self.keys[darts], self.outside[darts], self.kept)

    def contracted(self) -> "LineGraph":
        """The graph with chains through nodes of degree two as single edges, without those that have a free end."""
        through = (self.degrees <= 2) & ~self.kept
        passing = np.flatnonzero(through[self.tails])
        passing = passing[np.argsort(self.tails[passing], kind="stable")]
        met = np.flatnonzero(self.tails[passing[1:]] == self.tails[passing[:-1]])
        count = len(self.tails) // 2
        chain = components(count, np.column_stack([passing[met], passing[met + 1]]) // 2)
        ends = np.flatnonzero(~through[self.tails])
        ends = ends[np.argsort(chain[ends // 2], kind="stable")]
        labels = chain[ends // 2]
        ends = ends[np.bincount(labels, minlength=count)[labels] == 2]
        return LineGraph(self.tails[ends], self.keys[ends], self.outside[ends], self.kept)

    def cleaned(self) -> "LineGraph":
        """The contracted graph with faces of one or two sides merged into a neighbour."""
        graph = self.contracted()
        while True:
            keep = np.ones(len(graph.tails) // 2, bool)
            inner = ~graph.outside.reshape(-1, 2).any(axis=1)
            keep[inner & (graph.tails[0::2] == graph.tails[1::2])] = False
            darts = np.arange(len(graph.tails))
            second = graph.next
            digons = darts[(graph.next[second] == darts) & (darts < second) & ~graph.outside]
            # A loop, because the side that stays may belong to another such face.
            decided = set(np.flatnonzero(~keep).tolist())
            for pair in np.column_stack([digons // 2, second[digons] // 2]).tolist():
                loose = [edge for edge in pair if inner[edge]]
                if loose and pair[0] != pair[1] and decided.isdisjoint(pair):
                    keep[loose[0]] = False
                    decided.update(pair)
            smaller = graph.with_edges(keep).contracted()
            if len(smaller.tails) == len(graph.tails):
                return smaller
            graph = smaller
