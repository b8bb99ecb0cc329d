# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Components, trees, look-ups and ragged counting, against loops over the elements."""

import numpy as np
import pytest

from synch_fields.core.graphs import components, find, label_rows, pair_keys, ragged_arange, walk_trees


def labels_by_walking(count, pairs):
    """Labels in the order of the components' first nodes, by a walk from each node that has none yet."""
    beside = {node: set() for node in range(count)}
    for i, j in pairs.tolist():
        beside[i].add(j)
        beside[j].add(i)
    labels, label = [-1] * count, 0
    for node in range(count):
        waiting = [node] if labels[node] < 0 else []
        label += len(waiting)
        while waiting:
            met = waiting.pop()
            labels[met] = label - 1
            waiting += [other for other in beside[met] if labels[other] < 0]
    return labels


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("pair_count", [0, 5, 20, 60])
def test_components_are_those_of_a_walk_and_numbered_by_their_first_nodes(seed, pair_count):
    pairs = np.random.default_rng(seed).integers(0, 40, (pair_count, 2))
    expected = labels_by_walking(40, pairs)
    assert components(40, pairs).tolist() == expected
    assert components(40, np.concatenate([pairs[:, ::-1], pairs])).tolist() == expected


def test_no_nodes_have_no_components():
    assert components(0, np.empty((0, 2), int)).tolist() == []
    assert components(3, []).tolist() == [0, 1, 2]


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("pair_count", [0, 5, 20, 60])
def test_trees_are_walked_from_roots_along_shortest_paths(seed, pair_count):
    random = np.random.default_rng(seed)
    pairs = random.integers(0, 40, (pair_count, 2))
    labels = components(40, pairs)
    roots = np.array([random.permutation(np.flatnonzero(labels == label))[0] for label in range(labels.max() + 1)])
    steps = {root: 0 for root in roots.tolist()}
    for length in range(40):
        for i, j in np.concatenate([pairs, pairs[:, ::-1]]).tolist():
            if steps.get(i) == length:
                steps.setdefault(j, length + 1)
    nodes, before, links = walk_trees(40, pairs, roots)
    assert sorted([*roots.tolist(), *nodes.tolist()]) == list(range(40))
    assert [steps[node] for node in nodes.tolist()] == sorted(steps[node] + 1 for node in before.tolist())
    either_way = [sorted(pair) for pair in pairs.tolist()]
    walked = np.column_stack([nodes, before]).tolist()
    assert links.tolist() == [either_way.index(sorted(step)) for step in walked]
    # Without roots, from the first node of each component.
    firsts = [labels.tolist().index(label) for label in range(labels.max() + 1)]
    for own, given in zip(walk_trees(40, pairs), walk_trees(40, pairs, np.array(firsts)), strict=True):
        np.testing.assert_array_equal(own, given)


def test_pairs_are_found_whichever_way_they_run():
    random = np.random.default_rng(3)
    known, asked = random.integers(0, 7, (20, 2)), random.integers(0, 7, (30, 3, 2))
    either_way = [sorted(pair) for pair in known.tolist()]
    expected = [either_way.index(pair) if pair in either_way else -1 for pair in np.sort(asked).reshape(-1, 2).tolist()]
    assert find(pair_keys(known, 7), pair_keys(asked, 7)).tolist() == np.reshape(expected, (30, 3)).tolist()
    assert -1 in expected and find(np.empty(0, int), np.arange(4)).tolist() == [-1] * 4


def test_pairs_of_many_nodes_have_keys_of_their_own_in_short_integers():
    """On Windows the integers of older NumPy have 32 bits."""
    count = 60_000
    path = np.column_stack([np.arange(count - 1), np.arange(1, count)]).astype(np.int32)
    keys = pair_keys(path, count)
    assert len(np.unique(keys)) == count - 1 and keys.dtype == np.int64
    np.testing.assert_array_equal(keys, pair_keys(path[:, ::-1].astype(np.int64), count))


@pytest.mark.parametrize("counts", [[3, 0, 2, 1], [0, 0], [], [4], *np.random.default_rng(1).integers(0, 4, (5, 9))])
def test_ragged_arange_counts_within_each_row(counts):
    rows, places = ragged_arange(np.array(counts, int))
    expected = [(row, place) for row, count in enumerate(counts) for place in range(count)]
    assert list(zip(rows.tolist(), places.tolist(), strict=True)) == expected


@pytest.mark.parametrize("shape", [(0, 3), (1, 2), (200, 1), (500, 4)])
def test_equal_rows_have_equal_labels_in_their_order(shape):
    rows = np.random.default_rng(0).integers(-3, 4, shape)
    assert np.array_equal(label_rows(rows), np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1))
