# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The memory of layers, for surfaces that were not checked before."""

import numpy as np

from synch_fields.core.geometry.filling.lengths import Lengths, Measures
from synch_fields.core.tasks.solid_memory import layer_memory


def test_the_memory_is_estimated_for_any_triangles():
    """A panel asks for it before the surface is checked: open surfaces, and surfaces that intersect themselves."""
    rng = np.random.default_rng(0)
    shares = []
    for _ in range(300):
        points = rng.normal(size=(rng.integers(3, 40), 3))
        measures = Measures.of(points, rng.integers(0, len(points), (rng.integers(1, 60), 3)))
        if measures.volume > 0:
            needed, expected = layer_memory(measures, Lengths.of(measures, None, None))
            shares.append(expected / needed)
    assert len(shares) > 250 and min(shares) >= 1
