# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""MAX-CUT of sparse graphs: cuts, bounds and seconds, beside the best cuts where these are known.

    python bench/max_cut.py [GRAPH.txt ...] [--target-gap 1e-2]

Without files: square grids closed around with weights 1 and -1 at random, as in Gset's toroidal graphs but open along,
so that dynamic programming gives the best cut; planar graphs that are triangulations of a sphere, whose best cut has a
formula; and bipartite tori, whose edges can all be cut, which is proved. With files, in the format of the Gset graphs:
those, beside the best cuts known of Gset's names. Seconds are of the processor, for the whole solve.
"""

from itertools import product
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull

from synch_fields.bench.command import arguments
from synch_fields.bench.measure import spent
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.solve import Options, solve
from synch_fields.examples.max_cut import cut_problem, cylinder, read_graph

# Nodes around and along of the grids, and of the bipartite tori.
GRIDS = ((10, 500), (12, 830), (14, 1430))
TORI = ((60, 50), (100, 100), (200, 100))
# Nodes of the planar graphs.
SPHERES = (5000, 10000, 20000)
# The best cuts that have been published of some of Gset's graphs, by any method in any time.
BEST_KNOWN = {"G48": 6000, "G49": 6000, "G50": 5880, "G55": 10299, "G56": 4017, "G57": 3494, "G60": 14188, "G61": 5796}
BEST_KNOWN |= {"G62": 4870, "G65": 5562, "G66": 6364, "G67": 6950, "G72": 7008, "G77": 9940, "G81": 14060}
BEST_KNOWN |= {"G35": 7687, "G36": 7680, "G51": 3848, "G52": 3851}
COLUMNS = (
    Column("nodes", "nodes", "d"),
    Column("edges", "edges", "d"),
    Column("best cut", "best", ".0f"),
    Column("ours", "cut", ".0f"),
    Column("short", "short", ".2%"),
    Column("bound", "bound", ".1f"),
    Column("certificate", "certificate", ""),
    Column("s CPU", "seconds", ".2f"),
)


def main():
    """Print the table."""
    parser = arguments(__doc__)
    parser.add_argument("graphs", type=Path, nargs="*", metavar="GRAPH.txt")
    parser.add_argument("--target-gap", type=float, default=1e-2, help="of the relaxation (%(default)s)")
    options = parser.parse_args()
    rows = [row(label, graph, best, options.target_gap) for label, graph, best in subjects(options.graphs)]
    print_table("MAX-CUT", COLUMNS, rows, "graph")


def subjects(paths):
    """Name, graph and best cut, where that is known, of each graph: of the files, or of those that are made here."""
    for path in paths:
        yield path.stem, read_graph(path), BEST_KNOWN.get(path.stem)
    if paths:
        return
    for number, (around, along) in enumerate(GRIDS):
        graph = cylinder(around, along, number)
        yield f"{around} x {along}, ±1", graph, best_cut(around, along, graph[2])
    for count in SPHERES:
        yield f"planar, {count} nodes", triangulation(count), 2 * count - 4
    for around, along in TORI:
        count, edges, weights = cylinder(around, along, 0, closed=True)
        yield f"{around} x {along}, bipartite torus", (count, edges, np.ones(len(weights))), len(weights)


def row(label, graph, best, target_gap):
    """What is measured of a graph: number of nodes, edges and weights."""
    count, edges, weights = graph
    solution, seconds = spent(solve, cut_problem(*graph), Options(target_gap=target_gap))
    cut = cut_of(solution, edges, weights)
    return {
        "label": label,
        "nodes": count,
        "edges": len(edges),
        "best": best,
        "cut": cut,
        "short": None if best is None else 1 - cut / best,
        "bound": np.maximum(weights, 0).sum() - solution.lower_bound / 4,
        "certificate": solution.certificate,
        "seconds": seconds,
    }


def cut_of(solution, edges, weights):
    """Weight of the edges between nodes of different signs."""
    signs = solution.phases[:, 0]
    return weights[signs[edges[:, 0]] != signs[edges[:, 1]]].sum()


def triangulation(count):
    """Number of nodes, edges and weights of 1 of the convex hull of random points on a sphere.

    In every triangle an edge is not cut. The dual graph has no bridge, so its edges hold a perfect matching (Petersen
    1891): one edge for two of the 2 n - 4 triangles is enough, and 2 n - 4 of the 3 n - 6 edges are cut.
    """
    points = np.random.default_rng(count).normal(size=(count, 3))
    triangles = ConvexHull(points / np.linalg.norm(points, axis=1, keepdims=True)).simplices
    edges = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    return count, edges, np.ones(len(edges))


def best_cut(around, along, weights):
    """The largest cut of a :func:`cylinder`, by dynamic programming over the signs of one ring."""
    signs = np.array(list(product((-1.0, 1.0), repeat=around))).T
    of_rings = weights[: around * along].reshape(along, -1)
    between = weights[around * along :].reshape(along - 1, -1)

    def within(ring):
        return (of_rings[ring][:, None] * (1 - signs * np.roll(signs, -1, 0)) / 2).sum(axis=0)

    best = within(0)
    for ring in range(1, along):
        for place, weight in enumerate(between[ring - 1]):  # one sign after the other crosses to the next ring
            cells = best.reshape(2**place, 2, -1)
            best = np.maximum(cells, cells[:, ::-1] + weight).ravel()  # kept, or changed and the edge cut
        best = best + within(ring)
    return best.max()


if __name__ == "__main__":
    main()
