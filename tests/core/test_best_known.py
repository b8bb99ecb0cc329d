# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Best known energies of benchmark rows: kept across runs, and only of the same problem."""

import pytest

from synch_fields.bench.best_known import BestKnown
from synch_fields.core.fields.directions import direction_problem

from .meshes import bumpy_torus, torus


def test_the_best_energy_is_kept_and_only_for_its_problem(tmp_path):
    path = tmp_path / "best.json"
    problem, other = direction_problem(bumpy_torus(6), 4), direction_problem(torus(), 4)
    known = BestKnown(path)
    assert known.distance("row", problem, 10.0) is None
    for energy in (10.0, 8.0, 9.0):
        known.see("row", problem, energy)
    known.save()
    again = BestKnown(path)
    assert again.distance("row", problem, 10.0) == pytest.approx(0.25)
    assert again.distance("row", other, 10.0) is None
    again.see("row", other, 20.0)
    assert again.distance("row", other, 20.0) == 0
