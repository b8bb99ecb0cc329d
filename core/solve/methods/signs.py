# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields of signs, one real number a node, as of MAX-CUT: no small move lowers their energy, so that signs flip.

Two fields cross exactly: where they differ, each connected region is taken from the one that has less energy there. In
graphs of few edges a node, as planar ones, such regions are many and small, and a knock-out of many fields comes near
the best there is; in dense ones most of the graph is one region, and crossing gains nothing. Of copies of a field that
are shaken, by heat that fades, a knock-out keeps what each gained anywhere.
"""

import numpy as np

from ...graphs import components

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
    """Moves that lower the energy of signs.

    Parameters
    ----------
    matrix : (N, N) CSR, real
    """

    def __init__(self, matrix):
        self._matrix = matrix
        self._diagonal = matrix.diagonal()
        entries = matrix.tocoo()
        above = entries.row < entries.col
        self._edges = entries.row[above], entries.col[above], entries.data[above][:, None]
        self._weight = np.abs(entries.data[above]).mean()
        classes = [np.flatnonzero(colours) for colours in _independent_sets(matrix)]
        self._classes = [(nodes, matrix[nodes], self._diagonal[nodes][:, None]) for nodes in classes]

    def descended(self, columns, random=None):
        """(N, k) signs after flips of single ones, each of which lowers the energy, until none does.

        With a random generator there are some sweeps before in which flips that cost nothing are made, too.
        """
        columns = np.where(columns < 0, -1, 1).astype(self._matrix.dtype)  # to the last digit
        sweep, changed = 0, True
        while changed:
            is_free = random is not None and sweep < FREE_SWEEPS
            changed = is_free
            for nodes, rows, diagonal in self._classes:
                own = columns[nodes]
                gains = own * (rows @ columns) - diagonal
                least = LEAST_GAIN * diagonal
                flips = gains > least
                changed |= bool(flips.any())
                if is_free:
                    flips |= (gains >= -least) & (random.random(gains.shape, np.float32) < 0.5)
                columns[nodes] = np.where(flips, -own, own)
            sweep += 1
        return columns

    def shaken(self, columns, random):
        """(N, k) signs after sweeps of flips at random that fade (Kirkpatrick et al. 1983)."""
        for heat in HEATS:
            for nodes, rows, diagonal in self._classes:
                own = columns[nodes]
                gains = own * (rows @ columns) - diagonal
                flips = random.random(gains.shape, np.float32) < np.exp(np.minimum(gains / (heat * self._weight), 0))
                columns[nodes] = np.where(flips, -own, own)
        return columns

    def crossed(self, first, second):
        """(N, k) signs of pairs of columns: of the first, with every region where taking the second's costs nothing."""
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

    def knocked_out(self, columns, random, monitor):
        """(N, 1) signs that pairs of columns lead to, crossed again and again until one is left."""
        while columns.shape[1] > 1:
            half, rest = columns.shape[1] // 2, columns[:, columns.shape[1] // 2 * 2 :]
            winners = []
            for pairs in np.array_split(np.arange(half), -(-half * self._matrix.nnz // MOST_AT_ONCE)):
                monitor.check()
                winners.append(self.descended(self.crossed(columns[:, pairs], columns[:, half + pairs]), random))
            columns = np.hstack([*winners, rest])
        return columns


def _independent_sets(matrix):
    """(N,) bool arrays that have every node once, of which no two are neighbours (Luby 1986)."""
    size = matrix.shape[0]
    waiting = np.random.default_rng(0).permutation(size) + 1
    starts, indices = matrix.indptr[:-1], matrix.indices
    while (waiting > 0).any():
        first = (waiting > 0) & (waiting == np.maximum.reduceat(waiting[indices], starts))
        yield first
        waiting = np.where(first, 0, waiting)


def knock_outs(flips, seeds, found, random, monitor):
    """Columns of signs with less energy than those found so far, where they may be had.

    Parameters
    ----------
    flips : Flips
    seeds : callable, number of columns at most -> (N, k) signs, others each time
    found : (N, k) signs, the best first
    random : numpy Generator
    monitor : Monitor
    """
    many = max(MOST_AT_ONCE // len(found), 2)
    monitor.check()
    winner = flips.knocked_out(flips.descended(seeds(many), random), random, monitor)
    best = flips.knocked_out(np.hstack([found[:, :1], winner]), random, monitor)
    for _ in range(SHAKES):
        monitor.check()
        copies = flips.shaken(np.repeat(best, min(many, COPIES), axis=1), random)
        best = flips.knocked_out(np.hstack([best, flips.descended(copies)]), random, monitor)
    return np.hstack([best, winner, found])
