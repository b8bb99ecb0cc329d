# SPDX-License-Identifier: GPL-3.0-or-later
"""How closed polygons wind around one another and around themselves, without an error of discretization.

Gauss's integral over two segments is the area of the directions in which they are seen to cross, over 4 pi (Klenin and
Langowski 2000, "Computation of writhe in modeling of supercoiled DNA", method 1a).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from ...unit_vectors import unit_vectors
from .filaments import Filament

# Pairs of segments per batch.
_BATCH = 250_000
# From this number of pairs on, segments farther apart than _APART times their lengths are replaced by their middles,
# which is exact to a thousandth and ten times as fast; and the largest number of pairs, of 0.1 microseconds each.
_MANY_PAIRS, _APART = 2_000_000, 8.0
MOST_PAIRS = 200_000_000


@dataclass(frozen=True)
class Linked:
    """How filaments that come back to themselves wind.

    Attributes
    ----------
    loops : (k,) which of the filaments these are
    numbers : (k, k) linking numbers, in a periodic box with all images of the other one, on the diagonal with its own
    all_writhes : (n,) of all filaments; of open ones, and of once around the box, as they are
    helicity : sum of circulations squared times writhe, and of products of circulations times linking numbers: that of
        the flow of these filaments, but for the twist inside each
    """

    loops: tuple[int, ...]
    numbers: np.ndarray
    all_writhes: np.ndarray
    helicity: float

    @property
    def writhes(self) -> np.ndarray:
        """(k,) of those that come back to themselves."""
        return self.all_writhes[list(self.loops)]


def linking_numbers(lines: Sequence[Filament], box: ArrayLike) -> Linked | None:
    """Compute the :class:`Linked` of filaments; None if that would take more than ``MOST_PAIRS`` pairs of segments.

    ``box`` has the (3,) lengths of the periods of the box that they are in, 0 along axes without a period.
    """
    loops = [k for k, line in enumerate(lines) if line.is_loop]
    points, strengths = [lines[k].points for k in loops], np.array([lines[k].strength for k in loops])
    images = [
        (i, j, move)
        for i in range(len(loops))
        for j in range(i, len(loops))
        for move in _moves_beside(points[i], points[j], np.asarray(box, float))
        if i != j or any(move)
    ]
    pairs = sum(len(line.points) ** 2 for line in lines) + sum(len(points[i]) * len(points[j]) for i, j, _ in images)
    if pairs > MOST_PAIRS:
        return None
    numbers = np.zeros((len(loops), len(loops)))
    for i, j, move in images:
        numbers[i, j] += np.rint(linking_number(points[i], points[j] + move))
    numbers = np.triu(numbers) + np.triu(numbers, 1).T
    writhes = np.array(
        [writhe(line.points) if line.is_loop else _gauss(line.whole, line.whole, False) for line in lines]
    )
    helicity = strengths @ (numbers + np.diag(writhes[loops])) @ strengths if loops else 0.0
    return Linked(tuple(loops), numbers.astype(int), writhes, float(helicity))


def _moves_beside(first: np.ndarray, second: np.ndarray, box: np.ndarray) -> list[tuple[float, ...]]:
    """Moves by whole boxes that bring the box around the second curve to that around the first."""
    low, high = first.min(axis=0) - second.max(axis=0), first.max(axis=0) - second.min(axis=0)
    ways = []
    for least, most, length in zip(low, high, box, strict=True):
        steps = np.arange(np.ceil(least / length), np.floor(most / length) + 1) * length if length else np.zeros(1)
        ways.append(steps.tolist() if length else [0.0] * bool(least <= 0 <= most))
    return list(product(*ways))


def linking_number(first: np.ndarray, second: np.ndarray) -> float:
    """How often a closed polygon passes through another one: (p, 3) and (q, 3) points, a whole number as a float."""
    return _gauss(first, second)


def writhe(points: np.ndarray) -> float:
    """Mean of the signed crossings of a closed polygon of (p, 3) points with itself, over all directions."""
    return _gauss(points, points)


def _gauss(first: np.ndarray, second: np.ndarray, closed: bool = True) -> float:
    """Gauss's double integral over 4 pi, of polygons, or of polylines that are not closed."""
    if closed:
        first, second = np.vstack([first, first[:1]]), np.vstack([second, second[:1]])
    a, b, c, d = first[:-1], first[1:], second[:-1], second[1:]
    is_long = len(a) * len(c) > _MANY_PAIRS
    total, rows = 0.0, max(1, _BATCH // max(len(c), 1))
    for start in range(0, len(a), rows):
        part = slice(start, start + rows)
        ends = a[part, None], b[part, None], c[None], d[None]
        if is_long:
            far, near = _far_areas(*ends)
            i, j = np.nonzero(near)
            total += far
            ends = a[part][i], b[part][i], c[j], d[j]
        total += _crossed_areas(*ends).sum()
    return float(total / (4 * np.pi))


def _far_areas(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> tuple[float, np.ndarray]:
    """Sum of the areas of segments that are far from each other, by Gauss's integrand at their middles, and which pairs
    are near."""
    along, across = b - a, d - c
    between = 0.5 * (a + b - c - d)
    squares = _dot(between, between)
    lengths = np.sqrt(_dot(along, along)) + np.sqrt(_dot(across, across))
    near = squares < (_APART * lengths) ** 2
    # The triple product of along, across and between, row by row: no array of vectors for each pair but one.
    products = _dot(np.cross(along, between), -across)
    return float((products / np.where(near, np.inf, squares) ** 1.5).sum()), near


def _crossed_areas(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Signed areas of the directions in which segments a-b and c-d cross; 0 for those that meet or lie in a plane."""
    ac, ad, bc, bd = c - a, d - a, c - b, d - b
    normals = [unit_vectors(np.cross(u, v)) for u, v in ((ac, ad), (ad, bd), (bd, bc), (bc, ac))]
    sines = sum(np.arcsin(np.clip(_dot(normals[k - 1], normals[k]), -1, 1)) for k in range(4))
    side = _dot(np.cross(d - c, b - a), ac)
    # Segments with an end in common lie in a plane, whatever rounding makes of the side.
    apart = np.all([np.any(normal, axis=-1) for normal in normals], axis=0)
    return np.where(apart, sines * np.sign(side), 0)


def _dot(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.einsum("...x,...x->...", u, v)
