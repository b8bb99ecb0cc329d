# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a run: its settings, what it found and what it wrote, as plain values for JSON."""

import platform
import time
from copy import copy
from dataclasses import asdict, replace

import bpy
import numpy as np
import scipy

from ... import __version__
from ...core.errors import name_elements, one_line, plural
from ...core.geometry.check import coarse_mesh
from ...core.geometry.mirror import TOLERANCE
from ...core.memory import peak_megabytes
from ...core.solution import Clock
from ..blender.meshes import measured_key
from ..blender.modifiers import changing_modifiers


class Report:
    """Collects warnings and times during a run and becomes a dict at its end."""

    def __init__(self, command, obj, settings):
        self.command, self.object_name = command, obj.name
        self.asked = self.settings = settings  # as they are asked for, and with what was found on the way
        self.clock = Clock()
        self.warnings = []
        self.forced_dislocations = None
        self.quad_mesh = None
        self.ended_early = False  # whether a search was ended with what it had found
        self.pins_cost = None
        self.surface = None  # figures of the finer surface, if the pattern is on one
        self.shape_key = None  # name of the one whose shape was solved on
        self.curves_read = ()  # state of the curves that the settings name, to notice a change
        self.made_from = ""  # state of all that a quad mesh is made of, likewise; "" where shown quads were traced
        self._settled = {}
        self._start = time.perf_counter()
        self._request = None

    def for_another_result(self, command=None):
        """A report of the same run for another result of its solve, with new times and without warnings."""
        fresh = copy(self)
        fresh.command, fresh.pins_cost = command or self.command, None
        fresh.clock, fresh.warnings, fresh._start = Clock(), [], time.perf_counter()
        return fresh

    def warn(self, line):
        """Add a line that the user should read although the run succeeds."""
        self.warnings.append(one_line(line))

    def take(self, result):
        """Add a result's warnings, times, and settings that were changed on the way."""
        self.warnings += result.warnings
        self.forced_dislocations = getattr(result, "forced_dislocations", None)
        self._settled = getattr(result, "settled", {})
        self.clock.add(result.seconds)

    def warn_about(self, obj, request, refinement=None):
        """Warn about parts of the object and settings that the result does not follow.

        ``refinement`` describes the finer surface if the pattern is on one.
        """
        self._request, key = request, measured_key(obj)
        self.shape_key = None if key is None else key.name
        for finding in request.given.findings:
            self.warn(finding.line)
        coarse = coarse_mesh(request.given.mesh)
        if coarse:
            self.warn(coarse)
        loose = request.given.loose_vertices
        if len(loose):
            self.warn(
                f"{name_elements('vertex', loose)} without a face get no field: "
                "remove loose geometry with Mesh > Clean Up > Delete Loose"
            )
        if refinement is not None:
            self.surface = refinement.figures
            if refinement.bound.welded:
                self.warn(
                    f"{refinement.bound.welded} vertices at the places of others, or on edges of other faces, count as "
                    "joined with these: Mesh > Merge > By Distance joins the former"
                )
            apart = refinement.bound.apart
            if apart is not None:
                near = TOLERANCE * np.median(request.given.mesh.edge_lengths)
                how = "" if apart <= near else f", up to {apart:.3g} from the other one"
                self.warn(
                    f"the mesh is not symmetric in {', '.join(refinement.mirror)}: its positive side is mirrored{how}"
                )
        elif self.command != "animate":  # animations are solved on the result of the modifiers
            self.warn_of_modifiers(changing_modifiers(obj), "the pattern is")
        for line in request.settings.unheeded(request.command, bool(np.any(request.turn))):
            self.warn(line)
        if self.command != "quad_mesh" and refinement is None:
            self.warn_of_users(obj, "the pattern")

    def warn_of_modifiers(self, modifiers, solved):
        """Warn about modifiers that are not applied before the solve; ``solved`` begins the line: "the pattern is"."""
        if modifiers:
            names = ", ".join(modifier.name for modifier in modifiers)
            self.warn(
                f"{solved} solved on the mesh before its modifiers ({names}): apply them first to solve on their result"
            )

    def warn_of_users(self, obj, what):
        """Warn if other objects use the same mesh."""
        users = obj.data.users - obj.data.use_fake_user
        if users > 1:
            self.warn(f"the mesh {obj.data.name} is shared by {users} users, which all get {what}")

    def opening_entries(self, solution, mesh):
        """The first entries of the report of a solve on the vertices of a triangle or tetrahedral mesh."""
        return {
            "status": solution.status.value if solution else "given",
            "command": self.command,
            "object": self.object_name,
            "nodes": mesh.vertex_count - len(mesh.loose_vertices),
            "edges": len(mesh.edges),
            **quality(solution),
        }

    def closing_entries(self, solutions, settings):
        """The last entries of the report: seed, settings, times and warnings.

        ``solutions`` has one for each solve, None for given directions; ``settings`` replace those of the run.
        """
        clock = Clock()
        for times in [self.clock.seconds, *(solution.times for solution in solutions if solution)]:
            clock.add(times)
        settings = asdict(self.settings) | settings
        return {"seed": self.settings.seed, **ending(settings, clock.seconds, self._start, self.warnings)}

    def finish(self, field, pattern, defects):
        """The report as a dict of plain values."""
        solution = field.solution if pattern is None else pattern.solution
        mesh = self._request.given.mesh
        solutions = [part.solution for part in (field, pattern) if part is not None]
        rows = [asdict(row) for row in self.settings.constraints]
        shown = field if pattern is None else pattern
        if solution is not None:  # the energy of a variation differs from the solution's
            solution = replace(solution, energy=shown.energy)
        report = self.opening_entries(solution, mesh)
        if self.settings.method == "spectral":
            report["spectral_energy"] = report["energy"]
        if pattern is not None:
            report["directions"] = quality(field.solution)
            report["evenness"] = pattern.evenness.figures
        return report | {
            "carrier": self._request.given.finding_counts,
            "euler_characteristic": self._request.given.euler_characteristic,
            "closed": self._request.given.is_closed,
            "disclinations": [d for d in defects if d["kind"] == "disclination"],
            "dislocations": [d for d in defects if d["kind"] == "dislocation"],
            "forced_dislocations": self.forced_dislocations,
            **({"quad_mesh": self.quad_mesh} if self.quad_mesh else {}),
            **{
                name: value
                for name in ("pins_cost", "shape_key", "surface")
                if (value := getattr(self, name)) is not None
            },
            **self.closing_entries(solutions, {"spacing": self._request.spacing, "constraints": rows} | self._settled),
        }


def ending(settings, times, start, warnings):
    """The last entries of the report of every run: the dict of its settings, the seconds of its parts by name, the
    seconds since its start, by ``time.perf_counter``, and the lines of warnings."""
    return {
        "times": times | {"total": time.perf_counter() - start},
        "peak_memory_mb": peak_megabytes(),
        "settings": settings,
        "warnings": warnings,
        "versions": versions(),
    }


def failure(command, settings, error):
    """The report of a run that was refused."""
    return {"status": "failed", "command": command, "error": str(error), "settings": settings, "versions": versions()}


def quality(solution):
    """Energy, bounds and certificate of a solution; nulls for directions that were given."""
    names = ("energy", "lower_bound", "gap", "sdp_value", "sdp_gap", "certificate", "rank", "iterations")
    values = {name: getattr(solution, name, None) for name in names}
    values["spectral_bound"] = getattr(solution, "spectral_bound", None)
    return values


def versions():
    """Versions of everything that a result may depend on."""
    return {
        "synch_fields": __version__,
        "blender": bpy.app.version_string,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
    }


def _energy_line(values):
    """Energy and bound, of values as :func:`quality` has them."""
    if values["certificate"] == "none":
        return f"energy {values['energy']:.6g}, no bound asked"
    saving = "no field saves more than" if values["certificate"] == "proved" else "gap"
    bound = f"lower bound {values['lower_bound']:.6g} ({values['certificate']})"
    return f"energy {values['energy']:.6g}, {bound}: {saving} {values['gap']:.1%}"


def summary(report):
    """The report as some lines of text."""
    name = one_line(report["object"])
    lines = [f"{report['command']} on {name}: {report['nodes']} vertices, {report['edges']} edges"]
    if report["energy"] is not None:
        lines.append(_energy_line(report))
    if report["certificate"] == "none" and (report["directions"] or {}).get("energy") is not None:
        lines.append(f"directions: {_energy_line(report['directions'])}")
    if report["sdp_value"] is not None:
        width = f"the bound is {report['sdp_gap']:.2%} below it"
        lines.append(f"relaxation {report['sdp_value']:.6g}, {width}: {report['status']}")
    disclinations = count_text(len(report["disclinations"]), "disclination")
    if report["closed"]:
        total = sum(d["index"] for d in report["disclinations"])
        disclinations += f" (indices sum to {total:g}, the Euler characteristic is {report['euler_characteristic']})"
    dislocations = count_text(len(report["dislocations"]), "dislocation")
    if report["forced_dislocations"] is not None:
        dislocations += f" (exact directions and spacing ask for {report['forced_dislocations']:.0f})"
    lines.append(f"{disclinations}, {dislocations}")
    if report.get("evenness"):
        lines.append(_even_line(report["evenness"]))
    if "quad_mesh" in report:
        lines.append(_quad_line(report["quad_mesh"]))
    lines.append(f"{report['times']['total']:.2f} s")
    return lines


def _even_line(evenness):
    low, _, _, _, high = evenness["spacing"]
    line = (
        f"98% of the lines {low:.2f} to {high:.2f} times as far apart as asked, {evenness['off_share']:.1%} off by 25%"
    )
    if "angles" not in evenness:
        return line
    low, _, _, _, high = evenness["angles"]
    return f"{line}; corners {low:.0f} to {high:.0f} degrees"


def _quad_line(made):
    return (
        f"{made['object']}: {made['faces']} faces, {made['quad_share']:.1%} quads, "
        f"{count_text(made['irregular_vertices'], 'irregular vertex')}, corners off a right angle by "
        f"{made['angle_deviation']:.1f} degrees on average, {made['hausdorff_distance']:.2g} from the surface at most; "
        f"{_loops(made)}"
    )


def _loops(made):
    counts = f"{count_text(made['loops'], 'loop')}, {count_text(made['spirals'], 'spiral')}"
    line = f"{counts}, the longest of {made['longest_loop']} quads, {made['short_loop_share']:.0%} in short ones"
    before = made.get("loops_before")
    return line if before is None else f"{line} ({before['short_loop_share']:.0%} before more of them were closed)"


def count_defects(report):
    """Defects in the words of the panel: "2 swirl points, 3 line ends"."""
    kinds = ("disclinations", "swirl point"), ("dislocations", "line end")
    return ", ".join(count_text(len(report[kind]), word) for kind, word in kinds)


def count_text(count, noun):
    """ "1 dislocation", "2 dislocations", "0 vertices" """
    return f"{count} {noun if count == 1 else plural(noun)}"
