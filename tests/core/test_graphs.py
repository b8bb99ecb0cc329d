# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Components and ragged counting, against loops over the elements."""

import numpy as np
import pytest

from synch_fields.core.graphs import components, ragged_arange


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


@pytest.mark.parametrize("counts", [[3, 0, 2, 1], [0, 0], [], [4], *np.random.default_rng(1).integers(0, 4, (5, 9))])
def test_ragged_arange_counts_within_each_row(counts):
    rows, places = ragged_arange(np.array(counts, int))
    expected = [(row, place) for row, count in enumerate(counts) for place in range(count)]
    assert list(zip(rows.tolist(), places.tolist(), strict=True)) == expected
