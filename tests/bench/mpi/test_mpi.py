# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One, two and four processes find the value and the bound that one without PETSc finds.

``SYNCH_PETSC_PYTHON`` names a Python that has petsc4py and mpi4py (docs/batch.md), where this one has none.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import synch_fields
from synch_fields.core.connection import Connection
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solution import Certificate
from synch_fields.core.solve import Options, solve

from ...core.meshes import bumpy_torus

pytestmark = pytest.mark.slow
PYTHON = os.environ.get("SYNCH_PETSC_PYTHON", sys.executable)
PROGRAM = Path(__file__).with_name("program.py")
GAP = 1e-6
ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": str(Path(synch_fields.__path__[0]).parent),
    "OPENBLAS_NUM_THREADS": "1",
    "SYNCH_THREADS": "1",
}


def has_petsc():
    code = "import mpi4py, petsc4py; petsc4py.init([]); from petsc4py import PETSc; assert PETSc.ScalarType(1j) == 1j"
    return subprocess.run([PYTHON, "-c", code], capture_output=True, check=False).returncode == 0


if not shutil.which("mpirun") or not has_petsc():
    pytest.skip(f"{PYTHON} has no petsc4py of complex numbers, or there is no mpirun", allow_module_level=True)


def ring_stripes():
    """Stripes around a torus, of which more are asked for outside than inside: they cannot be even everywhere."""
    rows, columns, lines = 24, 72, 20
    i, j = np.divmod(np.arange(rows * columns), rows)
    heads = np.append((i + 1) % columns * rows + j, i * rows + (j + 1) % rows)
    around = 2 * np.pi / columns * lines * (1 + 0.5 * np.cos(2 * np.pi * j / rows))
    transports = np.exp(1j * np.append(around, np.zeros(len(i))))
    edges = np.column_stack([np.tile(np.arange(len(i)), 2), heads])
    return SynchronizationProblem(Connection(len(i), edges, np.ones(len(edges)), transports))


PROBLEMS = {"stripes": ring_stripes, "crosses": lambda: direction_problem(bumpy_torus(20), 4)}


@pytest.fixture(scope="module", params=PROBLEMS)
def problem(request, tmp_path_factory):
    """A problem, the folder with its arrays, and its relaxation without PETSc."""
    problem, folder = PROBLEMS[request.param](), tmp_path_factory.mktemp(request.param)
    connection = problem.connection
    arrays = {name: getattr(connection, name) for name in ("edges", "weights", "transports")}
    np.savez(folder / "whole.npz", mass=problem.mass, **arrays)
    return problem, folder, solve(problem, Options(target_gap=GAP, rounding="polish"))


@pytest.fixture(scope="module", params=[1, 2, 4])
def told(request, problem):
    """What the processes say."""
    command = [
        "mpirun",
        "--allow-run-as-root",
        "--oversubscribe",
        "-n",
        str(request.param),
        PYTHON,
        PROGRAM,
        problem[1],
    ]
    done = subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, timeout=500, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_value_and_bound_are_those_of_one_process_without_petsc(problem, told):
    alone = problem[2]
    assert alone.certificate is Certificate.PROVED and alone.sdp_gap <= GAP
    assert told["reached"] and told["certificate"] == Certificate.ESTIMATED
    assert told["value"] == pytest.approx(alone.sdp_value, rel=GAP)
    assert told["bound"] == pytest.approx(alone.lower_bound, rel=GAP)
    assert told["bound"] <= alone.sdp_value * (1 + 1e-9), "a bound that is proved wrong"


def test_the_fields_that_the_processes_hold_have_the_value_and_the_energy_that_they_say(problem, told):
    assert told["lengths"] < 1e-12
    assert told["value of the gathered"] == pytest.approx(told["value"], rel=1e-9)
    assert told["energy of the gathered"] == pytest.approx(told["energy"], rel=1e-9)
    assert told["bound"] <= told["energy"] < 1.1 * problem[2].energy


def test_matrices_and_levels_are_those_of_dense_algebra(told):
    assert told["matrix"] < 1e-12
    assert len(told["sizes"]) >= 2 and told["refused"]
    assert max(told["levels"], told["lowered"], told["adjoint"]) < 3e-6


def test_the_nodes_are_shared_out_evenly(problem, told):
    assert sum(told["nodes"]) == problem[0].connection.node_count
    assert max(told["nodes"]) - min(told["nodes"]) <= 1
