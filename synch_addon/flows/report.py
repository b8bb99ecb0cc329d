# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports of solved flows, for the panel and the command line."""

from dataclasses import asdict, replace

import numpy as np

from ...core.files.json_text import NUMBER, json_text
from ..jobs.report import count_text, ending, quality

# Of what the panel shows, by its name: what it is where it is missing, and its kind.
VALUES = {
    "energy": (0.0, NUMBER),
    "gap": (None, NUMBER),
    "certificate": (None, str),
    "nodes": (0, int),
    "quantum": (0.0, NUMBER),
    "vorticity_share": (None, NUMBER),
    "seconds": (0.0, NUMBER),
    "look": ({}, dict),
    "filaments": (None, int),
    "closed": (None, int),
    "length": (None, NUMBER),
    "tubes": (None, int),
    "vortices": (None, int),
}


def report_of(solved, filled, objects, start):
    """The report of a run that began at ``start`` and made, or filled anew, some objects; the last one is active."""
    result, found = solved.result, solved.result.seen
    solution, sphere = found.solution, result.sphere
    share = None if result.shown is None else result.shown.share  # without stubs
    return {
        "status": solution.status.value,
        **_of_grid(solved.name, objects[-1], found.grid, found.quantum),
        "objects": [obj.name for obj in objects],
        **quality(replace(solution, energy=found.energy)),
        "sphere_energy": sphere.energy if sphere else None,
        "vorticity_share": found.vorticity_share if share is None else share,
        **ending(asdict(solved.settings), solution.times | result.seconds, start, [*result.warnings, *filled.warnings]),
        **filled.facts,
    }


def sequence_report(name, settings, result, collection, start):
    """The report of a sequence's run that began at ``start`` and made a collection."""
    return {
        "status": "solved",
        **_of_grid(name, collection, result.grid, result.quantum),
        "frames": [frame.facts for frame in result.frames],
        **ending(asdict(settings), result.seconds, start, list(result.warnings)),
    }


def _of_grid(source, made, grid, quantum):
    return {
        "command": "clebsch",
        "source": source,
        "object": made.name,
        "nodes": grid.node_count,
        "edges": len(grid.edges),
        "shape": list(grid.shape),
        "quantum": quantum,
    }


def result_line(report):
    """The part of a report that the panel shows, as JSON."""
    names = ("energy", "gap", "certificate", "status", "nodes", "quantum", "vorticity_share")
    line = {name: report[name] for name in names} | {"seconds": report["times"]["total"]}
    line["look"] = {name: report["settings"][name] for name in ("point", "opening", "smoothing")}
    if "filaments" in report:
        line["filaments"] = len(report["filaments"])
        line["closed"] = sum(one["closed"] for one in report["filaments"])
        line["length"] = sum(one["length"] for one in report["filaments"])
    if "tubes" in report:
        line["tubes"] = report["tubes"]["pieces"]
    if "vortices" in report:
        line["vortices"] = len(report["vortices"])
    return json_text(line)


def summary(report):
    """The lines that a person wants to read."""
    shape = " x ".join(str(count) for count in report["shape"] or [report["nodes"]])
    lines = [f"clebsch on {report['source']}: {shape} nodes, filaments of circulation {report['quantum']:.4g}"]
    if "frames" in report:
        counts = [frame["filaments"] for frame in report["frames"]]
        counts = f"{min(counts)} to {max(counts)}" if min(counts) < max(counts) else f"{counts[0]}"
        lines.append(f"{report['object']}: {count_text(len(report['frames']), 'frame')}, filaments in each: {counts}")
        return [*lines, f"{report['times']['total']:.2f} s"]
    bound = f"lower bound {report['lower_bound']:.6g} ({report['certificate']})"
    lines.append(f"energy {report['energy']:.6g}, {bound}: {report['status']}")
    *others, last = report["objects"]
    if "vortices" in report:
        covered = f", the sphere is covered {report['coverage']:.2f} times" if "coverage" in report else ""
        lines.append(f"{last}: {count_text(len(report['vortices']), 'vortex')}{covered}")
    if "filaments" in report:
        closed = sum(line["closed"] for line in report["filaments"])
        around = f", {report['windings']} around the box" if report["windings"] else ""
        counted = f"{last}: {count_text(len(report['filaments']), 'filament')}, {closed} of them closed{around}"
        share = report["vorticity_share"]
        lines.append(counted if share is None else f"{counted}, with {share:.0%} of the vorticity")
    if report.get("loops"):
        links = int(np.abs(np.triu(report["linking"])).sum())
        lines.append(f"linked {links} times, writhe {sum(report['writhe']):.3g}, helicity {report['helicity']:.4g}")
    if "tubes" in report:
        name = others[0] if others else last
        lines.append(f"{name}: {count_text(report['tubes']['pieces'], 'tube')}, {report['tubes']['faces']} faces")
    return [*lines, f"{report['times']['total']:.2f} s"]
