# SPDX-License-Identifier: GPL-3.0-or-later
"""The best known energy of every row, from whatever run, in best_known.json beside this file."""

import json
from pathlib import Path

import numpy as np

PATH = Path(__file__).with_name("best_known.json")
# Problems whose marks agree this well are the same.
SAME_MARK = 1e-6


class BestKnown:
    """Energies that were reached, by the names of rows.

    A row counts while its problem is the same: quads follow a field that was solved for, and another field poses
    another problem. Its mark is the energy of equal phases at all nodes.

    Parameters
    ----------
    path : of the file, which need not exist yet
    """

    def __init__(self, path=PATH):
        self._path = path
        self._rows = json.loads(path.read_text()) if path.exists() else {}

    def distance(self, name, problem, energy):
        """How far an energy is above the best known one, as a share of that; None where none is known."""
        known = self._rows.get(name)
        if known is None or abs(known["mark"] - _mark(problem)) > SAME_MARK * known["mark"]:
            return None
        return energy / known["energy"] - 1

    def see(self, name, problem, energy):
        """Remember an energy that was reached, where it is less than the known one or that is of another problem."""
        distance = self.distance(name, problem, energy)
        if distance is None or distance < 0:
            self._rows[name] = {"energy": float(energy), "mark": _mark(problem)}

    def save(self):
        self._path.write_text(json.dumps(self._rows, indent=1, sort_keys=True) + "\n")


def _mark(problem):
    return float(problem.energy(np.ones(problem.connection.node_count, complex)))
