# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The row of a file of any_file.py, made in a process of its own."""

import re
import signal

import bpy
import numpy as np

from synch_fields.bench.measure import peak_megabytes, spent
from synch_fields.core.errors import SynchError
from synch_fields.core.extract.quads.trace.quad_mesh import SHORTEST
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import attributes, files
from synch_fields.synch_addon.blender.quiet import quiet_stdout


def file_row(path, faces, limit):
    """The row of a file, as a dict of plain values."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_PROF, limit)
    row = {}
    for make in (_quad_figures, _stripe_figures):
        try:
            with quiet_stdout():
                row |= make(_largest(path), faces)
        except SynchError as error:
            row["fails"] = str(error)
    return row | {"megabytes": peak_megabytes()}


def _largest(path):
    """The object of a file with the most faces."""
    files.open_input(path)
    found = [obj for obj in bpy.context.scene.objects if obj.type == "MESH" and len(obj.data.polygons)]
    if not found:
        raise SynchError(f"{path.name}: there is no mesh with faces")
    return max(found, key=lambda obj: len(obj.data.polygons))


def _quad_figures(obj, faces):
    given = len(obj.data.vertices)
    report, seconds = spent(lambda: api.quad_mesh(obj, faces=faces))
    figures, surface = report["quad_mesh"], report.get("surface") or {}
    made = bpy.data.objects[figures["object"]]
    ends = attributes.read_all(made.data.edges, "vertices", 2)
    places = attributes.read_values(made, "position", "POINT") @ np.array(made.matrix_world.to_3x3()).T
    lengths = np.linalg.norm(places[ends[:, 0]] - places[ends[:, 1]], axis=1)
    told = [re.search(r"([\d.e+-]+) of ([\d.e+-]+) in length", line) for line in report["warnings"]]
    # Crowded edges that are left out are told apart, with the length of all.
    lost, whole = np.array([[float(part) for part in found.groups()] for found in told if found] or [[0, 1]]).T
    kept = ("faces", "irregular_vertices", "angle_deviation", "folds")
    return {name: figures[name] for name in kept} | {
        "given": given,
        "joined": surface.get("joined", 0),
        "vertices": surface.get("vertices", given),
        "zero": int((lengths < SHORTEST * np.median(lengths)).sum()),
        "lost": float(lost.sum() / whole.max()),
        "away": figures["hausdorff_distance"] / figures["edge_length"],
        "closed_too": "no" if any("closed and the quad mesh is not" in line for line in report["warnings"]) else "yes",
        "warnings": len(report["warnings"]),
        "said": report["warnings"],
        "quad_seconds": seconds,
    }


def _stripe_figures(obj, _):
    report, seconds = spent(lambda: api.stripes(obj))
    return {
        "dislocations": len(report["dislocations"]),
        "stripe_warnings": len(report["warnings"]),
        "stripe_said": report["warnings"],
        "stripe_seconds": seconds,
    }
