# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Definiteness by dense blocks, against dense linear algebra and elimination row by row."""

import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse import block_diag, coo_matrix, csr_matrix, diags_array, eye_array, kron

from synch_fields.core.algebra import multifrontal
from synch_fields.core.algebra.blocks import block_diagonal
from synch_fields.core.algebra.multifrontal import Elimination, rounding_error
from synch_fields.core.solve.methods.memory_estimate import elimination_bytes

from ..layered_solids import block
from ..meshes import torus


def is_definite(matrix, elimination):
    return rounding_error(matrix, elimination) is not None


def laplacian(count, edges, is_complex, seed=0):
    """A connection Laplacian with random weights and transports."""
    random = np.random.default_rng(seed)
    weights = random.uniform(0.5, 2, len(edges))
    values = -weights * np.exp(1j * random.uniform(0, 2 * np.pi, len(edges))) if is_complex else -weights
    both = np.append(values, values.conj()), np.concatenate([edges.T, edges[:, ::-1].T], axis=1)
    return (
        coo_matrix(both, shape=(count, count)) + diags_array(np.bincount(edges.ravel(), np.repeat(weights, 2), count))
    ).tocsr()


def solid_matrix(counts, is_complex=True):
    """Of a block of tetrahedra."""
    solid = block(counts)
    return laplacian(solid.vertex_count, solid.edges, is_complex)


def hub_matrix():
    """A solid whose nodes are all joined to one more."""
    solid = block((8, 7, 6))
    spokes = np.column_stack([np.arange(solid.vertex_count), np.full(solid.vertex_count, solid.vertex_count)])
    return laplacian(solid.vertex_count + 1, np.concatenate([solid.edges, spokes]), True)


MATRICES = {
    "a solid": lambda: solid_matrix((9, 8, 7)),
    "a solid, real": lambda: solid_matrix((9, 8, 7), is_complex=False),
    "a bar": lambda: solid_matrix((60, 3, 2)),
    "a surface": lambda: laplacian(720, torus(around=36, across=20).edges, True),
    "several pieces": lambda: csr_matrix(block_diag([solid_matrix((6, 5, 5)), solid_matrix((3, 3, 3)), eye_array(9)])),
    "a hub": hub_matrix,
    "few rows": lambda: solid_matrix((2, 1, 1)),
    "no edges": lambda: csr_matrix(eye_array(300)),
}


@pytest.mark.parametrize("name", MATRICES)
def test_matrices_are_definite_exactly_where_their_lowest_eigenvalue_is_positive(name):
    matrix = MATRICES[name]()
    elimination = Elimination.of(matrix)
    lowest = float(np.linalg.eigvalsh(matrix.toarray())[0])
    for shift, expected in ((1e-9, True), (-1e-9, False), (1.0, True), (-0.5, False)):
        assert is_definite((matrix + (shift - lowest) * eye_array(matrix.shape[0])).tocsr(), elimination) is expected


@pytest.mark.parametrize("width", [1, 7, 500])
def test_panels_and_strips_of_any_width_say_the_same(width, monkeypatch):
    monkeypatch.setattr(multifrontal, "_PANEL", width)
    monkeypatch.setattr(multifrontal, "_STRIP", 2 * width + 1)
    matrix = solid_matrix((7, 6, 5))
    lowest = float(np.linalg.eigvalsh(matrix.toarray())[0])
    for shift in (1e-9, -1e-9):
        shifted = (matrix + (shift - lowest) * eye_array(matrix.shape[0])).tocsr()
        assert is_definite(shifted, Elimination.of(matrix)) is (shift > 0)


def test_the_rows_of_a_node_are_in_one_block():
    """Entries between them may be missing in the pattern, and are filled in by those on the diagonal."""
    nodes = laplacian(240, torus(around=20, across=12).edges, False)
    matrix = csr_matrix(kron(nodes, eye_array(3)))
    elimination = Elimination.of(matrix, 3)
    apart = Elimination.of(nodes)
    assert (elimination.order.reshape(-1, 3) == 3 * apart.order[:, None] + np.arange(3)).all()
    assert (elimination.starts == 3 * apart.starts).all()
    blocks = np.random.default_rng(0).standard_normal((240, 3, 3))
    matrix += block_diagonal(blocks + blocks.swapaxes(1, 2))
    lowest = float(np.linalg.eigvalsh(matrix.toarray())[0])
    for shift, expected in ((1e-9, True), (-1e-9, False)):
        assert is_definite((matrix + (shift - lowest) * eye_array(720)).tocsr(), elimination) is expected


def test_orders_that_take_too_much_are_given_up():
    matrix = solid_matrix((9, 8, 7))
    elimination = Elimination.of(matrix)
    own, later = elimination.sizes
    for limit, value in (("most", elimination.products), ("widest", (own + later).max())):
        assert Elimination.of(matrix, **{limit: 1.001 * value}) is not None
        assert Elimination.of(matrix, **{limit: 0.999 * value}) is None


def test_a_row_without_a_diagonal_is_not_definite():
    matrix = solid_matrix((5, 5, 5)).tolil()
    matrix[17, 17] = 0
    assert not is_definite(matrix.tocsr(), Elimination.of(matrix.tocsr()))
    matrix[17, 17] = np.nan
    assert not is_definite(matrix.tocsr(), Elimination.of(matrix.tocsr()))


def factor_pattern(matrix, order):
    """(n, n) bool: entries of the Cholesky factor by elimination row by row."""
    pattern = matrix.toarray()[np.ix_(order, order)] != 0
    for row in range(len(order)):
        later = row + 1 + np.flatnonzero(pattern[row + 1 :, row])
        pattern[np.ix_(later, later)] = True
    return np.tril(pattern)


@pytest.mark.parametrize("name", MATRICES)
def test_blocks_reach_the_rows_that_elimination_row_by_row_fills_in(name):
    matrix = MATRICES[name]()
    elimination = Elimination.of(matrix)
    order, starts = elimination.order, elimination.starts
    assert sorted(order) == list(range(matrix.shape[0]))
    exact = factor_pattern(matrix, order)
    filled = np.zeros_like(exact)
    for start, end, reach in zip(starts, starts[1:], elimination.reaches, strict=False):
        changed = np.flatnonzero(exact[end:, start:end].any(axis=1)) + end
        assert set(changed) <= set(reach) and (name == "several pieces" or len(changed) == len(reach))
        filled[np.ix_(np.append(np.arange(start, end), reach), np.arange(start, end))] = True
    filled = np.tril(filled)
    counts = filled.sum(axis=0)
    assert elimination.products == pytest.approx(
        (counts.astype(float) ** 2).sum() / 2, rel=0.1 if len(order) > 99 else 0.5
    )


@pytest.mark.parametrize("name", MATRICES)
def test_the_bound_of_rounding_errors_is_the_factors_product_weighted_by_chains(name):
    """Row sums of |R|^H T |R| by a dense factorization; T are the most roundings of a term of each row."""
    matrix = MATRICES[name]() + eye_array(MATRICES[name]().shape[0])
    elimination = Elimination.of(matrix.tocsr())
    order = elimination.order
    factor = np.abs(np.linalg.cholesky(matrix.toarray()[np.ix_(order, order)]))
    chains = np.repeat(elimination.chains, elimination.sizes[0])
    sums = factor @ (chains * factor.sum(axis=0))
    np.testing.assert_allclose(rounding_error(matrix.tocsr(), elimination)[order], sums, rtol=1e-9)


def test_chains_count_additions_up_to_the_root():
    """Of two leaves of 60 and 50 rows, and a root of 300, which is eliminated by two panels."""
    nothing = np.empty(0, int)
    elimination = Elimination(np.arange(410), np.array([0, 60, 110, 410]), [np.array([110]), np.array([110]), nothing])
    additions = 1 + 2 + 2  # of a leaf: its panel, two children of the root, two panels there
    assert elimination.chains.tolist() == [
        60 + 3 + 1 + 4 + additions,
        50 + 3 + 1 + 4 + additions,
        256 + 3 + 2 + additions,
    ]


@pytest.mark.parametrize("dtype", [np.float32, np.complex64])
def test_rounding_errors_are_smaller_than_their_bound(dtype):
    """In single precision, where they can be seen, by rows of the factor's product less the matrix."""
    matrix = solid_matrix((9, 8, 7)).toarray()
    matrix = (matrix if dtype is np.complex64 else matrix.real).astype(dtype) + np.eye(len(matrix), dtype=dtype)
    elimination = Elimination.of(csr_matrix(matrix))
    permuted = matrix[np.ix_(elimination.order, elimination.order)]
    wide = np.linalg.cholesky(permuted).astype(complex)
    errors = np.abs(wide @ wide.conj().T - permuted).sum(axis=1)
    bounds = np.finfo(np.float32).eps * rounding_error(csr_matrix(matrix), elimination)[elimination.order]
    assert (errors <= bounds).all() and errors.max() > 1e-5 * bounds.max()
    assert (bounds < 0.1 * matrix.diagonal().real.max()).all()


def test_entries_outside_of_the_pattern_are_refused():
    matrix = solid_matrix((9, 8, 7)).tolil()
    elimination = Elimination.of(matrix.tocsr())
    apart = np.setdiff1d(np.arange(elimination.starts[1], matrix.shape[0]), elimination.reaches[0])[0]
    first, second = elimination.order[[0, apart]]
    matrix[first, second] = matrix[second, first] = 0.1
    with pytest.raises(ValueError, match="outside of the elimination's pattern"):
        is_definite(matrix.tocsr(), elimination)
    assert len(Elimination.of(csr_matrix((0, 0))).order) == 0


def test_orders_of_solids_take_fewer_products_than_sweeps():
    solid = block((20, 20, 20))
    matrix = laplacian(solid.vertex_count, solid.edges, True)
    assert Elimination.of(matrix).products < matrix.shape[0] * 441.0**2 / 4


@pytest.mark.parametrize("mesh", [block((20, 20, 20)), torus(around=200, across=120)])
def test_memory_is_that_of_the_largest_dense_blocks_and_of_the_matrix(mesh):
    matrix = laplacian(mesh.vertex_count, mesh.edges, True)
    elimination = Elimination.of(matrix)
    is_definite(matrix[:50, :50], Elimination.of(matrix[:50, :50]))
    tracemalloc.start()
    assert is_definite((matrix + eye_array(matrix.shape[0])).tocsr(), elimination)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    estimated = elimination_bytes(SimpleNamespace(matrix=matrix), elimination.entries)
    assert 0.5 * estimated < peak < 1.2 * estimated
