# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of layers in a solid, and the lines that a person wants to read of it."""

import dataclasses
import math

import numpy as np

from ...core.fields.evenness import quantiles
from ...core.files.json_text import plain
from ...core.geometry.polylines import close_polyline, polyline_length
from ...core.printing.gcode import INNER
from ...core.printing.plan import KINDS
from ..jobs.report import count_text

# Warnings come from this share of the paths' length on, and below this share of the layers' area; largest number of
# places in a report.
TOLD, COVERED, MOST_PLACES = 0.001, 0.99, 20
# Warnings come from this difference of the beads' volume from the solid's on, as a share of it, and outside these
# widths of beads, over the nozzle's opening; and from this share of the paths' length on whose beads are narrower.
VOLUME, WIDTHS, NARROW = 0.02, (0.6, 2.0), 0.05
# A warning says to scale a part that is smaller than this many openings of the nozzle.
SMALL = 10


def layer_facts(layering):
    """Figures of layers in a solid, ready for JSON."""
    pattern, surfaces = layering.pattern, layering.surfaces
    spacings = layering.spacings
    return {
        "tetrahedra": layering.solid.tet_count,
        "volume": float(layering.solid.volumes.sum()),
        "layers": surfaces.count,
        "layer_levels": surfaces.level_count,
        "layer_faces": len(surfaces.triangles),
        "layer_areas": surfaces.areas.tolist(),
        "spacings": plain(
            {name: getattr(spacings, name) for name in ("mean", "deviation", "thinnest", "thickest", "counted")}
        ),
        "punctured_tetrahedra": int(pattern.tet_phases.punctured.sum()),
        "dislocation_curves": [
            {
                "index": curve.index,
                "closed": curve.is_closed,
                "length": polyline_length(close_polyline(curve.points, curve.is_closed)),
                "tetrahedra": len(curve.tets),
            }
            for curve in layering.curves
        ],
    }


def print_facts(plan):
    """Figures and warnings of a :class:`PrintPlan`, ready for JSON; shares are of the length of all paths."""
    machine = plan.machine
    heights, worst = plan.heights * machine.scale, int(plan.covered.argmin())
    thin = plan.is_printed & (heights < machine.smallest_height)
    thick = heights > machine.largest_height
    steep = plan.tilts > machine.largest_tilt
    narrow = plan.is_printed & (plan.widths * machine.scale < WIDTHS[0] * machine.bore)
    facts = {
        "volume": {"solid": plan.volume, "beads": plan.printed_volume, "share": plan.printed_volume / plan.volume},
        "covered": plan.covered_share,
        "least_covered": {"layer": worst, "share": float(plan.covered[worst])},
        "heights": _spread_of(plan.heights, plan.shares),
        "tilts": _spread_of(plan.tilts, plan.shares),
        "too_narrow": float(plan.shares[narrow].sum()),
        "too_thin": float(plan.shares[thin].sum()),
        "too_thick": float(plan.shares[thick].sum()),
        "too_steep": float(plan.shares[steep].sum()),
        "overhangs": _longest_runs(plan, plan.overhangs),
        "collisions": _longest_runs(plan, plan.collided),
        "machine": {name: value for name, value in dataclasses.asdict(machine).items() if value != math.inf},
    }
    has_contours = bool((plan.kinds != KINDS.index(INNER)).any())
    size = float(np.ptp(plan.places, axis=0).max()) * machine.scale
    return facts | {
        "warnings": [*_about_size(size, machine), *_about_print(facts, plan.step * machine.scale, has_contours)]
    }


def program_facts(program):
    """Figures of a :class:`Program`, ready for JSON."""
    return {name: value for name, value in dataclasses.asdict(program).items() if name != "text"}


def _spread_of(values, shares):
    """Median, and the values below and above which 1 % of the length is."""
    low, middle, high = quantiles(values, shares, [0.01, 0.5, 0.99])
    return {"low": float(low), "median": float(middle), "high": float(high)}


def _longest_runs(plan, chosen):
    """Where the chosen beads are, ready for JSON: their share of the length of all paths, the number of unbroken runs,
    and the layer, path, middle and share of each of the longest runs."""
    runs, path_of = plan.runs_of(chosen), plan.lines.numbers
    shares = [float(plan.shares[run].sum()) for run in runs]
    order = np.argsort(-np.array(shares), kind="stable")[:MOST_PLACES]
    places = [
        {
            "layer": int(plan.layers[path_of[runs[k][0]]]),
            "path": int(path_of[runs[k][0]]),
            "place": plan.places[runs[k][len(runs[k]) // 2]].tolist(),
            "share": shares[k],
        }
        for k in order
    ]
    return {"share": float(plan.shares[chosen].sum()), "pieces": len(runs), "places": places}


def _about_size(size, machine):
    if size < SMALL * machine.bore:
        yield (
            f"the part is {size:.2g} mm long, with {machine.scale:g} mm for a scene unit: set scale in a file for "
            "--machine, such as scale = 1000 where a unit is a metre"
        )


def _about_print(facts, step, has_contours):
    machine, share = facts["machine"], facts["volume"]["share"]
    if machine["infill"] == 1 and abs(share - 1) > VOLUME:
        remedy = "reduce the step" if share < 1 else "take fewer or lower layers, or a smaller step"
        yield f"the beads have {share:.1%} of the solid's volume: {remedy}"
    bore = machine["bore"]
    if bore and not WIDTHS[0] * bore <= step <= WIDTHS[1] * bore:
        yield (
            f"beads of {step:.3g} mm do not come from a nozzle of {bore:g} mm: give a step of "
            f"{bore / machine['scale']:.3g}, or another machine"
        )
    elif facts["too_narrow"] > NARROW:
        yield (
            f"{facts['too_narrow']:.0%} of the paths have beads narrower than {WIDTHS[0] * bore:.2g} mm, which do not "
            f"come from a nozzle of {bore:g} mm: take a smaller nozzle, or thicken what is thin"
        )
    if facts["covered"] < COVERED:
        least = facts["least_covered"]
        yield (
            f"the paths cover {facts['covered']:.1%} of the layers, {least['share']:.0%} of layer {least['layer']}: "
            + ("reduce the step" if has_contours else "reduce the step, or take contours")
        )
    largest = machine.get("largest_height", math.inf)
    for kind, words, remedy in (
        (
            "too_thin",
            f"lower than the nozzle's {machine['smallest_height']:g} mm",
            "take a larger spacing, or give the layers a smallest height where they have none",
        ),
        (
            "too_thick",
            f"higher than the nozzle's {largest:g} mm",
            "take a smaller spacing, or give the layers a largest height where they have none",
        ),
        ("too_steep", f"steeper than {machine['largest_tilt']:g} degrees", "turn the object or the guidance"),
    ):
        if facts[kind] >= TOLD:
            yield f"{facts[kind]:.1%} of the paths lie {words}: {remedy}"
    for kind, words, remedy in (
        ("overhangs", "on air", "turn the object, or support it"),
        ("collisions", "where the tool meets what is printed", "take a slimmer nozzle or flatter layers"),
    ):
        if facts[kind]["share"] >= TOLD:
            first = facts[kind]["places"][0]
            place = ", ".join(f"{value:.3g}" for value in first["place"])
            pieces = count_text(facts[kind]["pieces"], "piece")
            yield (
                f"{facts[kind]['share']:.1%} of the paths, {pieces}, lie {words}, the longest at ({place}) on layer "
                f"{first['layer']}: {remedy}"
            )


def print_line(report):
    """Summarize printed paths in one line."""
    heights, tilts, volume, infill = report["heights"], report["tilts"], report["volume"], report["machine"]["infill"]
    filled = f"cover {report['covered']:.1%} of the layers" if infill == 1 else f"{infill:.0%} between walls and skins"
    return (
        f"{count_text(report['paths'], 'path')}, {report['length']:.4g} long in all, {filled}; "
        f"heights {heights['low']:.3g} to {heights['high']:.3g}, tilt up to {tilts['high']:.0f} degrees, "
        f"{report['overhangs']['share']:.1%} on air, {report['collisions']['share']:.1%} in the tool's way; "
        f"{volume['share']:.1%} of the solid's volume"
    )


def program_line(report):
    """Summarize a program in one line."""
    program, five = report["program"], report["machine"]["axes"] != "xyz"
    minutes = round(program["seconds"] / 60)
    section = math.pi * report["machine"]["filament"] ** 2 / 4
    volume = program["filament"] * section / 1000
    # A filament of 1 square millimetre stands for a machine that counts cubic millimetres.
    used = f"{program['filament'] / 1000:.2f} m of filament, " if abs(section - 1) > 1e-4 else ""
    line = f"program: {minutes // 60} h {minutes % 60:02} min, {used}{volume:.3g} cm³"
    if not five:
        return line
    return (
        f"{line}; the tip off its way by {program['deviation']:.3f} mm at most, the tool by {program['tool_off']:.1f} "
        f"degrees, the table turns {program['turn_speed']:.0f} degrees a second at most"
    )


def headline(report):
    """The line of the status bar after a run."""
    curves = count_text(len(report["dislocation_curves"]), "dislocation curve")
    return f"{_count_layers(report)}, {_spread(report['spacings'])}, {curves}"


def _count_layers(report):
    """Layers by their heights, and their connected pieces where these are numbered and more."""
    layers = count_text(report["layer_levels"], "layer")
    pieces = report["layers"]
    return layers if pieces <= report["layer_levels"] else f"{layers} in {count_text(pieces, 'piece')}"


def _spread(spacings):
    if not spacings["counted"]:
        return "nowhere two in a row"
    counted = spacings["counted"]
    return (
        f"{spacings['mean']:.4g} apart on average, off by {spacings['deviation'] / spacings['mean']:.1%}, "
        f"98% within {spacings['thinnest']:.4g} to {spacings['thickest']:.4g}"
        + (f" in {counted:.0%} of the volume: layers end in the rest" if counted < 0.995 else "")
    )


def summary(report):
    """The lines that a person wants to read."""
    lines = [
        f"layers in {report['object']}: {report['nodes']} vertices, {report['tetrahedra']} tetrahedra",
        f"energy {report['energy']:.6g}, lower bound {report['lower_bound']:.6g} ({report['certificate']}): "
        f"{report['status']}",
        f"{report['layers_object']}: {_count_layers(report)}, {_spread(report['spacings'])}",
    ]
    curves = report["dislocation_curves"]
    closed = sum(curve["closed"] for curve in curves)
    lines.append(f"{count_text(len(curves), 'dislocation curve')}, {closed} of them closed")
    lines.append(f"{report['times']['total']:.2f} s")
    return lines
