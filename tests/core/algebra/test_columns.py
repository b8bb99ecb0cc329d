# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums and multiples of columns, in parts, against the plain ones in double precision."""

import numpy as np
import pytest

from synch_fields.core.algebra.columns import (
    HELD,
    PAIR,
    TOGETHER,
    add_multiples,
    inner_products,
    precise_inner_products,
    split_columns,
    sum_rows,
)

ROWS = HELD // 5
SIZES = [0, 1, TOGETHER - 1, TOGETHER, 3 * TOGETHER + 5, ROWS, ROWS + 1, 2 * ROWS + TOGETHER + 7]


@pytest.fixture(params=[(size, width) for size in SIZES for width in (1, 5)])
def pair(request):
    return np.random.default_rng(request.param).standard_normal((2, *request.param)) + 0.5


@pytest.mark.parametrize(("dtype", "digits"), [(np.float64, 1e-13), (np.float32, 2e-6)])
def test_inner_products(pair, dtype, digits):
    first, second = pair.astype(dtype)
    sizes = np.abs(first.astype(float) * second).sum(axis=0)
    result = inner_products(first, second)
    assert result.shape == first.shape[1:] and result.dtype == dtype
    assert (np.abs(result - (first.astype(float) * second).sum(axis=0)) <= digits * sizes).all()


@pytest.mark.parametrize(("dtype", "digits"), [(np.float64, 1e-13), (np.float32, 1e-7)])
def test_precise_inner_products(pair, dtype, digits):
    first, second = pair.astype(dtype)
    sizes = np.abs(first.astype(float) * second).sum(axis=0)
    result = precise_inner_products(first, second)
    assert (
        result.dtype == float and (np.abs(result - (first.astype(float) * second).sum(axis=0)) <= digits * sizes).all()
    )


def test_sums_of_complex_rows(pair):
    rows = (pair[0] + 1j * pair[1]).astype(np.complex64)
    np.testing.assert_allclose(sum_rows(rows), rows.astype(complex).sum(axis=0), rtol=1e-4, atol=1e-2)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_sums_of_a_column_do_not_depend_on_the_columns_beside_it(size, dtype):
    first, second = np.random.default_rng(size).standard_normal((2, size, 33)).astype(dtype)
    sums = {work: work(first, second) for work in (inner_products, precise_inner_products)}
    for columns in (slice(0, 2), slice(31, 33), slice(3, 10), slice(5, 33)):
        ours, theirs = (np.ascontiguousarray(array[:, columns]) for array in (first, second))
        for work, of_all in sums.items():
            np.testing.assert_array_equal(work(ours, theirs), of_all[columns])
        np.testing.assert_array_equal(sum_rows(ours), sum_rows(first)[columns])


@pytest.mark.parametrize("count", range(1, 12))
@pytest.mark.parametrize("parts", [1, 2, 3, 8])
def test_columns_are_split_into_whole_pairs(count, parts):
    found = split_columns(count, parts)
    assert [number for part in found for number in range(count)[part]] == list(range(count))
    widths = [part.stop - part.start for part in found]
    assert len(found) == min(parts, max(count // PAIR, 1)) and max(widths) - min(widths) <= PAIR + 1
    assert all(part.start % PAIR == 0 for part in found) and (min(widths) > 1 or count == 1)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_multiples_are_added_in_place(pair, dtype):
    columns, others = pair.astype(dtype)
    shares = np.array([1e-3, 0.0, 1.0, -2.0, 1e3])[: columns.shape[1]]
    expected = columns + shares.astype(dtype) * others
    add_multiples(columns, shares, others)
    # One column is for BLAS, which may round a product and its sum at once.
    np.testing.assert_allclose(columns, expected, rtol=2 * np.finfo(dtype).eps, atol=np.finfo(dtype).eps)


@pytest.mark.parametrize("width", [1, 5])
def test_multiples_of_another_precision_are_added_in_that_of_the_columns(width):
    columns, others = np.ones((100, width), np.float32), np.full((100, width), 0.5)
    add_multiples(columns, np.full(width, 3.0), others)
    np.testing.assert_array_equal(columns, np.full((100, width), 2.5, np.float32))


def test_a_sum_that_would_be_lost_in_a_copy_is_refused():
    with pytest.raises(ValueError, match="not contiguous"):
        add_multiples(np.ones((200, 4))[:, ::2], np.ones(2), np.ones((200, 2)))
