# SPDX-License-Identifier: GPL-3.0-or-later
"""Other faces on the vertices of a few quads: edges flipped, and quads collapsed.

Two quads beside each other form a hexagon, which can be divided into two quads in three ways. A quad is collapsed by
merging two of its opposite corners (Daniels et al. 2008); where that leaves a vertex between two faces alone, these are
joined.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

# Fewest edges at an interior vertex, and at one on the boundary.
FEWEST, FEWEST_ON_RIM = 3, 2


@dataclass(frozen=True)
class Patch:
    """Some quads of a mesh.

    Attributes
    ----------
    faces : (f, 4) corners, counterclockwise
    valences : (n,) number of edges at each vertex, also outside of the patch
    on_rim : (n,) bool, vertices on the mesh's boundary
    lines : (n,) line on which each vertex slides, -1 for none
    held : (n,) bool, vertices that stay in place
    apart : (n,) bool, vertices that no new edge may join to one another
    """

    faces: np.ndarray
    valences: np.ndarray
    on_rim: np.ndarray
    lines: np.ndarray
    held: np.ndarray
    apart: np.ndarray

    @cached_property
    def left(self) -> dict[tuple[int, int], int]:
        """The face to the left of each half-edge."""
        tails, heads = self.faces.ravel().tolist(), np.roll(self.faces, -1, axis=1).ravel().tolist()
        return {way: place // 4 for place, way in enumerate(zip(tails, heads, strict=True))}

    def of_vertices(self, faces: np.ndarray, which: np.ndarray) -> "Patch":
        """The (k,) vertices with other faces."""
        of_vertices = self.valences, self.on_rim, self.lines, self.held, self.apart
        return Patch(faces, *(values[which] for values in of_vertices))

    @property
    def surpluses(self) -> np.ndarray:
        """(n,) edges above the number at a regular vertex; 0 for vertices that are gone."""
        return np.where(self.valences > 0, self.valences - np.where(self.on_rim, 3, 4), 0)

    def reconnected(self, number: int) -> Iterator["Patch"]:
        """The patches with another division of a face and one beside it, or with the face collapsed."""
        yield from self._flipped(number)
        for first in range(2):
            corners = np.roll(self.faces[number], -first).tolist()
            for kept, gone in ((0, 2), (2, 0)):
                collapsed = self._collapsed(number, corners, corners[kept], corners[gone])
                if collapsed is not None:
                    yield collapsed
                    break

    def _with(self, faces: np.ndarray, valences: np.ndarray) -> "Patch":
        return Patch(faces, valences, self.on_rim, self.lines, self.held, self.apart)

    def _too_few(self, valences: np.ndarray, vertices: list[int]) -> np.ndarray:
        """(k,) bool: vertices with fewer edges than they need."""
        return valences[vertices] < np.where(self.on_rim[vertices], FEWEST_ON_RIM, FEWEST)

    def _flipped(self, number: int) -> Iterator["Patch"]:
        """The patches in which a side of a face is replaced by another diagonal of the hexagon that it divides."""
        corners, on_line = self.faces[number].tolist(), self.held | (self.lines >= 0)
        for place in range(4):
            a, b, *rest = corners[place:] + corners[:place]
            other = self.left.get((b, a))
            if other is None or other == number or (on_line[a] and on_line[b]):
                continue
            beyond = self.faces[other].tolist()
            at = beyond.index(b)
            hexagon = [b, *rest, a, beyond[at - 2], beyond[at - 1]]
            if len(set(hexagon)) < 6:
                continue
            for first in (1, 2):
                p, q = hexagon[first], hexagon[first + 3]
                valences = self.valences.copy()
                valences[[a, b]] -= 1
                valences[[p, q]] += 1
                joined = (p, q) in self.left or (q, p) in self.left or (self.apart[p] and self.apart[q])
                if joined or self._too_few(valences, [a, b]).any():
                    continue
                faces, ring = self.faces.copy(), hexagon[first:] + hexagon[:first]
                faces[number], faces[other] = ring[:4], [*ring[3:], ring[0]]
                yield self._with(faces, valences)

    def _collapsed(self, number: int, corners: list[int], kept: int, gone: int) -> "Patch | None":
        """The patch with one corner merged into the opposite one; None where that is not a mesh or leaves a line."""
        sides = [corner for corner in corners if corner not in (kept, gone)]
        if self.held[gone] or self.on_rim[[kept, gone]].any() or (self.apart[kept] and self.apart[gone]):
            return None
        around = [{end for way in self.left if corner in way for end in way} - {corner} for corner in (kept, gone)]
        if around[0] & around[1] != set(sides) or kept in around[1]:
            return None
        faces, valences = np.delete(self.faces, number, axis=0), self.valences.copy()
        faces[faces == gone] = kept
        valences[kept] += valences[gone] - 2
        valences[gone] = 0
        valences[sides] -= 1
        removed = [side for side in sides if self._too_few(valences, [side])[0]]
        for alone in removed:
            joined = None if self.held[alone] or self.on_rim[alone] else join_around(faces, alone)
            if joined is None:
                return None
            faces, ends = joined
            beyond = [end for end in ends if end != kept]
            if self.lines[alone] >= 0 and (self.held[beyond] | (self.lines[beyond] >= 0)).any():
                return None  # its line leads on there, not from one merged corner to the other
            valences[alone] = 0
            valences[ends] -= 1
        fell = np.flatnonzero((valences < self.valences) & (valences > 0))
        rest = [corner for corner in fell.tolist() if corner not in removed]
        if self._too_few(valences, rest).any():
            return None
        if self.lines[gone] >= 0:  # its line goes on through the other corner if the vertex between them is gone
            on_line = self.held[kept] or self.lines[kept] == self.lines[gone]
            if not on_line or self.lines[gone] not in self.lines[removed]:
                return None
        return self._with(faces, valences)


def join_around(faces: np.ndarray, vertex: int) -> tuple[np.ndarray, list[int]] | None:
    """(f - 1, 4) with the only two faces at a vertex joined, and its neighbours; None if the result is not a quad."""
    rows, places = np.nonzero(faces == vertex)
    if len(rows) != 2:
        return None
    first, second = (np.roll(faces[row], -place).tolist() for row, place in zip(rows, places, strict=True))
    if first[1] != second[3] or first[3] != second[1] or first[2] == second[2]:
        return None
    joined = faces.copy()
    joined[rows[0]] = [second[2], *first[1:]]
    return np.delete(joined, rows[1], axis=0), [first[1], first[3]]
