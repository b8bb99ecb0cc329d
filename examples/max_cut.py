# SPDX-License-Identifier: GPL-3.0-or-later
"""MAX-CUT: split the nodes of a weighted graph in two so that the edges between weigh most.

    maximize  sum over edges ij of  w_ij (1 - x_i x_j) / 2   over signs x                (Goemans and Williamson 1995)

An edge of positive weight asks for opposite signs, x_j = -x_i, one of negative weight for equal ones; each costs
4 |w_ij| where it does not get them, so that the cut is the sum of the positive weights less a fourth of the energy. The
energy's lower bound is an upper bound of every cut.

    python examples/max_cut.py [GRAPH.txt]    in the format of the Gset graphs: nodes and edges, i j weight, from 1

Without a file, the graph is a grid on a torus, with weights 1 and -1 drawn at random.
"""

import sys
import time

import numpy as np

from synch_fields.core.connection import Connection
from synch_fields.core.errors import SynchError
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solve import Options, solve


def read_graph(path):
    """The nodes' number, (e, 2) edges and (e,) weights of a text file; weights that are left out are 1."""
    with open(path, encoding="utf-8") as file:
        (count, edge_count, *_), *rows = (line.split() for line in file if line.strip())
    table = np.array([[*row, "1"][:3] for row in rows], float)
    if len(table) != int(edge_count):
        raise SynchError(f"{path} tells of {edge_count} edges and has {len(table)}: fetch it again")
    return int(count), table[:, :2].astype(int) - 1, table[:, 2]


def cylinder(around, along, seed, closed=False):
    """Number of nodes of a square grid that is closed around, and along if ``closed``; its edges, those around first;
    weights 1 or -1 at random."""
    number = np.arange(around * along).reshape(along, around)
    between = np.column_stack([number.ravel(), np.roll(number, -1, 0).ravel()])
    edges = np.concatenate([np.column_stack([number.ravel(), np.roll(number, -1, 1).ravel()]), between])
    edges = edges if closed else edges[:-around]
    return number.size, edges, np.random.default_rng(seed).choice([-1.0, 1.0], len(edges))


def cut_problem(count, edges, weights):
    """The problem whose energy is four times what a cut falls short of the sum of the positive weights."""
    transports = -np.sign(weights).reshape(-1, 1, 1)
    transports[weights == 0] = 1
    return SynchronizationProblem(Connection(count, edges, np.abs(weights), transports))


def main(path=None, target_gap=1e-3):
    count, edges, weights = read_graph(path) if path else cylinder(20, 20, seed=0, closed=True)
    begin = time.perf_counter()
    solution = solve(cut_problem(count, edges, weights), Options(target_gap=target_gap))
    signs = solution.phases[:, 0]
    cut = weights[signs[edges[:, 0]] != signs[edges[:, 1]]].sum()
    at_most = np.maximum(weights, 0).sum() - solution.lower_bound / 4
    print(f"{count} nodes, {len(edges)} edges: a cut of {cut:g}; none is above {at_most:.2f} ({solution.certificate})")
    print(f"{time.perf_counter() - begin:.1f} seconds")
    return cut, at_most


if __name__ == "__main__":
    main(*sys.argv[1:2])
