# SPDX-License-Identifier: GPL-3.0-or-later
"""Angles from pairwise differences most of which are wrong (Singer 2011).

    minimize  sum over pairs ij of  |phi_j - g_ij phi_i|^2   over unit numbers phi

where g_ij is the true difference with probability p and uniformly random otherwise. Singer showed that the leading
eigenvector has something of the truth z when p > 1 / sqrt(n), and by the theory of spiked random matrices its
correlation |<phi, z>| / n tends to sqrt(1 - (1 - p^2) / (n p^2)). The semidefinite relaxation is as good, and where it
has rank one it proves that no other angles fit as well (Bandeira, Boumal and Singer 2017).

    python examples/angular_synchronization.py [NODES]
"""

import sys

import numpy as np

from synch_fields.core.connection import Connection
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solve import Options, solve

# Shares of right differences in units of the threshold, and the relative gap below which a solution is proved best.
SHARES = (0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0)
TIGHT = 1e-3


def measured(count, share, seed):
    """The :class:`Connection` of measured differences, and the (n,) true phases."""
    random = np.random.default_rng(seed)
    truth = np.exp(2j * np.pi * random.random(count))
    edges = np.transpose(np.triu_indices(count, 1))
    wrong = random.random(len(edges)) >= share
    transports = truth[edges[:, 1]] * truth[edges[:, 0]].conj()
    transports[wrong] = np.exp(2j * np.pi * random.random(wrong.sum()))
    return Connection(count, edges, np.ones(len(edges)), transports), truth


def main(count=150, shares=SHARES):
    rows = []
    print("right / threshold  theory  spectral     sdp  proved best")
    for share in shares:
        right = share / np.sqrt(count)
        connection, truth = measured(count, right, seed=1)
        problem = SynchronizationProblem(connection)
        theory = np.sqrt(max(1 - (1 - right**2) / (count * right**2), 0))
        solutions = [solve(problem, Options(method=method, target_gap=TIGHT / 2)) for method in ("spectral", "sdp")]
        spectral, sdp = (abs(np.vdot(truth, solution.phases)) / count for solution in solutions)
        is_best = solutions[1].gap < TIGHT
        rows.append((share, theory, spectral, sdp, is_best))
        print(f"{share:17g}  {theory:6.3f}  {spectral:8.3f}  {sdp:6.3f}  {'yes' if is_best else 'no'}")
    return rows


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
