# SPDX-License-Identifier: GPL-3.0-or-later
"""Relax a connection of which every process holds a part, by the search of :mod:`core.solve.methods.staircase` itself.

Only sums, products and the hierarchy are those of all processes, so that value and bound are what one process finds. No
factorization proves a bound here: it is estimated.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..algebra.workers import solving
from ..monitor import SILENT
from ..solution import Clock, Options
from ..solve.methods.descent import descend
from ..solve.methods.manifolds import CirclesByFields
from ..solve.methods.rounding import CANDIDATE_SHIFT, random_directions
from ..solve.methods.stage import Workspace
from ..solve.methods.staircase import Relaxation, relax
from .hierarchy import SpreadHierarchy
from .parts import piece_of

# Projections of the lifted field, those that descend, and where that ends: predicted relative decrease, steps at most.
PROJECTIONS, KEPT = 32, 4
TOLERANCE, STEPS = 1e-5, 100


@dataclass(frozen=True)
class SpreadSolution:
    """A field with its bound.

    Attributes
    ----------
    phases : (n,) complex, of the nodes held here
    energy : of the phases of all nodes (Eq. 17)
    relaxation : Relaxation, its lifted field that of the nodes held here; ``lower_bound`` and ``value`` are of all
    seconds : by phase of the work
    """

    phases: np.ndarray
    energy: float
    relaxation: Relaxation
    seconds: dict


def solve_parts(part, comm, target_gap=1e-2, seed=0):
    """Relax to a relative gap, and round by random projections and descent; all processes call it together.

    Parameters
    ----------
    part : Part of this process
    comm : MPI communicator
    target_gap : (value - bound) / value to reach
    seed : int

    Returns
    -------
    SpreadSolution
    """
    clock = Clock()
    own = Options(target_gap=target_gap, seed=seed * comm.size + comm.rank)  # other numbers in each process
    with solving():
        with clock("build"):
            piece, whole, weight = piece_of(part, comm)
            workspace = Workspace(piece, SpreadHierarchy.of(whole, piece.row_mass, piece.held))
        found = relax(workspace, own, SILENT, clock)
        with clock("round"):
            column = _round_columns(workspace, found, seed)
    energy = weight * float(piece.energy(column)[0])
    found = replace(found, value=weight * found.value, lower_bound=weight * found.lower_bound)
    return SpreadSolution(column[:, 0], energy, found, clock.seconds)


def _round_columns(workspace, found, seed):
    """(N, 1) phases: the best of some projections (Eq. 29), after descent in the metric of fields."""
    piece, stage = workspace.piece, workspace.stages[0]
    spheres = CirclesByFields(1, held=piece.held)
    lifted = found.lifted.astype(stage.matrix.dtype)
    directions = random_directions(True, lifted.shape[1], PROJECTIONS - 1, np.random.default_rng(seed))

    def seen(numbers):
        columns = spheres.normalize(lifted @ directions[:, numbers].astype(lifted.dtype))
        return columns, spheres.energies(columns, stage.matrix @ columns)

    values = np.concatenate([seen([number])[1] for number in range(PROJECTIONS)])
    columns, _ = seen(np.argsort(values)[:KEPT])
    metric = stage.metric(CANDIDATE_SHIFT * found.value / piece.total_mass)
    descent = descend(stage.matrix, spheres, columns, metric, TOLERANCE, STEPS, SILENT)
    return spheres.normalize(descent.point[:, [np.argmin(descent.values)]].astype(complex))
