# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums and multiples of columns, in parts, against the plain ones in double precision."""

import numpy as np
import pytest

from synch_fields.core.solve.columns import HELD, TOGETHER, add_multiples, inner_products, precise_inner_products

ROWS = HELD // 5
SIZES = [0, 1, TOGETHER - 1, TOGETHER, 3 * TOGETHER + 5, ROWS, ROWS + 1, 2 * ROWS + TOGETHER + 7]


@pytest.fixture(params=SIZES)
def pair(request):
    return np.random.default_rng(request.param).standard_normal((2, request.param, 5)) + 0.5


@pytest.mark.parametrize(("dtype", "digits"), [(np.float64, 1e-13), (np.float32, 2e-6)])
def test_inner_products(pair, dtype, digits):
    first, second = pair.astype(dtype)
    sizes = np.abs(first.astype(float) * second).sum(axis=0)
    result = inner_products(first, second)
    assert result.shape == (5,) and result.dtype == dtype
    assert (np.abs(result - (first.astype(float) * second).sum(axis=0)) <= digits * sizes).all()


@pytest.mark.parametrize(("dtype", "digits"), [(np.float64, 1e-13), (np.float32, 1e-7)])
def test_precise_inner_products(pair, dtype, digits):
    first, second = pair.astype(dtype)
    sizes = np.abs(first.astype(float) * second).sum(axis=0)
    result = precise_inner_products(first, second)
    assert (
        result.dtype == float and (np.abs(result - (first.astype(float) * second).sum(axis=0)) <= digits * sizes).all()
    )


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_multiples_are_added_in_place(pair, dtype):
    columns, others = pair.astype(dtype)
    shares = np.array([0.0, 1.0, -2.0, 1e-3, 1e3])
    expected = columns + shares.astype(dtype) * others
    add_multiples(columns, shares, others)
    np.testing.assert_array_equal(columns, expected)


def test_a_sum_that_would_be_lost_in_a_copy_is_refused():
    with pytest.raises(ValueError, match="not contiguous"):
        add_multiples(np.ones((200, 4))[:, ::2], np.ones(2), np.ones((200, 2)))
