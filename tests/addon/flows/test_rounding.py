# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The rounding of a flow's map, chosen in Python and on the command line."""

import json

import numpy as np
import pytest

from synch_fields.bench.grids import QUANTA, trefoil_grid, trefoil_velocity
from synch_fields.core.errors import SettingError
from synch_fields.core.interpolate import TURN
from synch_fields.synch_addon import api
from synch_fields.synch_addon.command.main import main


@pytest.fixture
def trefoil(tmp_path):
    shape = (12, 12, 8)
    grid = trefoil_grid(shape)
    path = tmp_path / "trefoil.npz"
    velocity = trefoil_velocity(grid.places).reshape(*shape, 3)
    np.savez(path, velocity=velocity, spacing=grid.spacing, origin=grid.origin)
    return path


def test_roundings_are_chosen_in_python_and_on_the_command_line(trefoil, tmp_path, capsys):
    quantum = TURN * QUANTA / 6
    energies = {}
    for name in ("svd", "random", "polish", "continuation"):
        energies[name] = api.clebsch(trefoil, rounding=name, quantum=quantum, show="filaments")["energy"]
    assert energies["svd"] > 1.005 * energies["random"] > 1.01 * energies["polish"]
    assert energies["polish"] >= energies["continuation"] * (1 - 1e-9)
    report = tmp_path / "report.json"
    arguments = ["clebsch", str(trefoil), "--quantum", str(quantum), "--show", "filaments", "--quiet"]
    assert main([*arguments, "--rounding", "svd", "--report", str(report)]) == 0
    assert json.loads(report.read_text())["energy"] == pytest.approx(energies["svd"], rel=1e-12)
    with pytest.raises(SettingError, match="rounding"):
        api.clebsch(trefoil, rounding="nearest")
