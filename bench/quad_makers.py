# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways from a mesh's file to a quad mesh and its figures: ours, Blender's QuadriFlow, and any command.

Each is a function that a process of its own can run, and gives a row. A row without ``faces`` says in ``fails`` why.
"""

import shlex
import signal
import subprocess
import tempfile
from pathlib import Path

import bpy
import numpy as np

from synch_fields.bench.measure import spent, timed
from synch_fields.bench.meshes import read_faces, write_obj
from synch_fields.bench.quad_measures import figures, longest_side, quad_mesh_of
from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import attributes, files, meshes
from synch_fields.synch_addon.blender.quiet import quiet_stdout

# Periods along the longest side at most, and median edges in one at least; a period is two quads long.
PERIODS, EDGES_PER_PERIOD = 25, 4
# Who is asked for a number of faces and misses it by more than this share is asked again, this often at most, for as
# many more or fewer.
MISS, AGAIN = 0.03, 3


def our_row(path, limit, field=None, settings=(), kept=None):
    """The row of our quad mesh of a file.

    Parameters
    ----------
    path : of an .obj file
    limit : seconds after which the process is ended
    field : a field file to follow, in place of smooth directions
    settings : (name, value) pairs for :func:`api.quad_mesh`; a "{faces}" among the values becomes the number of faces
        that the spacing asks for
    kept : folder where the mesh goes as an .obj file, or None
    """
    _end_after(limit)
    with quiet_stdout():
        obj = _opened(path)
        try:
            given = meshes.read_mesh(obj).mesh
            spacing = max(longest_side(given) / PERIODS, EDGES_PER_PERIOD * float(np.median(given.edge_lengths)))
            asked = round(given.areas.sum() / (spacing / 2) ** 2)
            chosen = {name: asked if value == "{faces}" else value for name, value in settings}
            if field:
                api.import_field(obj, field)
                chosen["guidance"] = "attribute:synch_direction"
            report, seconds = spent(lambda: api.quad_mesh(obj, spacing=spacing, **chosen))
        except SynchError as error:
            return {"fails": str(error)}
        made = bpy.data.objects[report["quad_mesh"]["object"]]
        quads = _faces_of(made)
        row = figures(quads, given)
        if kept:
            _write_quads(quads, kept)
    counts = {name: len(report[name]) for name in ("disclinations", "dislocations")}
    return row | counts | {"asked": asked, "spacing": spacing, "seconds": seconds, "energy": report["energy"]}


def quadriflow_row(path, limit, faces, options=(), kept=None):
    """The row of QuadriFlow's mesh of a file, with about as many faces as asked for.

    ``options`` are (name, value) pairs for its operator; the rest as :func:`our_row`.
    """
    _end_after(limit)

    def attempt(asked):
        obj = _opened(path)
        try:
            operator = bpy.ops.object.quadriflow_remesh
            done, seconds = spent(lambda: operator(target_faces=asked, seed=0, **dict(options)))
        except RuntimeError as error:
            return {"fails": " ".join(str(error).split())}
        return {"quads": _faces_of(obj), "seconds": seconds} if done == {"FINISHED"} else {"fails": "is not finished"}

    with quiet_stdout():
        return _finished(_nearest_attempt(attempt, faces), meshes.read_mesh(_opened(path)).mesh, faces, kept)


def command_row(path, limit, faces, command, kept=None):
    """The row of the mesh that a command makes of a file; in it stand {input}, {output} and {faces}."""
    with quiet_stdout():
        given = meshes.read_mesh(_opened(path)).mesh

    def attempt(asked):
        with tempfile.TemporaryDirectory() as folder:
            source, target = Path(folder) / "input.obj", Path(folder) / "output.obj"
            write_obj(given, source)
            words = [word.format(input=source, output=target, faces=asked) for word in shlex.split(command)]
            try:
                done, seconds = timed(lambda: subprocess.run(words, capture_output=True, timeout=limit, check=False))
            except subprocess.TimeoutExpired:
                return {"fails": f"no result in {limit} s"}
            if done.returncode or not target.exists():
                return {"fails": f"exit status {done.returncode}"}
            vertices, faces = read_faces(target)
        if not faces:
            return {"fails": "a mesh without faces"}
        quads = quad_mesh_of(vertices, np.concatenate(faces), [len(corners) for corners in faces])
        return {"quads": quads, "seconds": seconds}

    return _finished(_nearest_attempt(attempt, faces), given, faces, kept)


def _nearest_attempt(attempt, faces):
    """Of attempts with corrected numbers, the one that came nearest to a number of faces."""
    asked, best = faces, None
    for _ in range(AGAIN):
        made = attempt(asked)
        if "fails" in made:
            return best or made
        reached = len(made["quads"].sizes)
        if best is None or abs(reached - faces) < abs(len(best["quads"].sizes) - faces):
            best = made
        if abs(reached - faces) <= MISS * faces:
            break
        asked = max(round(asked * faces / reached), 1)
    return best


def _finished(made, given, faces, kept):
    """The row of an attempt that was the last one."""
    if "fails" in made:
        return {"fails": made["fails"], "asked": faces}
    if kept:
        _write_quads(made["quads"], kept)
    return figures(made["quads"], given) | {"asked": faces, "seconds": made["seconds"]}


def _write_quads(quads, path):
    """An .obj file of faces, whose axes are those of the file they come from."""
    lines = ["v {:.9g} {:.9g} {:.9g}".format(*place) for place in quads.vertices]
    lines += ["f " + " ".join(map(str, corners + 1)) for corners in np.split(quads.corner_vertices, quads.starts[1:])]
    Path(path).write_text("\n".join(lines) + "\n")


def _opened(path):
    obj = files.open_object(path)
    obj.select_set(True)
    return obj


def _faces_of(obj):
    """The :class:`QuadMesh` of an object's own mesh."""
    polygons = meshes.read_polygons(obj)
    return quad_mesh_of(attributes.read_values(obj, "position", "POINT"), polygons.corner_vertices, polygons.sizes)


def _end_after(seconds):
    """Let the system end this process, which may be in foreign code for good, where it can."""
    if hasattr(signal, "alarm"):
        signal.alarm(seconds)
