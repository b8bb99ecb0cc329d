# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the processes of MPI do for test_mpi.py; the first one prints what came out as JSON.

    mpirun -n 2 python program.py folder

The folder holds whole.npz: the arrays of a connection and its mass.
"""

import json
import sys
from pathlib import Path

import numpy as np
from mpi4py import MPI

from synch_fields.bench.mpi.hierarchy import SpreadHierarchy
from synch_fields.bench.mpi.parts import parts_of, piece_of
from synch_fields.bench.mpi.relaxation import solve_parts
from synch_fields.core.connection import Connection
from synch_fields.core.problem import SynchronizationProblem

comm = MPI.COMM_WORLD


def main(folder):
    whole = np.load(folder / "whole.npz")
    connection = Connection(len(whole["mass"]), whole["edges"], whole["weights"], whole["transports"])
    parts, order = parts_of(connection, whole["mass"], comm.size)
    told = algebra(parts[comm.rank], connection, order) | solved(parts[comm.rank], connection, order)
    if comm.rank == 0:
        print(json.dumps(told))


def solved(part, connection, order):
    """Value, bound and energy as they come, and what the gathered fields give."""
    solution = solve_parts(part, comm, target_gap=1e-6)
    phases, lifted = np.empty(len(order), complex), np.concatenate(comm.allgather(solution.relaxation.lifted))
    phases[order] = np.concatenate(comm.allgather(solution.phases))
    matrix = SynchronizationProblem(connection).factor[:, order]
    return {
        "value": solution.relaxation.value,
        "bound": solution.relaxation.lower_bound,
        "certificate": solution.relaxation.certificate,
        "reached": solution.relaxation.reached,
        "energy": solution.energy,
        "value of the gathered": float((np.abs(matrix @ lifted) ** 2).sum()),
        "energy of the gathered": connection.energy(phases),
        "lengths": float(np.abs(np.linalg.norm(lifted, axis=1) - 1).max()),
        "nodes": comm.allgather(part.count),
    }


def algebra(part, connection, order):
    """How far products, levels and lowered levels are from those of dense matrices, as shares of the largest entry."""
    piece, whole, weight = piece_of(part, comm)
    factor = SynchronizationProblem(connection).factor[:, order] / np.sqrt(weight)
    dense = (factor.conj().T @ factor).toarray()
    hierarchy = SpreadHierarchy.of(whole, piece.row_mass, piece.reductions)
    diagonal = -np.random.default_rng(comm.rank).uniform(0, 0.1, part.count) * piece.matrix.diagonal().real
    lowered = hierarchy.lowered(diagonal)
    less = dense - np.diag(np.concatenate(comm.allgather(diagonal)))
    errors = {"matrix": distance(everywhere(piece.matrix), dense), "levels": 0.0, "lowered": 0.0, "adjoint": 0.0}
    for depth, (level, lower) in enumerate(zip(hierarchy.levels, lowered.levels, strict=True)):
        errors["levels"] = max(errors["levels"], distance(everywhere(level.matrix), dense))
        errors["lowered"] = max(errors["lowered"], distance(everywhere(lower.matrix), less))
        if level.prolongation is not None:
            way = everywhere(level.prolongation)
            restriction = hierarchy.restricted(rows_of_identity(level), depth + 1)
            restriction = np.concatenate(comm.allgather(restriction))
            errors["adjoint"] = max(errors["adjoint"], distance(restriction, way.conj().T))
            dense, less = way.conj().T @ dense @ way, way.conj().T @ less @ way
    refused = hierarchy.lowered(2 * piece.matrix.diagonal().real) is None
    return errors | {"sizes": [level.matrix.shape[0] for level in hierarchy.levels], "refused": refused}


def everywhere(matrix):
    """All of a spread matrix as a dense array, by its products with the identity."""
    counts = comm.allgather(matrix.fetching.count)
    first = sum(counts[: comm.rank])
    identity = np.eye(sum(counts), dtype=matrix.dtype)[first : first + counts[comm.rank]]
    return np.concatenate(comm.allgather(matrix @ identity))


def rows_of_identity(level):
    counts = comm.allgather(len(level.row_mass))
    first = sum(counts[: comm.rank])
    return np.eye(sum(counts), dtype=np.complex64)[first : first + counts[comm.rank]]


def distance(found, expected):
    return float(np.abs(found - expected).max() / np.abs(expected).max())


if __name__ == "__main__":
    main(Path(sys.argv[1]))
