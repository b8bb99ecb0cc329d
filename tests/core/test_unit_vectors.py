# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Vector products, against NumPy's."""

import numpy as np
import pytest

from synch_fields.core.unit_vectors import cross


@pytest.mark.parametrize("shapes", [((7, 3), (7, 3)), ((3,), (3,)), ((2, 1, 3), (5, 3)), ((0, 3), (0, 3))])
def test_vector_products_are_numpys(shapes):
    random = np.random.default_rng(0)
    u, v = (random.standard_normal(shape) for shape in shapes)
    np.testing.assert_allclose(cross(u, v), np.cross(u, v), atol=1e-15)
