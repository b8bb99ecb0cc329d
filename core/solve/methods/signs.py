# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields of signs, one real number a node, as in MAX-CUT: signs cannot move a little, they flip.

Two fields cross exactly: where they differ, each connected region is taken from the one that has less energy there. In
sparse graphs, such as planar ones, these regions are many and small, and a knock-out of many fields comes near the
optimum; in dense ones most of the graph is one region, and crossing gains nothing. Copies of a field are shaken by
annealing, and a knock-out keeps what each of them gained anywhere.
"""

from collections.abc import Callable, Iterator

import numpy as np
from scipy.sparse import csr_matrix

from ...graphs import components
from ...monitor import Monitor

# Gains of energy below this share of a node's diagonal are rounding.
LEAST_GAIN = 1e-5
# Sweeps in which flips that cost nothing are made, too, each by the toss of a coin.
FREE_SWEEPS = 20
# Numbers that are worked on at once.
MOST_AT_ONCE = 4_000_000
# Times that the best field is shaken, the most copies of it, and the heats of their sweeps: a flip that costs energy is
# made with probability exp(-cost / 4 heat), for edges of weight 1.
SHAKES, COPIES = 3, 64
HEATS = np.linspace(1, 0.1, 15)


class Flips:
    """Moves that lower the energy of signs, for a real (N, N) matrix."""

    def __init__(self, matrix: csr_matrix) -> None:
        self._matrix = matrix
        self._diagonal = matrix.diagonal()
        entries = matrix.tocoo()
        above = entries.row < entries.col
        weights = entries.data[above]
        self._edges = entries.row[above], entries.col[above], weights[:, None]
        self._weight = np.abs(weights).mean() if len(weights) else 1.0
        # The nodes of an independent set have no edges to one another and can flip at the same time.
        classes = [np.flatnonzero(members) for members in _independent_sets(matrix)]
        self._classes = [(nodes, matrix[nodes], self._diagonal[nodes][:, None]) for nodes in classes]

    def descend(self, columns: np.ndarray, random: np.random.Generator | None = None) -> np.ndarray:
        """(N, k) signs after flips of single nodes that each lower the energy, until no flip does.

        With a random generator, the first sweeps also make flips that cost nothing, each by the toss of a coin.
        """
        columns = np.where(columns < 0, -1, 1).astype(self._matrix.dtype)  # to the last digit
        sweep, changed = 0, True
        while changed:
            changed = False
            for nodes, rows, diagonal in self._classes:
                own = columns[nodes]
                gains = own * (rows @ columns) - diagonal
                least = LEAST_GAIN * diagonal
                flips = gains > least
                changed |= bool(flips.any())
                if random is not None and sweep < FREE_SWEEPS:
                    changed = True
                    flips |= (gains >= -least) & (random.random(gains.shape, np.float32) < 0.5)
                columns[nodes] = np.where(flips, -own, own)
            sweep += 1
        return columns

    def shake(self, columns: np.ndarray, random: np.random.Generator) -> np.ndarray:
        """(N, k) signs after simulated annealing (Kirkpatrick et al. 1983)."""
        for heat in HEATS:
            for nodes, rows, diagonal in self._classes:
                own = columns[nodes]
                gains = own * (rows @ columns) - diagonal
                flips = random.random(gains.shape, np.float32) < np.exp(np.minimum(gains / (heat * self._weight), 0))
                columns[nodes] = np.where(flips, -own, own)
        return columns

    def cross(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """(N, k) signs: the first of each pair of columns, with every region of the second that costs nothing."""
        tails, heads, weights = self._edges
        count, pairs = first.shape
        least = LEAST_GAIN * self._diagonal.mean()
        places = np.arange(count * pairs).reshape(count, pairs)
        for other in (second, -second):
            differ = first != other
            at_tail, at_head = differ[tails], differ[heads]
            inside, border = at_tail & at_head, at_tail != at_head
            regions = components(count * pairs, np.column_stack([places[tails][inside], places[heads][inside]]))
            products = (weights * first[tails] * first[heads])[border]
            owners = regions[np.where(at_tail, places[tails], places[heads])[border]]
            costs = -np.bincount(owners, products, count * pairs)
            first = np.where(differ & (costs[regions] <= least).reshape(count, pairs), other, first)
        return first

    def knock_out(self, columns: np.ndarray, random: np.random.Generator, monitor: Monitor) -> np.ndarray:
        """(N, 1) signs: the columns are crossed in pairs, and the results again, until one is left."""
        while columns.shape[1] > 1:
            half, rest = columns.shape[1] // 2, columns[:, columns.shape[1] // 2 * 2 :]
            winners = []
            for pairs in np.array_split(np.arange(half), -(-half * self._matrix.nnz // MOST_AT_ONCE)):
                monitor.check()
                winners.append(self.descend(self.cross(columns[:, pairs], columns[:, half + pairs]), random))
            columns = np.hstack([*winners, rest])
        return columns


def _independent_sets(matrix: csr_matrix) -> Iterator[np.ndarray]:
    """(N,) bool arrays of independent sets, which together have every node once (Luby 1986)."""
    size = matrix.shape[0]
    waiting = np.random.default_rng(0).permutation(size) + 1
    starts, indices = matrix.indptr[:-1], matrix.indices
    while (waiting > 0).any():
        first = (waiting > 0) & (waiting == np.maximum.reduceat(waiting[indices], starts))
        yield first
        waiting = np.where(first, 0, waiting)


def knock_outs(
    flips: Flips, seeds: Callable[[int], np.ndarray], found: np.ndarray, random: np.random.Generator, monitor: Monitor
) -> np.ndarray:
    """(N, k) signs, of less energy than those found so far where possible, and these.

    ``seeds(most)`` gives at most that many columns of signs, others each time; ``found`` is (N, k), best first.
    """
    many = max(MOST_AT_ONCE // len(found), 2)
    monitor.check()
    winner = flips.knock_out(flips.descend(seeds(many), random), random, monitor)
    best = flips.knock_out(np.hstack([found[:, :1], winner]), random, monitor)
    for _ in range(SHAKES):
        monitor.check()
        copies = flips.shake(np.repeat(best, min(many, COPIES), axis=1), random)
        best = flips.knock_out(np.hstack([best, flips.descend(copies)]), random, monitor)
    return np.hstack([best, winner, found])
