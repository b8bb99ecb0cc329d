# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Products by threads are those without."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix, random_array

from synch_fields.core.algebra import products, workers
from synch_fields.core.algebra.products import SharedRows
from synch_fields.core.fields.directions import direction_problem

from ..graphs import only_piece
from ..meshes import bumpy_torus

MATRICES = [
    pytest.param(dict(shape=(4000, 4000), density=0.02), id="square"),
    pytest.param(dict(shape=(9000, 700), density=0.05), id="tall"),
    pytest.param(dict(shape=(300, 20000), density=0.05), id="wide"),
    pytest.param(dict(shape=(3, 30000), density=0.9), id="few-rows"),
]


@pytest.fixture(autouse=True)
def solving():
    """Threads share the rows inside of a solve only."""
    with workers.solving():
        yield


@pytest.mark.parametrize("size", MATRICES)
@pytest.mark.parametrize(("dtype", "count"), [(np.float32, 2), (np.float64, 5), (np.complex64, 5), (np.complex128, 2)])
def test_products_with_shared_rows_are_the_same_to_the_last_bit(size, dtype, count, monkeypatch):
    monkeypatch.setattr(workers, "WORKERS", count)
    random = np.random.default_rng(0)
    matrix = csr_matrix(random_array(**size, rng=random)).astype(dtype)
    if np.iscomplexobj(matrix.data):
        matrix.data *= np.exp(1j * random.uniform(0, 6, matrix.nnz)).astype(dtype)
    empty = np.zeros(matrix.shape[0], bool)
    empty[[0, len(empty) // 2, -1]] = len(empty) > 3  # rows without work, at both ends and in the middle
    matrix.data[np.repeat(empty, np.diff(matrix.indptr))] = 0
    matrix.eliminate_zeros()
    shared = SharedRows(matrix)
    assert shared.shape == matrix.shape and shared.dtype == matrix.dtype
    for columns in (None, 1, 7, 24):
        size = matrix.shape[1]
        right = random.standard_normal(size if columns is None else (size, columns))
        for right_dtype in (dtype, np.float64):
            values = right.astype(right_dtype)
            for layout in (values, np.asfortranarray(values)):
                expected = matrix @ layout
                result = shared @ layout
                assert result.dtype == expected.dtype and result.shape == expected.shape
                np.testing.assert_array_equal(result, expected)
    threads = min(count, 1 + matrix.nnz * 24 // products.WORTH_SHARING)
    assert threads > 1 and max(shared._ranges) == threads
    rows = shared._ranges[threads]
    assert len(rows) == threads and rows[0][0] == 0 and rows[-1][1] == matrix.shape[0]


def test_all_work_in_one_row_is_still_shared_out_once(monkeypatch):
    """Where one row holds nearly everything, some workers have no rows at all."""
    monkeypatch.setattr(workers, "WORKERS", 6)
    monkeypatch.setattr(products, "WORTH_SHARING", 1)
    random = np.random.default_rng(1)
    dense = np.zeros((40, 5000))
    dense[13] = random.standard_normal(5000)
    dense[:, 0] = 1
    matrix = csr_matrix(dense)
    right = random.standard_normal((5000, 3))
    np.testing.assert_array_equal(SharedRows(matrix) @ right, matrix @ right)
    np.testing.assert_allclose(SharedRows(matrix) @ right, dense @ right, rtol=1e-12)


def test_small_products_are_not_shared(monkeypatch):
    monkeypatch.setattr(workers, "WORKERS", 2)
    monkeypatch.setattr(workers.pool, "map", lambda *_: pytest.fail("threads for a small product"))
    matrix = csr_matrix(random_array((500, 500), density=0.1, rng=np.random.default_rng(2)))
    right = np.ones((500, 4))
    np.testing.assert_array_equal(SharedRows(matrix) @ right, matrix @ right)


def test_columns_that_do_not_fit_are_refused():
    """SciPy's kernels would read past the end of the columns."""
    matrix = SharedRows(csr_matrix(np.eye(5)))
    with pytest.raises(ValueError, match="times"):
        matrix @ np.ones((4, 2))


def test_the_diagonal_is_the_matrix_s():
    piece = only_piece(direction_problem(bumpy_torus(8), 1))
    np.testing.assert_array_equal(SharedRows(piece.matrix).diagonal(), piece.matrix.diagonal())
