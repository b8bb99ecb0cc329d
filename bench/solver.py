# SPDX-License-Identifier: GPL-3.0-or-later
"""The solver beside its peers: times, bounds and energies, all in one run on the same matrices.

    python bench/solver.py MESH.obj [MESH.obj ...] [--repeat 3] [--paper] [--cap 110] [--problems "n = 1" ...]
        [--record] [--cpu]

Prints Markdown: for every mesh a table of ours, of the peers and of ratios, and at the end how many rows
hold each criterion. bench/README.md says what the columns mean. Progress goes to stderr.
"""

import argparse
import sys
from functools import partial
from pathlib import Path
from statistics import median

from synch_fields.bench import paper_method, peers, problems
from synch_fields.bench.best_known import BestKnown
from synch_fields.bench.measure import (
    cycle_products,
    energy_of,
    in_child,
    peak_megabytes,
    product_seconds,
    time_the_processor,
    timed,
    timed_relaxation,
    timed_solve,
)
from synch_fields.bench.meshes import read_obj
from synch_fields.bench.tables import Column, Criterion, print_summary, print_table
from synch_fields.core.algebra.workers import solving
from synch_fields.core.solve import Options, solve

CERTIFICATES = ("none", "estimated", "proved")
# Energies that agree this well are the same optimum.
SAME_ENERGY = 1e-6
# How well the paper's method has to agree with our value of the relaxation.
SAME_VALUE = 1e-3
# Gaps for which the relaxation is timed.
COARSE_GAP, FINE_GAP = 1e-2, 1e-3
PEERS = {
    "plain": "eigsh",
    "tuned": "tuned",
    "fixed": "MBO 0.1",
    "fixed rate": "MBO 1/λ₁",
    "falling": "MBO falling",
    "falling one": "one start",
}

OURS = (
    Column("nodes", "nodes", "d"),
    Column("edges", "edges", "d"),
    Column("s to 1e-2", "coarse s", ".3f"),
    Column("gap", "coarse gap", ".1e"),
    Column("× LY", "coarse LY", ".0f"),
    Column("s to 1e-3", "fine s", ".3f"),
    Column("gap", "fine gap", ".1e"),
    Column("× LY", "fine LY", ".0f"),
    Column("products", "products", ".0f"),
    Column("counted", "counted", ".0f"),
    Column("rank", "rank", ".0f"),
    Column("SDP", "sdp", ".3f"),
    Column("bound", "bound", ".3f"),
    Column("certificate", "certificate", ""),
    Column("energy", "energy", ".3f"),
    Column("above best known", "above", ".2%"),
    Column("gap of energy", "gap", ".1%"),
    Column("s solve", "solve s", ".3f"),
    Column("MB", "megabytes", ".0f"),
)
BESIDE = (
    Column("ours", "energy", ".3f"),
    Column("eigsh", "plain energy", ".3f"),
    Column("tuned", "tuned energy", ".3f"),
    Column("MBO 0.1", "fixed energy", ".3f"),
    Column("MBO 1/λ₁", "fixed rate energy", ".3f"),
    Column("MBO falling", "falling energy", ".3f"),
    Column("one start", "falling one energy", ".3f"),
    Column("s ours", "solve s", ".3f"),
    Column("s eigsh", "plain s", ".3f"),
    Column("s tuned", "tuned s", ".3f"),
    Column("s MBO 0.1", "fixed s", ".3f"),
    Column("s MBO 1/λ₁", "fixed rate s", ".3f"),
    Column("s MBO falling", "falling s", ".3f"),
    Column("s one start", "falling one s", ".3f"),
)
RATIOS = (
    Column("relaxation / eigsh", "relaxation / plain", ".2f"),
    Column("relaxation / tuned", "relaxation / tuned", ".2f"),
    Column("solve / eigsh", "solve / plain", ".2f"),
    Column("solve / tuned", "solve / tuned", ".2f"),
    Column("solve / MBO falling", "solve / falling", ".2f"),
    Column("energy / best peer", "energy / best", ".5f"),
    Column("best peer", "best peer", ""),
)
PAPER = (
    Column("SDP ours", "sdp", ".3f"),
    Column("s ours", "fine s", ".3f"),
    Column("SDP RTR", "RTR sdp", ".3f"),
    Column("rank", "RTR rank", "d"),
    Column("s within 1e-3", "RTR s within", ""),
    Column("/ ours", "RTR within / ours", ".3g"),
    Column("s to the end", "RTR s", ""),
    Column("/ ours", "RTR / ours", ".3g"),
    Column("SVD energy", "RTR energy", ".3f"),
    Column("SDP RTR+P", "RTR+P sdp", ".3f"),
    Column("rank", "RTR+P rank", "d"),
    Column("s within 1e-3", "RTR+P s within", ""),
    Column("/ ours", "RTR+P within / ours", ".3g"),
    Column("s to the end", "RTR+P s", ""),
    Column("/ ours", "RTR+P / ours", ".3g"),
    Column("SVD energy", "RTR+P energy", ".3f"),
)
CRITERIA = (
    Criterion("relaxation (gap 1e-2) ≤ 2 × eigsh", "relaxation / plain", 2),
    Criterion("relaxation (gap 1e-2) ≤ 2 × tuned eigsh", "relaxation / tuned", 2),
    Criterion("whole solve ≤ 6 × eigsh", "solve / plain", 6),
    Criterion("whole solve ≤ 6 × tuned eigsh", "solve / tuned", 6),
    Criterion("whole solve ≤ MBO falling, 8 starts", "solve / falling", 1),
    Criterion("gap ≤ 1e-2 reached", "coarse gap", COARSE_GAP),
    Criterion("gap ≤ 1e-3 reached", "fine gap", FINE_GAP),
    Criterion("gap ≤ 1e-3 in ≤ 1000 products LY, counted", "counted", 1000),
    Criterion("gap ≤ 1e-3 in the time of ≤ 1000 products LY", "fine LY", 1000),
    Criterion("energy ≤ best peer (to six digits; wanted on 95 %)", "energy / best", 1 + SAME_ENERGY),
    Criterion("energy ≤ 1.005 × best peer", "energy / best", 1.005),
    Criterion("≥ 100 × faster than RTR to a gradient of 1e-6, from 10k nodes", "RTR / ours", 100, True, 10_000),
    Criterion(
        "≥ 100 × faster than RTR to our SDP value within 1e-3, from 10k nodes", "RTR within / ours", 100, True, 10_000
    ),
)


def main():
    """Print the tables and the summary."""
    options = _arguments()
    if options.cpu:
        time_the_processor()
    rows, known = [], BestKnown()
    with solving():
        for path in options.meshes:
            mesh = read_obj(path)
            stem = Path(path).stem
            of_mesh = []
            for name, problem in problems.problems(mesh, options.problems):
                print(f"{stem} {name}", file=sys.stderr, flush=True)
                row = {"label": f"{stem} {name}"} | measure(problem, options)
                row["above"] = known.distance(row["label"], problem, row["energy"])
                known.see(row["label"], problem, row["least energy"])
                of_mesh.append(row)
            print(f"\n### {stem}")
            print_table("Ours", OURS, of_mesh)
            print_table("Energies and seconds beside the peers", BESIDE, of_mesh)
            print_table("Ratios", RATIOS, of_mesh)
            if options.paper:
                print_table("The paper's method", PAPER, of_mesh)
            rows += of_mesh
    if options.record:
        known.save()
    print("\n### Summary")
    print_summary(CRITERIA, rows)


def _arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="+", metavar="MESH.obj")
    parser.add_argument("--repeat", type=int, default=3, help="runs, of which medians are printed (3)")
    parser.add_argument("--problems", nargs="+", choices=problems.NAMES, default=problems.NAMES)
    parser.add_argument("--record", action="store_true", help="keep energies below the best known ones")
    parser.add_argument("--cpu", action="store_true", help="CPU seconds, for machines with other work")
    parser.add_argument("--paper", action="store_true", help="also the paper's method, which is slow")
    parser.add_argument("--cap", type=float, default=110, help="stop it after so many times our seconds (110)")
    return parser.parse_args()


def measure(problem, options):
    """The medians of all columns for one problem."""
    # The same fields from the same start every time, and no ratio needs their seconds: once is enough.
    once = run_fixed_diffusion(problem) | {"megabytes": in_child(peak_of_solve, problem)}
    runs = [run(problem, seed) | once for seed in range(options.repeat)]
    for numbers in runs:
        numbers |= ratios(numbers)
    row = {key: _median([numbers[key] for numbers in runs]) for key in runs[0]}
    row |= {"nodes": problem.connection.node_count, "edges": len(problem.connection.edges)}
    row["least energy"] = min(numbers[key] for numbers in runs for key in ("energy", *(f"{p} energy" for p in PEERS)))
    row["best peer"] = PEERS[min(PEERS, key=lambda peer: row[f"{peer} energy"])]
    return row | (run_paper(problem, row, options.cap) if options.paper else {})


def _median(values):
    """Of numbers; of certificates the weakest."""
    return min(values, key=CERTIFICATES.index) if isinstance(values[0], str) else median(values)


def run(problem, seed):
    """One run of ours and of the peers, by turns, so that the machine's load hits all alike."""
    plain_energy, plain = timed(energy_of, problem, peers.plain_spectral)
    coarse, coarse_seconds = timed_relaxation(problem, COARSE_GAP, seed)
    tuned, tuned_seconds = timed_solve(problem, method="spectral", seed=seed)
    fine, fine_seconds = timed_relaxation(problem, FINE_GAP, seed)
    coarse_product = product_seconds(problem, coarse.rank)
    fine_product = product_seconds(problem, fine.rank)
    whole, whole_seconds = timed_solve(problem, seed=seed)
    falling_energy, falling = timed(energy_of, problem, partial(peers.falling_diffusion, starts=8, seed=seed))
    one_energy, one = timed(energy_of, problem, partial(peers.falling_diffusion, starts=1, seed=seed))
    return {
        "plain energy": plain_energy,
        "plain s": plain,
        "tuned energy": tuned.energy,
        "tuned s": tuned_seconds,
        "falling energy": falling_energy,
        "falling s": falling,
        "falling one energy": one_energy,
        "falling one s": one,
        "coarse s": coarse_seconds,
        "coarse gap": coarse.sdp_gap,
        "coarse LY": coarse_seconds / coarse_product,
        "fine s": fine_seconds,
        "fine gap": fine.sdp_gap,
        "fine LY": fine_seconds / fine_product,
        "products": fine.products / max(fine.rank, 1),
        "counted": fine.products / max(fine.rank, 1) + fine.iterations * cycle_products(problem, fine.rank),
        "rank": fine.rank,
        "sdp": fine.sdp_value,
        "bound": whole.lower_bound,
        "certificate": whole.certificate,
        "energy": whole.energy,
        "gap": whole.gap,
        "solve s": whole_seconds,
    }


def run_fixed_diffusion(problem):
    """MBO at fixed times."""
    fixed_energy, fixed = timed(energy_of, problem, partial(peers.fixed_diffusion, time=0.1))
    rate_energy, rate = timed(energy_of, problem, peers.fixed_diffusion)
    return {"fixed energy": fixed_energy, "fixed s": fixed, "fixed rate energy": rate_energy, "fixed rate s": rate}


def peak_of_solve(problem):
    """Megabytes of a process that has solved one problem by default."""
    with solving():
        solve(problem, Options())
    return peak_megabytes()


def ratios(numbers):
    """Ours by theirs, within one run."""
    best = min(numbers[f"{peer} energy"] for peer in PEERS)
    return {
        "relaxation / plain": numbers["coarse s"] / numbers["plain s"],
        "relaxation / tuned": numbers["coarse s"] / numbers["tuned s"],
        "solve / plain": numbers["solve s"] / numbers["plain s"],
        "solve / tuned": numbers["solve s"] / numbers["tuned s"],
        "solve / falling": numbers["solve s"] / numbers["falling s"],
        "energy / best": numbers["energy"] / best,
    }


def run_paper(problem, row, cap):
    """The staircase without and with a preconditioner, stopped after ``cap`` times our seconds: ratios are lower bounds
    then."""
    if len(problem.pieces) > 1:
        return {}
    cells = {}
    for name, preconditioned in (("RTR", False), ("RTR+P", True)):
        print(f"  {name}", file=sys.stderr, flush=True)
        reached = paper_method.staircase(problem.pieces[0], 0, cap * row["fine s"], preconditioned)
        within = reached.seconds_to(row["sdp"] * (1 + SAME_VALUE))
        cells |= {
            f"{name} sdp": reached.value,
            f"{name} rank": reached.rank,
            f"{name} s": f"{reached.seconds:.2f}" + (", capped" if reached.capped else ""),
            f"{name} / ours": reached.seconds / row["fine s"],
            f"{name} s within": f"not in {reached.seconds:.2f}" if within is None else f"{within:.2f}",
            f"{name} within / ours": (reached.seconds if within is None else within) / row["fine s"],
            f"{name} energy": reached.energy,
        }
    return cells


if __name__ == "__main__":
    main()
