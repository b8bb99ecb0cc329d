# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Value and bounds of the relaxation against closed forms, an interior-point method, dense eigenvalues and pymanopt."""

from itertools import product

import numpy as np
import pytest
from scipy.linalg import eigh

from synch_fields.core.connection import Connection
from synch_fields.core.fields import Row, given_directions
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solve import Options, Status, solve
from synch_fields.core.solve.methods.staircase import start_rank

from ..direction_wishes import bordered_problem, boundary_row
from ..graphs import PROBLEMS, half_turned_stripes, lifted_matrix, only_piece, random_connection, relaxation
from ..meshes import bent_square, bumpy_torus, icosphere, torus

TIGHT = Options(target_gap=1e-6)


def max_cut(edges):
    """Edges that want their ends to differ: the energy is four times the number of uncut edges."""
    edges = np.array(edges)
    return Connection(edges.max() + 1, edges, np.ones(len(edges)), -np.ones((len(edges), 1, 1)))


def cycle(n):
    return [(k, (k + 1) % n) for k in range(n)]


def grid_torus(rows, columns):
    nodes = np.arange(rows * columns).reshape(rows, columns)
    right, up = np.roll(nodes, -1, axis=0), np.roll(nodes, -1, axis=1)
    return np.vstack([np.column_stack([nodes.ravel(), a.ravel()]) for a in (right, up)])


def lowest_of_cycle(n):
    """Smallest eigenvalue of a cycle's adjacency matrix."""
    return -2 * np.cos(np.pi / n) if n % 2 else -2


def torus_case(rows, columns):
    """Every odd row and every odd column leaves at least one edge uncut; a chessboard leaves no more."""
    relaxed = rows * columns * (4 + lowest_of_cycle(rows) + lowest_of_cycle(columns))
    exact = 4 * (columns * (rows % 2) + rows * (columns % 2))
    return pytest.param(grid_torus(rows, columns), relaxed, exact, id=f"torus-{rows}x{columns}")


PETERSEN = cycle(5) + [(k, k + 5) for k in range(5)] + [(5 + k, 5 + (k + 2) % 5) for k in range(5)]

# On a vertex-transitive graph of degree k the relaxation is n (k + smallest eigenvalue of the adjacency
# matrix): the uniform dual is optimal.
MAX_CUTS = [
    pytest.param(cycle(5), 10 * (1 - np.cos(np.pi / 5)), 4, id="5-cycle"),
    pytest.param(cycle(7), 14 * (1 - np.cos(np.pi / 7)), 4, id="7-cycle"),
    pytest.param(PETERSEN, 10 * (3 - 2), 12, id="petersen"),
    pytest.param([(i, j) for j in range(6) for i in range(j)], 6 * (5 - 1), 24, id="complete-6"),
    *(torus_case(*size) for size in [(3, 3), (4, 4), (4, 5), (5, 5), (5, 7), (7, 7), (8, 11), (15, 15)]),
]


@pytest.mark.parametrize(("edges", "relaxed", "exact"), MAX_CUTS)
def test_max_cut_of_symmetric_graphs(edges, relaxed, exact):
    solution = solve(SynchronizationProblem(max_cut(edges)), TIGHT)
    assert solution.sdp_value == pytest.approx(relaxed, rel=1e-6, abs=1e-9)
    assert relaxed * (1 - 1.01e-6) - 1e-9 <= solution.lower_bound <= relaxed * (1 + 1e-12) + 1e-10
    assert solution.energy == pytest.approx(exact, rel=1e-9, abs=1e-9)
    np.testing.assert_allclose(np.abs(solution.phases), 1, rtol=1e-9)
    assert solution.status is Status.CERTIFIED


@pytest.mark.parametrize(("edges", "relaxed", "exact"), MAX_CUTS)
def test_the_interior_point_method_has_the_known_max_cut_relaxations(edges, relaxed, exact):
    assert relaxation(*lifted_matrix(max_cut(edges))) == pytest.approx((relaxed, relaxed), rel=1e-8, abs=1e-8)


def dense_bound(problem, lifted):
    """The best bound that a lifted field proves: its multipliers (22), lowered until the slack is definite."""
    total = 0.0
    for piece in problem.pieces:
        matrix, columns = piece.matrix.toarray(), lifted[piece.rows]
        firsts = np.arange(0, len(matrix), piece.block)
        duals = np.add.reduceat((columns.conj() * (matrix @ columns)).real.sum(axis=1), firsts)
        slack, mass = matrix - np.diag(np.repeat(duals, piece.block)), piece.mass.sum()
        bounds = [0.0]
        for shift in np.geomspace(1e-4, 10, 11) * duals.sum() / mass:
            # S + depth (L + shift M) >= 0
            depth = max(-eigh(slack, matrix + shift * np.diag(piece.row_mass), eigvals_only=True)[0], 0)
            bounds.append((duals.sum() - depth * shift * mass) / (1 + depth))
        total += max(bounds)
    return total


@pytest.mark.parametrize("build", PROBLEMS)
def test_values_and_bounds_enclose_those_of_an_interior_point_method(build):
    problem = build()
    dense = [relaxation(p.matrix.toarray(), np.repeat(np.arange(p.node_count), p.block)) for p in problem.pieces]
    below, above = np.sum(dense, axis=0)
    assert above == pytest.approx(below, rel=1e-6)  # the reference proves itself
    for gap in (1e-1, 1e-6):
        solution = solve(problem, Options(target_gap=gap, rounding="svd"))
        assert solution.status is Status.CERTIFIED and solution.certificate == "proved" and solution.sdp_gap <= gap
        assert below * (1 - 1.01 * gap) <= solution.lower_bound <= above * (1 + 1e-12)
        assert below * (1 - 1e-12) <= solution.sdp_value <= solution.energy * (1 + 1e-9)
        # The lifted field that comes with the bound is one that proves such a bound.
        assert below * (1 - 1.5 * gap) <= dense_bound(problem, solution.lifted) <= above * (1 + 1e-9)
    assert solution.sdp_value == pytest.approx(above, rel=2e-6)


def test_the_exact_max_cuts_by_counting():
    for parameters in MAX_CUTS:
        edges, _, exact = parameters.values
        edges = np.array(edges)
        if edges.max() < 12:
            signs = np.array(list(product((-1, 1), repeat=edges.max() + 1)))
            uncut = (signs[:, edges[:, 0]] == signs[:, edges[:, 1]]).sum(axis=1)
            assert 4 * uncut.min() == exact


@pytest.mark.parametrize("flux", [0.3, 1.7, np.pi - 0.1])
@pytest.mark.parametrize("n", [3, 10, 60])
def test_a_loop_shares_out_its_flux(flux, n):
    random = np.random.default_rng(n)
    angles = random.uniform(-np.pi, np.pi, n)
    angles[-1] = flux - angles[:-1].sum()
    connection = Connection(n, np.array(cycle(n)), np.ones(n), np.exp(1j * angles))
    solution = solve(SynchronizationProblem(connection), Options(target_gap=1e-4))
    exact = n * 4 * np.sin(flux / (2 * n)) ** 2
    assert solution.energy == pytest.approx(exact, rel=1e-6)
    assert exact * (1 - 1.1e-4) <= solution.lower_bound <= exact * (1 + 1e-9)
    assert solution.certificate == "proved"


@pytest.mark.parametrize(("n", "quanta"), [(6, 6), (8, 24), (9, 18)])
def test_a_torus_in_a_uniform_magnetic_field(n, quanta):
    """A field that turns by whole periods along each row makes all nodes alike up to a gauge change, so that the
    relaxation is the number of nodes times the lowest eigenvalue."""
    x, y = (a.ravel() for a in np.mgrid[:n, :n])
    flux = 2 * np.pi * quanta / n**2
    along_x = np.where(x == n - 1, flux * n * y, 0)  # closes up the potential (0, flux x)
    edges = grid_torus(n, n)
    angles = np.concatenate([-along_x, flux * x])
    connection = Connection(n * n, edges, np.ones(2 * n * n), np.exp(1j * angles))
    (piece,) = SynchronizationProblem(connection).pieces
    lowest = np.linalg.eigvalsh(piece.matrix.toarray())[0]
    solution = solve(SynchronizationProblem(connection), TIGHT)
    assert solution.sdp_value == pytest.approx(n * n * lowest, rel=1e-5)
    assert solution.lower_bound == pytest.approx(n * n * lowest, rel=1.1e-5)
    assert solution.energy > solution.sdp_value * 1.001


def by_trust_regions(piece, rank, seed):
    """Value of the lifted problem (24) with pymanopt on real coordinates (2 rank x nodes, unit columns)."""
    pymanopt = pytest.importorskip("pymanopt")
    matrix = piece.matrix
    manifold = pymanopt.manifolds.Oblique(2 * rank, piece.node_count)

    def product_with(x):
        image = matrix @ (x[:rank] + 1j * x[rank:]).T
        return 2 * np.vstack([image.real.T, image.imag.T])

    cost = pymanopt.function.numpy(manifold)(lambda x: 0.5 * float((x * product_with(x)).sum()))
    gradient = pymanopt.function.numpy(manifold)(product_with)
    hessian = pymanopt.function.numpy(manifold)(lambda x, v: product_with(v))
    problem = pymanopt.Problem(manifold, cost, euclidean_gradient=gradient, euclidean_hessian=hessian)
    optimizer = pymanopt.optimizers.TrustRegions(max_iterations=100, min_gradient_norm=1e-5, verbosity=0)
    start = np.random.default_rng(seed).standard_normal((2 * rank, piece.node_count))
    return optimizer.run(problem, initial_point=start / np.linalg.norm(start, axis=0)).cost


def constrained_stripes():
    """A phase fixed on one side, constant on another, drawn on a third: ground, merged nodes and soft wishes."""
    mesh = bent_square(14)
    x, y, _ = mesh.vertices.T
    rows = [
        boundary_row(mesh, "phase", x == 0, 0.3),
        boundary_row(mesh, "constant", x == 1),
        Row(boundary_row(mesh, "phase", y == 0).line, "phase", 1.0, weight=3.0),
    ]
    field = given_directions(mesh, 1, np.tile([0.3, 1.0, 0.0], (mesh.vertex_count, 1)))
    return pattern_problem(mesh, field, PatternWishes(0.13, rows))


@pytest.mark.parametrize(
    "build",
    [
        pytest.param(lambda: direction_problem(icosphere(2), 1), id="vectors"),
        pytest.param(lambda: direction_problem(torus(around=16, across=10), 4), id="crosses"),
        pytest.param(lambda: direction_problem(bent_square(), 2), id="lines"),
        pytest.param(lambda: bordered_problem(bent_square(14), 2), id="fixed-lines"),
        pytest.param(constrained_stripes, id="constrained-stripes"),
    ],
)
def test_the_value_is_that_of_trust_regions(build):
    problem = build()
    (piece,) = problem.pieces
    peer = by_trust_regions(piece, rank=6, seed=0)
    solution = solve(problem, TIGHT)
    assert solution.sdp_value == pytest.approx(peer, rel=1e-4, abs=1e-9)
    assert solution.lower_bound <= peer * (1 + 1e-7) + 1e-9


@pytest.mark.parametrize("symmetry", [1, 2, 4])
def test_the_lifted_field_is_unit_and_has_the_value(symmetry):
    problem = direction_problem(icosphere(2), symmetry)
    solution = solve(problem, TIGHT)
    lifted = solution.lifted
    assert lifted.shape == (162, solution.rank) == (162, len(solution.singular_values))
    np.testing.assert_allclose(np.linalg.norm(lifted, axis=1), 1, rtol=1e-6)
    (piece,) = problem.pieces
    rows = lifted[piece.rows]
    assert np.vdot(rows, piece.matrix @ rows).real == pytest.approx(solution.sdp_value, rel=1e-5)
    np.testing.assert_allclose(np.linalg.svd(lifted, compute_uv=False), solution.singular_values, rtol=1e-6)
    assert (np.diff(solution.singular_values) <= 0).all()


@pytest.mark.parametrize("is_real", [False, True])
def test_more_columns_at_first_where_no_factorization_proves_or_the_gap_is_small(is_real):
    piece = only_piece(half_turned_stripes(bumpy_torus(10), 0.35) if is_real else direction_problem(bumpy_torus(10), 4))
    few, many = (9, 12) if is_real else (6, 8)
    ranks = [start_rank(piece, provable, gap) for provable in (True, False) for gap in (1e-2, 1e-3)]
    assert ranks == [few, many, many, many]
    tiny = only_piece(SynchronizationProblem(random_connection("circle", 4, 3, 0)))
    assert start_rank(tiny, True, 1e-2) == 4
