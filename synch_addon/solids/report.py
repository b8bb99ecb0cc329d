# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of layers in a solid, and the lines that a person wants to read of it."""

import numpy as np

from ..jobs.report import counted


def layer_facts(layering):
    """What a run found in the solid, ready for JSON."""
    pattern, surfaces = layering.pattern, layering.surfaces
    spacings = pattern.spacings
    return {
        "tetrahedra": layering.solid.tet_count,
        "volume": float(layering.solid.volumes.sum()),
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
