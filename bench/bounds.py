# SPDX-License-Identifier: GPL-3.0-or-later
"""The chain of Eq. (23) on real meshes, beside spectral relaxation and diffusion on the same matrices.

    python bench/bounds.py MESH.obj [MESH.obj ...]

For direction fields n = 1, 2, 4 and stripes at two spacings (the longest side over 20 and over 40, along a
spectral line field) it prints as a Markdown table:
spectral bound <= lower bound <= SDP value <= polished energy <= energies of MBO and spectral relaxation,
the certified gap, and seconds. "MBO 0.1": time 0.1 on unit area until stationary, from the spectral field (the
paper's setting). "MBO falling": best of eight random starts with times halved from 1 / lambda_1, polished. Every
violated inequality is printed below the table.
"""

import sys
from itertools import pairwise
from pathlib import Path
from time import perf_counter

import numpy as np
from meshes import read_obj

from synch_fields.core.fields import direction_field
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.fields.stripes import stripe_problem
from synch_fields.core.solve import Options, solve
from synch_fields.core.solve.diffusion import diffuse
from synch_fields.core.solve.monitor import SILENT
from synch_fields.core.solve.spectral import smallest_eigenpair
from synch_fields.core.solve.spheres import Spheres
from synch_fields.core.solve.threads import one_blas_thread

COLUMNS = (
    ("spectral bound", "lower bound", "SDP", "polished", "MBO falling", "MBO 0.1", "spectral")
    + ("SDP gap", "proof", "s SDP", "s MBO falling", "s MBO 0.1", "s spectral")
)  # fmt: skip
MBO_TIME = 0.1
MBO_STEPS = 500


def main(paths):
    """Print the table; returns the number of violated inequalities."""
    print("| problem | " + " | ".join(COLUMNS) + " |")
    print("|---" * (len(COLUMNS) + 1) + "|")
    violations = []
    for path in paths:
        mesh = read_obj(path)
        for name, problem in problems(mesh):
            row, energies = measure(problem)
            label = f"{Path(path).stem} {name}"
            print(f"| {label} | " + " | ".join(row) + " |", flush=True)
            for smaller, larger in pairwise(COLUMNS[:4]):
                violations += _violation(label, energies, smaller, larger)
            for other in ("MBO falling", "MBO 0.1", "spectral"):
                violations += _violation(label, energies, "polished", other)
    print("\n".join(violations) or "All inequalities hold.")
    return len(violations)


def _violation(label, energies, smaller, larger):
    if energies[smaller] <= energies[larger] * (1 + 1e-9):
        return []
    return [f"violated: {label}: {smaller} {energies[smaller]:.6g} > {larger} {energies[larger]:.6g}"]


def problems(mesh):
    """Names and problems on one mesh."""
    for symmetry in (1, 2, 4):
        yield f"n = {symmetry}", direction_problem(mesh, symmetry)
    lines = direction_field(mesh, 2, options=Options(method="spectral"))
    size = np.ptp(mesh.vertices[np.unique(mesh.triangles)], axis=0).max()
    for across in (20, 40):
        yield f"stripes {across}", stripe_problem(mesh, lines, size / across)


def measure(problem):
    """The cells of a row, and its energies by column."""
    sdp, sdp_time = timed(lambda: solve(problem))
    spectral, spectral_time = timed(lambda: solve(problem, Options(method="spectral")))
    falling, falling_time = timed(lambda: solve(problem, Options(method="diffusion")))
    fixed, fixed_time = timed(lambda: fixed_diffusion(problem))
    energies = {
        "spectral bound": spectral.spectral_bound,
        "lower bound": sdp.lower_bound,
        "SDP": sdp.sdp_value,
        "polished": sdp.energy,
        "MBO falling": falling.energy,
        "MBO 0.1": fixed,
        "spectral": spectral.energy,
    }
    times = (sdp_time, falling_time, fixed_time, spectral_time)
    cells = [f"{value:.2f}" for value in energies.values()]
    cells += [f"{sdp.sdp_gap:.1e}", sdp.certificate] + [f"{seconds:.2f}" for seconds in times]
    return cells, energies


def fixed_diffusion(problem):
    """Energy after diffusion steps of one fixed time, started from the spectral field."""
    energy = 0.0
    with one_blas_thread():
        for piece in problem.pieces:
            spheres = Spheres(piece.block, lifted=False)
            start = smallest_eigenpair(piece, 0)[1][:, None]
            columns = diffuse(piece, spheres, start, [MBO_TIME], MBO_STEPS, SILENT, tolerance=1e-4)
            energy += float(piece.energy(columns)[0])
    return energy


def timed(work):
    """Result and wall seconds."""
    start = perf_counter()
    result = work()
    return result, perf_counter() - start


if __name__ == "__main__":
    sys.exit(min(main(sys.argv[1:]), 1))
