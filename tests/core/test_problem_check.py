# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays that make no problem are refused by one line that names the element."""

import numpy as np
import pytest

from synch_fields.core.connection import Connection, are_flips
from synch_fields.core.errors import SettingError
from synch_fields.core.problem import Merged, SynchronizationProblem, Targets
from synch_fields.core.problem_check import _far_from_orthogonal
from synch_fields.core.solve import solve

EDGES, ONES = np.array([[0, 1], [1, 2], [2, 0]]), np.ones(3)
NAN = np.array([1, np.nan, 1])


def problem(count=3, edges=EDGES, weights=ONES, transports=ONES, **parts):
    return SynchronizationProblem(Connection(count, edges, weights, transports), **parts)


def targets(nodes=(0,), values=(1.0,), weights=None):
    return Targets(np.array(nodes), np.array(values), None if weights is None else np.array(weights))


@pytest.mark.parametrize(
    ("parts", "line"),
    [
        ({"count": 0}, "the connection has 0 nodes"),
        ({"count": 2.5}, "the connection has 2.5 nodes"),
        ({"edges": EDGES[:, :1]}, r"edges have the shape \(3, 1\): give two nodes"),
        ({"edges": EDGES + 0.5}, "edges are given as float64: give whole numbers"),
        ({"edges": EDGES + 1}, r"edge 1 is \[2, 3\] of 3 nodes"),
        ({"edges": EDGES - 1}, r"edge 0 is \[-1, 0\] of 3 nodes"),
        ({"weights": np.ones(2)}, r"weight of edges has the shape \(2,\): give 3 numbers"),
        ({"weights": NAN}, "the weight of edge 1 is nan"),
        ({"weights": np.array([1, 1, np.inf])}, "the weight of edge 2 is inf"),
        ({"weights": np.array([-1, 1, 1])}, "the weight of edge 0 is -1:"),
        ({"transports": np.ones(2)}, "there are 2 transports for 3 edges"),
        ({"transports": NAN}, r"the transport of edge 1 is nan: it needs modulus 1"),
        ({"transports": 2 * ONES}, "the transport of edge 0 is 2.0: it needs modulus 1"),
        ({"transports": np.ones((3, 2, 2))}, "the transport of edge 0 is .* it needs orthogonal columns of length 1"),
        ({"transports": np.ones((3, 2))}, r"transports of edges have the shape \(3, 2\)"),
        ({"mass": -ONES}, "the mass of node 0 is -1.0"),
        ({"mass": NAN}, "the mass of node 1 is nan"),
        ({"mass": np.ones(4)}, r"mass of nodes has the shape \(4,\): give 3 numbers"),
        ({"merged": Merged(np.array([9]), np.array([0]), np.ones(1))}, "merged node 0 is 9 of 3 nodes"),
        ({"merged": Merged(np.array([1]), np.array([7]), np.ones(1))}, "root of merged nodes 0 is 7 of 3 nodes"),
        ({"merged": Merged(np.array([1]), np.array([0, 2]), np.ones(1))}, "there are 2 roots for 1 merged nodes"),
        ({"merged": Merged(np.array([1]), np.array([0]), np.ones(2))}, "there are 2 transports for 1 merged nodes"),
        ({"fixed": targets(nodes=[7])}, "fixed node 0 is 7 of 3 nodes"),
        ({"fixed": targets(values=[5.0])}, "the value of fixed node 0 is 5.0: it needs the length 1"),
        ({"fixed": targets(nodes=[0, 1])}, r"values of fixed nodes have the shape \(1,\): give \(2,\)"),
        ({"fixed": targets(weights=[1.0])}, "fixed nodes have weights"),
        ({"drawn": targets()}, "drawn nodes have no weights"),
        ({"drawn": targets(weights=[np.nan])}, "the weight of drawn node 0 is nan"),
        ({"drawn": targets(weights=[-2.0])}, "the weight of drawn node 0 is -2.0"),
        ({"drawn": targets(values=[np.nan], weights=[1.0])}, "the value of drawn node 0 is nan"),
    ],
)
def test_what_is_wrong_is_named(parts, line):
    with pytest.raises(SettingError, match=f"^{line}"):
        problem(**parts)


@pytest.mark.parametrize("dimension", [3, 4])
def test_values_of_vectors_have_their_dimension(dimension):
    transports = np.tile(np.eye(dimension), (3, 1, 1))
    with pytest.raises(SettingError, match=rf"values of fixed nodes have the shape \(1,\): give \(1, {dimension}\)"):
        problem(transports=transports, fixed=targets())


def test_lists_are_as_good_as_arrays():
    solution = solve(problem(edges=EDGES.tolist(), weights=[1, 1, 1], transports=[1, 1j, -1j]))
    assert solution.energy == pytest.approx(0, abs=1e-9)
    solution = solve(problem(merged=Merged([2], [1], [1j]), fixed=Targets([0], [1.0]), drawn=Targets([1], [1j], [1])))
    assert solution.phases[2] == pytest.approx(1j * solution.phases[1]) and solution.phases[0] == pytest.approx(1)


@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_orthogonal_matrices_and_flips_are_told_apart_as_by_linear_algebra(size):
    random = np.random.default_rng(size)
    matrices = np.linalg.qr(random.normal(size=(40, size, size)))[0]
    assert not _far_from_orthogonal(matrices).any()
    assert np.array_equal(are_flips(matrices), np.linalg.det(matrices) < 0)
    for row, column in np.ndindex(size, size):
        bent = matrices.copy()
        bent[7, row, column] += 3e-2
        bent[9, row, column] = np.nan
        assert np.flatnonzero(_far_from_orthogonal(bent)).tolist() == [7, 9]
