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
from functools import partial
from itertools import pairwise
from pathlib import Path

from synch_fields.bench.command import arguments
from synch_fields.bench.measure import energy_of, timed
from synch_fields.bench.meshes import read_obj
from synch_fields.bench.peers import fixed_diffusion
from synch_fields.bench.problems import problems
from synch_fields.core.solve import Options, solve

COLUMNS = (
    ("spectral bound", "lower bound", "SDP", "polished", "MBO falling", "MBO 0.1", "spectral")
    + ("SDP gap", "proof", "s SDP", "s MBO falling", "s MBO 0.1", "s spectral")
)  # fmt: skip
MBO_TIME = 0.1


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


def measure(problem):
    """The cells of a row, and its energies by column."""
    sdp, sdp_time = timed(solve, problem)
    spectral, spectral_time = timed(solve, problem, Options(method="spectral"))
    falling, falling_time = timed(solve, problem, Options(method="diffusion"))
    fixed, fixed_time = timed(energy_of, problem, partial(fixed_diffusion, time=MBO_TIME, polished=False))
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


if __name__ == "__main__":
    parser = arguments(__doc__)
    parser.add_argument("paths", type=Path, nargs="+", metavar="MESH.obj")
    sys.exit(min(main(parser.parse_args().paths), 1))
