# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of layers in a solid, and the lines that a person wants to read of it."""

import numpy as np

from ...core.memory import peak_megabytes
from ..jobs.report import counted, quality, versions


def layer_facts(layering):
    """What a run found in the solid, ready for JSON."""
    pattern, surfaces = layering.pattern, layering.surfaces
    spacings = pattern.spacings
    return {
        "tetrahedra": layering.solid.tet_count,
        "volume": float(layering.solid.volumes.sum()),
        **quality(pattern.solution),
        "layers": surfaces.count,
        "layer_faces": len(surfaces.triangles),
        "layer_areas": surfaces.areas.tolist(),
        "spacings": {
            name: getattr(spacings, name) for name in ("mean", "deviation", "thinnest", "thickest", "counted")
        },
        "punctured_tetrahedra": int(pattern.tet_phases.punctured.sum()),
        "dislocation_curves": [
            {"index": curve.index, "closed": curve.is_closed, "length": _length(curve), "tetrahedra": len(curve.tets)}
            for curve in layering.curves
        ],
    }


def layer_report(layering, obj, made, settings, clock, warnings):
    """The report as a dict of plain values.

    Parameters
    ----------
    layering : Layering
    obj : bpy.types.Object whose solid it is
    made : dict with the names of the objects that show it
    settings : dict
    clock : Clock with the seconds of each part
    warnings : list of lines
    """
    solution = layering.pattern.solution
    times = dict(clock.seconds)
    for part, seconds in solution.times.items():
        times[part] = times.get(part, 0.0) + seconds
    return {
        "status": solution.status.value,
        "command": "layers",
        "object": obj.name,
        **made,
        "nodes": layering.solid.vertex_count - len(layering.solid.loose_vertices),
        "edges": len(layering.solid.edges),
        **layer_facts(layering),
        "times": times,
        "peak_memory_mb": peak_megabytes(),
        "seed": settings["seed"],
        "settings": settings,
        "warnings": warnings,
        "versions": versions(),
    }


def _length(curve):
    points = np.vstack([curve.points, curve.points[:1]]) if curve.is_closed else curve.points
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def headline(report):
    """What the status bar says after a run."""
    curves = counted(len(report["dislocation_curves"]), "dislocation curve")
    return f"{counted(report['layers'], 'layer')}, {_spread(report['spacings'])}, {curves}"


def _spread(spacings):
    if not spacings["counted"]:
        return "nowhere two in a row"
    return (
        f"{spacings['mean']:.4g} apart on average, off by {spacings['deviation'] / spacings['mean']:.1%}, "
        f"98% within {spacings['thinnest']:.4g} to {spacings['thickest']:.4g}"
    )


def summary(report):
    """The lines that a person wants to read."""
    lines = [
        f"layers in {report['object']}: {report['nodes']} vertices, {report['tetrahedra']} tetrahedra",
        f"energy {report['energy']:.6g}, lower bound {report['lower_bound']:.6g} ({report['certificate']}): "
        f"{report['status']}",
        f"{report['layers_object']}: {counted(report['layers'], 'layer')}, {_spread(report['spacings'])}",
    ]
    curves = report["dislocation_curves"]
    closed = sum(curve["closed"] for curve in curves)
    lines.append(f"{counted(len(curves), 'dislocation curve')}, {closed} of them closed")
    lines.append(f"{report['times']['total']:.2f} s")
    return lines
