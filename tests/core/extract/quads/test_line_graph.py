# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Graphs drawn by hand: their faces, and what is left of them when chains and slivers are taken out."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import Delaunay

from synch_fields.core.extract.quads.trace.line_graph import LineGraph


def drawn(points, edges, border=(), kept=()):
    """A graph of straight edges between points in the plane; those in ``border`` have the surface on their left."""
    points, edges = np.asarray(points, float), np.asarray([*border, *edges])
    ways = points[edges[:, 1]] - points[edges[:, 0]]
    angles = np.arctan2(ways[:, 1], ways[:, 0])
    outside = np.zeros((len(edges), 2), bool)
    outside[: len(border), 1] = True
    keeps = np.zeros(len(points), bool)
    keeps[list(kept)] = True
    return LineGraph(
        edges.ravel(),
        np.column_stack([angles, (angles + 2 * np.pi) % (2 * np.pi) - np.pi]).ravel(),
        outside.ravel(),
        keeps,
    )


def faces(graph):
    """Nodes around each face, from the lowest on, sorted."""
    darts, sizes = graph.faces()
    found = []
    for part in np.split(darts, np.cumsum(sizes)[:-1]) if len(sizes) else []:
        np.testing.assert_array_equal(graph.next[part], np.roll(part, -1))
        nodes = graph.tails[part].tolist()
        first = nodes.index(min(nodes))
        found.append(tuple(nodes[first:] + nodes[:first]))
    return sorted(found)


def edges(graph):
    return sorted(tuple(sorted(pair)) for pair in graph.tails.reshape(-1, 2).tolist())


def lattice(columns, rows):
    """Points and edges of a grid, the points numbered along the columns."""
    points = [(i, j) for j in range(rows + 1) for i in range(columns + 1)]
    number = {p: k for k, p in enumerate(points)}
    across = [(number[i, j], number[i + 1, j]) for i, j in points if i < columns]
    up = [(number[i, j], number[i, j + 1]) for i, j in points if j < rows]
    return points, across + up, number


def framed(columns, rows):
    """Points of a grid, its rim counterclockwise, and the edges inside."""
    points, all_edges, number = lattice(columns, rows)
    ring = [(i, 0) for i in range(columns)] + [(columns, j) for j in range(rows)]
    ring += [(columns - i, rows) for i in range(columns)] + [(0, rows - j) for j in range(rows)]
    rim = [(number[a], number[b]) for a, b in zip(ring, ring[1:] + ring[:1], strict=True)]
    inside = [e for e in all_edges if e not in rim and e[::-1] not in rim]
    return points, rim, inside, number


def subdivided(points, pairs, pieces):
    """Every edge as a chain of one to ``pieces`` edges."""
    points, chains = [tuple(p) for p in points], []
    random = np.random.default_rng(len(pairs))
    for a, b in pairs:
        count = int(random.integers(1, pieces + 1))
        shares = np.arange(1, count) / count
        middles = [tuple((1 - s) * np.array(points[a]) + s * np.array(points[b])) for s in shares]
        nodes = [a, *range(len(points), len(points) + count - 1), b]
        points += middles
        chains += list(pairwise(nodes))
    return points, chains


# A walk around the faces


def test_a_square_with_a_diagonal_has_two_triangles_and_its_outside():
    graph = drawn([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1), (1, 2), (2, 3), (3, 0), (0, 2)])
    assert faces(graph) == [(0, 1, 2), (0, 2, 3), (0, 3, 2, 1)]
    assert graph.degrees.tolist() == [3, 2, 3, 2]
    # Dart 0 leaves 0 for 1; on its left the triangle goes on to 2, on the right the outside comes back from 1.
    assert (graph.tails[graph.next[0]], graph.heads[graph.next[0]]) == (1, 2)
    assert (graph.tails[graph.next[1]], graph.heads[graph.next[1]]) == (0, 3)


def test_where_the_boundary_is_known_the_outside_is_no_face():
    rim = [(0, 1), (1, 2), (2, 3), (3, 0)]
    graph = drawn([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 2)], border=rim)
    assert faces(graph) == [(0, 1, 2), (0, 2, 3)]


@pytest.mark.parametrize(("columns", "rows"), [(1, 1), (3, 2), (5, 4)])
def test_a_grid_has_its_cells(columns, rows):
    points, rim, inside, number = framed(columns, rows)
    cells = [
        (number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1])
        for i in range(columns)
        for j in range(rows)
    ]
    assert faces(drawn(points, inside, border=rim)) == sorted(cells)


@pytest.mark.parametrize("seed", range(5))
def test_a_triangulation_has_its_triangles(seed):
    random = np.random.default_rng(seed)
    points = random.random((25, 2))
    triangulation = Delaunay(points)
    pairs = np.unique(np.sort(triangulation.simplices[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    graph = drawn(points, random.permuted(pairs, axis=1)[random.permutation(len(pairs))])
    found = faces(graph)
    triangles = {frozenset(t) for t in triangulation.simplices.tolist()}
    assert {frozenset(f) for f in found if len(f) == 3} >= triangles
    assert len(found) == len(triangles) + 1  # and the outside
    for face in found:
        a, b = points[list(face)], points[list(face[1:] + face[:1])]
        area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()
        assert (area > 0) == (frozenset(face) in triangles)


def test_a_grid_on_a_torus_has_its_cells():
    """Keys alone say how edges stand around a node; no drawing in the plane could."""
    columns, rows = 4, 3
    tails, keys = [], []
    for i in range(columns):
        for j in range(rows):
            here, right, up = i * rows + j, (i + 1) % columns * rows + j, i * rows + (j + 1) % rows
            tails += [here, right, here, up]
            keys += [0, 2, 1, 3]  # east, west, north, south
    count = columns * rows
    graph = LineGraph(np.array(tails), np.array(keys), np.zeros(len(tails), bool), np.zeros(count, bool))
    found = faces(graph)
    assert len(found) == count and {len(f) for f in found} == {4}
    cells = []
    for i in range(columns):
        for j in range(rows):
            ring = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            ring = [a % columns * rows + b % rows for a, b in ring]
            first = ring.index(min(ring))
            cells.append(tuple(ring[first:] + ring[:first]))
    assert found == sorted(cells)
    assert edges(graph.cleaned()) == edges(graph)


def test_an_edge_less_joins_the_faces_on_both_sides():
    points, rim, inside, _ = framed(4, 3)
    graph = drawn(points, inside, border=rim)
    labels = graph.face_labels
    for edge in range(len(rim), len(rim) + len(inside)):
        first, second = labels[2 * edge], labels[2 * edge + 1]
        keep = np.ones(len(graph.tails) // 2, bool)
        keep[edge] = False
        merged = graph.with_edges(keep)
        assert first != second
        assert sorted(merged.faces()[1]) == sorted([6] + [4] * (len(graph.faces()[1]) - 2))
        assert merged.outside.sum() == len(rim)


# Chains


@pytest.mark.parametrize("pieces", [1, 2, 5])
def test_chains_become_the_edges_that_they_were_made_of(pieces):
    random = np.random.default_rng(pieces)
    points = random.random((20, 2))
    simplices = Delaunay(points).simplices
    pairs = np.unique(np.sort(simplices[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0).tolist()
    whole = drawn(points, pairs)
    corners = np.flatnonzero(whole.degrees == 2)
    graph = drawn(*subdivided(points, pairs, pieces), kept=corners).contracted()
    assert edges(graph) == edges(whole)
    assert faces(graph) == faces(whole)


def test_two_edges_at_a_corner_of_the_boundary_stay_two():
    points, rim, inside, number = framed(3, 3)
    corners = [number[p] for p in ((0, 0), (3, 0), (0, 3), (3, 3))]
    whole = drawn(points, inside, border=rim, kept=corners)
    assert edges(whole.contracted()) == edges(whole)
    cut = drawn(points, inside, border=rim).contracted()
    assert sorted(cut.faces()[1]) == [3] * 4 + [4] * 5
    assert cut.outside.sum() == len(rim) - 4


@pytest.mark.parametrize("length", [1, 2, 4])
def test_chains_with_a_loose_end_go(length):
    points, rim, inside, number = framed(2, 2)
    start = number[1, 1]
    whole = drawn(points, inside, border=rim, kept=range(len(points)))
    tail = [(1 + 0.3 * s / length, 1 + 0.2 * s / length) for s in range(1, length + 1)]
    nodes = [start, *range(len(points), len(points) + length)]
    dangling = list(pairwise(nodes))
    alone = [(0.2, 0.2), (0.3, 0.2), (0.4, 0.3)]
    island = [(nodes[-1] + 1, nodes[-1] + 2), (nodes[-1] + 2, nodes[-1] + 3)]
    graph = drawn([*points, *tail, *alone], [*inside, *dangling, *island], border=rim, kept=range(len(points)))
    assert len(graph.faces()[1]) == 5  # the island has a face of its own around it
    assert edges(graph.contracted()) == edges(whole)
    assert faces(graph.contracted()) == faces(whole)


def test_a_closed_chain_that_nothing_meets_goes():
    points, rim, inside, _ = framed(1, 1)
    ring = [(0.3, 0.3), (0.6, 0.3), (0.4, 0.6)]
    graph = drawn([*points, *ring], [*inside, (4, 5), (5, 6), (6, 4)], border=rim, kept=range(4))
    assert edges(graph.contracted()) == edges(drawn(points, inside, border=rim, kept=range(4)))


def test_a_chain_from_a_node_to_itself_becomes_a_loop():
    points = [(0, 0), (1, 0), (1, 1), (0, 1), (-1, -1), (-1, 1)]
    spokes = [(0, 4), (0, 5)]
    graph = drawn(points, [(0, 1), (1, 2), (2, 3), (3, 0), *spokes], kept=[4, 5]).contracted()
    assert edges(graph) == [(0, 0), (0, 4), (0, 5)]
    assert (0,) in faces(graph)  # the inside of the loop


# Slivers


def test_a_theta_is_two_digons_and_nothing_remains_of_it():
    points = [(-1, 0), (1, 0), (0, 1), (0, 0), (0, -1)]
    graph = drawn(points, [(0, 2), (2, 1), (0, 3), (3, 1), (0, 4), (4, 1)])
    assert faces(graph.contracted()) == [(0, 1)] * 3
    assert len(graph.cleaned().tails) == 0
    held = drawn(points, [(0, 2), (2, 1), (0, 3), (3, 1), (0, 4), (4, 1)], kept=[0, 1])
    assert edges(held.cleaned()) == [(0, 1)]


@pytest.mark.parametrize("fold", [2, 3, 5])
def test_edges_side_by_side_become_one(fold):
    """A line that runs to and fro: digons in the middle of a grid, one beside the other."""
    points, rim, inside, number = framed(4, 3)
    a, b = number[1, 1], number[2, 1]
    kept = [number[p] for p in ((0, 0), (4, 0), (0, 3), (4, 3))]
    whole = drawn(points, inside, border=rim, kept=kept)
    detours, extra = [], []
    for k in range(1, fold):
        detours.append((1.5, 1 + 0.3 * k / fold))
        extra += [(a, len(points) + k - 1), (len(points) + k - 1, b)]
    graph = drawn([*points, *detours], [*inside, *extra], border=rim, kept=kept)
    assert sorted(graph.contracted().faces()[1]) == [2] * (fold - 1) + [4] * 12
    assert edges(graph.cleaned()) == edges(whole)
    assert faces(graph.cleaned()) == faces(whole)


def test_a_digon_at_the_boundary_leaves_the_boundary():
    points, rim, inside, number = framed(3, 1)
    a, b = number[1, 0], number[2, 0]
    corners = [number[p] for p in ((0, 0), (3, 0), (0, 1), (3, 1))]
    whole = drawn(points, inside, border=rim, kept=corners)
    graph = drawn([*points, (1.5, 0.2)], [*inside, (a, len(points)), (len(points), b)], border=rim, kept=corners)
    assert sorted(graph.contracted().faces()[1]) == [2, 4, 4, 4]
    assert faces(graph.cleaned()) == faces(whole)
    np.testing.assert_array_equal(np.sort(graph.cleaned().outside), np.sort(whole.outside))


def test_a_loop_goes_with_all_that_hangs_on_it():
    points, rim, inside, number = framed(2, 2)
    start = number[1, 1]
    corners = [number[p] for p in ((0, 0), (2, 0), (0, 2), (2, 2))]
    whole = drawn(points, inside, border=rim, kept=corners)
    count = len(points)
    loop = [(1.2, 1.3), (1.4, 1.2), (1.4, 1.4)]
    ways = [(start, count), (count, count + 1), (count + 1, count + 2), (count + 2, count)]
    graph = drawn([*points, *loop], [*inside, *ways], border=rim, kept=corners)
    assert (count,) in faces(graph.contracted())
    assert faces(graph.cleaned()) == faces(whole)


def test_what_becomes_a_sliver_by_cleaning_is_cleaned_too():
    """A digon inside a digon: without the inner one, the chain around it is a side again."""
    points, rim, inside, number = framed(3, 2)
    a, b = number[1, 1], number[2, 1]
    corners = [number[p] for p in ((0, 0), (3, 0), (0, 2), (3, 2))]
    whole = drawn(points, inside, border=rim, kept=corners)
    n = len(points)
    extra = [(1.2, 1.3), (1.8, 1.3), (1.5, 1.2), (1.5, 1.4)]
    ways = [(a, n), (n, n + 2), (n + 2, n + 1), (n, n + 3), (n + 3, n + 1), (n + 1, b)]
    graph = drawn([*points, *extra], [*inside, *ways], border=rim, kept=corners)
    assert sorted(graph.contracted().faces()[1]) == [2, 4, 4, 4, 4, 4, 4, 6]
    assert faces(graph.cleaned()) == faces(whole)


def test_nothing_is_nothing():
    none = np.empty(0, int)
    graph = LineGraph(none, none.astype(float), none.astype(bool), np.zeros(3, bool))
    assert faces(graph.cleaned()) == [] and graph.degrees.tolist() == [0, 0, 0]


def test_a_clean_graph_stays_as_it_is():
    points, rim, inside, number = framed(5, 4)
    corners = [number[p] for p in ((0, 0), (5, 0), (0, 4), (5, 4))]
    graph = drawn(points, inside, border=rim, kept=corners)
    for other in (graph.contracted(), graph.cleaned(), graph.cleaned().cleaned()):
        assert faces(other) == faces(graph) and edges(other) == edges(graph)
