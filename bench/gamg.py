# SPDX-License-Identifier: GPL-3.0-or-later
"""Conjugate gradients with PETSc's GAMG, given candidates that are carried along the transports, beside ours.

    python bench/gamg.py torus=40000 torus=160000 sphere=39692

The shapes are those of bench/spread.py; the matrix is the metric of the relaxation, L + shift M with a tenth of the
energy per mass as the shift, the right-hand side is random.
"""

from time import process_time

import numpy as np
from petsc4py import PETSc
from scipy.sparse import diags_array

from synch_fields.bench.command import arguments
from synch_fields.bench.spread import problem_of
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.algebra.metric import Hierarchy, Metric
from synch_fields.core.solve import Options, solve
from synch_fields.core.solve.methods.stage import LIFTED_SHIFT

MOST_STEPS, TOLERANCE = 400, 1e-6
COLUMNS = (
    Column("nodes", "nodes", "d"),
    Column("steps", "steps", "d"),
    Column("residual", "residual", ".0e"),
    Column("CPU s", "cpu", ".2f"),
)


def main():
    """Print a table for every shape."""
    parser = arguments(__doc__)
    parser.add_argument("shapes", nargs="+", metavar="SHAPE=NODES")
    for text in parser.parse_args().shapes:
        shape, _, count = text.partition("=")
        print_table(shape, COLUMNS, list(preconditioners(shape, int(count))), "preconditioner")


def preconditioners(shape, count):
    """Rows of the steps that conjugate gradients take."""
    problem = problem_of(shape, count)
    piece, weight = problem.pieces[0].scaled()
    value = solve(problem, Options(rounding="svd")).sdp_value / weight
    shift = LIFTED_SHIFT * value / piece.total_mass
    hierarchy = Hierarchy(piece.matrix, piece.row_mass, 1)
    matrix = (piece.matrix + shift * diags_array(piece.row_mass)).tocsr()
    carried = [_carried(hierarchy, seed) for seed in range(3)]
    turn = diags_array(carried[0])
    turned = (turn.conj() @ matrix @ turn).tocsr()
    plain = {"pc_gamg_agg_nsmooths": 0}
    ways = (
        ("aggregates that carry phases (ours)", matrix, _Ours(Metric(hierarchy, shift)), {}, []),
        ("Jacobi", matrix, "jacobi", {}, []),
        ("GAMG as it comes", matrix, "gamg", {}, []),
        ("GAMG, one carried candidate", matrix, "gamg", {}, carried[:1]),
        ("GAMG, three carried candidates", matrix, "gamg", {}, carried),
        ("GAMG, one carried candidate, not smoothed", matrix, "gamg", plain, carried[:1]),
        ("GAMG in the candidate's coordinates", turned, "gamg", {}, []),
        ("GAMG in the candidate's coordinates, not smoothed", turned, "gamg", plain, []),
    )
    right = np.random.default_rng(0).standard_normal(matrix.shape[0]) + 0j
    for label, *way in ways:
        start = process_time()
        steps, solution = _solved(right, *way)
        cpu = process_time() - start
        residual = np.linalg.norm(way[0] @ solution - right) / np.linalg.norm(right)
        yield {"label": label, "nodes": piece.node_count, "steps": steps, "residual": residual, "cpu": cpu}


def _solved(right, matrix, kind, settings, candidates):
    """Steps and solution of conjugate gradients by PETSc."""
    system = PETSc.Mat().createAIJ(matrix.shape, csr=(matrix.indptr, matrix.indices, matrix.data))
    if candidates:
        basis = [system.createVecLeft() for _ in candidates]
        for vector, values in zip(basis, np.linalg.qr(np.column_stack(candidates))[0].T, strict=True):
            vector.array[:] = values
        system.setNearNullSpace(PETSc.NullSpace().create(vectors=basis))
    solver, options = PETSc.KSP().create(), PETSc.Options()
    for name, value in settings.items():
        options[name] = value
    solver.setOperators(system)
    solver.setType("cg")
    solver.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
    solver.setTolerances(rtol=TOLERANCE, max_it=MOST_STEPS)
    if isinstance(kind, str):
        solver.getPC().setType(kind)
    else:
        solver.getPC().setType("python")
        solver.getPC().setPythonContext(kind)
    solver.setFromOptions()
    solution, image = system.createVecLeft(), system.createVecLeft()
    image.array[:] = right
    solver.solve(image, solution)
    for name in settings:
        options.delValue(name)
    return solver.getIterationNumber(), solution.array.copy()


class _Ours:
    """A metric as PETSc asks for it."""

    def __init__(self, metric):
        self._metric = metric

    def apply(self, _preconditioner, right, solution):
        solution.array[:] = self._metric.solve(right.array.copy())


def _carried(hierarchy, seed):
    """(N,) unit numbers carried along the transports from the smallest level's nodes, with random phases there."""
    smallest = hierarchy.levels[-1].matrix.shape[0]
    values = np.exp(2j * np.pi * np.random.default_rng(seed).uniform(size=smallest)).astype(np.complex64)
    for level in hierarchy.levels[-2::-1]:
        values = level.tentative @ values
    return values.astype(complex)


if __name__ == "__main__":
    main()
