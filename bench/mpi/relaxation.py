# SPDX-License-Identifier: GPL-3.0-or-later
"""Relaxation of a connection that is distributed over processes, by the search of :mod:`core.solve.methods.staircase`.

Only sums, products and the hierarchy are distributed, so that value and bound are as in one process. The bound is
estimated, as no factorization proves it.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from mpi4py import MPI

from synch_fields.bench.mpi.hierarchy import SpreadHierarchy
from synch_fields.bench.mpi.parts import Part, piece_of
from synch_fields.bench.mpi.rows import SpreadReductions
from synch_fields.core.algebra.workers import solving
from synch_fields.core.monitor import SILENT
from synch_fields.core.solution import Clock, Options
from synch_fields.core.solve.methods.descent import descend
from synch_fields.core.solve.methods.manifolds import CirclesByFields
from synch_fields.core.solve.methods.rounding import CANDIDATE_SHIFT, random_directions
from synch_fields.core.solve.methods.stage import Workspace
from synch_fields.core.solve.methods.staircase import Relaxation, relax

# Projections of the lifted field, those that descend, and the end of descent: predicted relative decrease, most steps.
PROJECTIONS, KEPT = 32, 4
TOLERANCE, STEPS = 1e-5, 100


@dataclass(frozen=True)
class SpreadSolution:
    """A field with its bound.

    Attributes
    ----------
    phases : (n,) complex, of the nodes held here
    energy : of all nodes (Eq. 17)
    relaxation : value and bound of all nodes, and the lifted field of the nodes held here
    seconds : by phase of the work
    """

    phases: np.ndarray
    energy: float
    relaxation: Relaxation
    seconds: dict[str, float]


def solve_parts(part: Part, comm: MPI.Comm, target_gap: float = 1e-2, seed: int = 0) -> SpreadSolution:
    """Relax to a gap (value - bound) / value, and round by random projections and descent; called by all processes."""
    clock = Clock()
    own = Options(target_gap=target_gap, seed=seed * comm.size + comm.rank)  # different random numbers in each process
    with solving():
        with clock("build"):
            piece, whole, weight = piece_of(part, comm)
            assert isinstance(piece.reductions, SpreadReductions)
            hierarchy: Any = SpreadHierarchy.of(whole, piece.row_mass, piece.reductions)  # as a Hierarchy is used
            workspace = Workspace(piece, hierarchy)
        found = relax(workspace, own, SILENT, clock)
        with clock("round"):
            column = _round_columns(workspace, found, seed)
    energy = weight * float(piece.energy(column)[0])
    found = replace(found, value=weight * found.value, lower_bound=weight * found.lower_bound)
    return SpreadSolution(column[:, 0], energy, found, clock.seconds)


def _round_columns(workspace: Workspace, found: Relaxation, seed: int) -> np.ndarray:
    """Compute (N, 1) phases as the best of random projections (Eq. 29) after descent in the metric of fields."""
    piece, stage = workspace.piece, workspace.stages[0]
    spheres = CirclesByFields(1, reductions=piece.reductions)
    lifted = found.lifted.astype(stage.matrix.dtype)
    directions = random_directions(True, lifted.shape[1], PROJECTIONS - 1, np.random.default_rng(seed))

    def seen(numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        columns = spheres.normalize(lifted @ directions[:, numbers].astype(lifted.dtype))
        return columns, spheres.energies(columns, stage.matrix @ columns)

    values = np.concatenate([seen(np.array([number]))[1] for number in range(PROJECTIONS)])
    columns, _ = seen(np.argsort(values)[:KEPT])
    metric = stage.metric(CANDIDATE_SHIFT * found.value / piece.total_mass)
    descent = descend(stage.matrix, spheres, columns, metric, TOLERANCE, STEPS, SILENT)
    return spheres.normalize(descent.point[:, [np.argmin(descent.values)]].astype(complex))
