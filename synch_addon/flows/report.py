# SPDX-License-Identifier: GPL-3.0-or-later
"""What a solved flow is, and what its report, the panel and the command line say of it."""

import json
import time
from dataclasses import asdict, dataclass, field

import numpy as np

from ...core.fields.clebsch import ClebschMap, SphericalMap
from ...core.fields.loops import loop_error
from ...core.solve.solution import relative_gap
from ..jobs.report import counted, peak_memory, quality, versions


@dataclass(frozen=True)
class SolvedFlow:
    """A solved flow, of which every point of the sphere shows other vortices.

    Attributes
    ----------
    name : of what the flow was read from
    found : ClebschMap, the best
    sphere : SphericalMap, None for methods without a relaxation
    settings : ClebschSettings
    warnings : lines that the user should read
    sources : names of the objects that the flow was read from
    """

    name: str
    found: ClebschMap
    sphere: SphericalMap | None
    settings: object
    warnings: list[str] = field(default_factory=list)
    sources: tuple[str, ...] = ()


def report_of(solved, found, made, start):
    """The report of a run that began at ``start`` and made, or filled anew, some objects; the last one is active.

    ``found`` is the map whose filaments are shown.
    """
    solution, energy, sphere = found.solution, found.energy, solved.sphere
    of_sphere = {"sphere": sphere.seconds} if sphere else {}
    return {
        "status": solution.status.value,
        "command": "clebsch",
        "source": solved.name,
        "object": made[-1].name,
        "objects": [obj.name for obj in made],
        "nodes": found.grid.node_count,
        "edges": len(found.grid.edges),
        "shape": list(found.grid.shape),
        "quantum": found.quantum,
        **quality(solution),
        "energy": energy,
        "gap": relative_gap(energy, solution.lower_bound, solution.noise),
        "sphere_energy": sphere.energy if sphere else None,
        "vorticity_share": vorticity_share(found, solved.found.vorticity),
        "times": solution.times | of_sphere | {"total": time.perf_counter() - start},
        "peak_memory_mb": peak_memory(),
        "settings": asdict(solved.settings),
        "warnings": solved.warnings,
        "versions": versions(),
    }


def vorticity_share(found, vorticity):
    """What of the flow's vorticity through all faces the filaments carry; None for a flow without any."""
    caught = found.quantum * np.abs(found.face_numbers).sum()
    return float(caught / vorticity) if vorticity else None


def circulation_error(found):
    """How far the number of filaments through a loop is from the flow's circulation along it, in quanta and root mean
    square over all square loops a quarter of the grid's longest side wide; None where there are none."""
    return loop_error(found, max(found.grid.shape) // 4)


def result_line(report):
    """What the panel shows of a report, as JSON."""
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
    return json.dumps(line)


def summary(report):
    """The lines that a person wants to read."""
    shape = " x ".join(str(count) for count in report["shape"] or [report["nodes"]])
    lines = [f"clebsch on {report['source']}: {shape} nodes, filaments of circulation {report['quantum']:.4g}"]
    if "frames" in report:
        counts = [frame["filaments"] for frame in report["frames"]]
        counts = f"{min(counts)} to {max(counts)}" if min(counts) < max(counts) else f"{counts[0]}"
        lines.append(f"{report['object']}: {counted(len(report['frames']), 'frame')}, filaments in each: {counts}")
        return [*lines, f"{report['times']['total']:.2f} s"]
    bound = f"lower bound {report['lower_bound']:.6g} ({report['certificate']})"
    lines.append(f"energy {report['energy']:.6g}, {bound}: {report['status']}")
    *others, last = report["objects"]
    if "vortices" in report:
        covered = f", the sphere is covered {report['coverage']:.2f} times" if "coverage" in report else ""
        lines.append(f"{last}: {counted(len(report['vortices']), 'vortex')}{covered}")
    if "filaments" in report:
        closed = sum(line["closed"] for line in report["filaments"])
        lines.append(f"{last}: {counted(len(report['filaments']), 'filament')}, {closed} of them closed")
    if "tubes" in report:
        name = others[0] if others else last
        lines.append(f"{name}: {counted(report['tubes']['pieces'], 'tube')}, {report['tubes']['faces']} faces")
    return [*lines, f"{report['times']['total']:.2f} s"]
