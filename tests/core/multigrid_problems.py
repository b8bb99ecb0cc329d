# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Problems of every kind for tests of the multigrid."""

import numpy as np
import pytest

from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.problem import Merged, SynchronizationProblem, Targets

from .direction_wishes import bordered_problem
from .graphs import fixed_stripes, half_turned_stripes, random_transports, random_weights
from .meshes import bent_square, bumpy_torus, slivers, subdivided


def merged_directions():
    """Far nodes that have to agree, up to a turn."""
    problem = direction_problem(bumpy_torus(14), 4)
    merged = Merged(np.array([5, 6, 300, 450]), np.array([100, 150, 100, 220]), np.exp(1j * np.arange(4)))
    return SynchronizationProblem(problem.connection, problem.mass, merged=merged)


def drawn_rotations():
    """Unit vectors in four dimensions, of which many are drawn to one another and to given ones."""
    mesh, random = bumpy_torus(10), np.random.default_rng(0)
    transports = random_transports("rotations", len(mesh.edges), random)
    values = random.standard_normal((90, 4))
    values /= np.linalg.norm(values, axis=1)[:, None]
    drawn = Targets(np.arange(90), values, random.uniform(0.01, 1, 90))
    return SynchronizationProblem(random_weights(mesh, transports, random), drawn=drawn)


# Of every kind, with two levels or more and few enough rows for dense linear algebra.
MULTILEVEL = [
    pytest.param(lambda: direction_problem(bumpy_torus(14), 1), id="vectors"),
    pytest.param(lambda: bordered_problem(bent_square(22), 4), id="fixed-crosses"),
    pytest.param(lambda: direction_problem(subdivided(slivers()), 4), id="slivers"),
    pytest.param(lambda: half_turned_stripes(bumpy_torus(14), 0.4), id="flips"),
    pytest.param(lambda: fixed_stripes(14), id="fixed-flips"),
    pytest.param(merged_directions, id="merged"),
    pytest.param(drawn_rotations, id="drawn-rotations"),
]
