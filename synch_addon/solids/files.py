# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers as files for printing: a mesh for each layer, and tool paths as curves and as a file."""

import re
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ...core.files.tool_paths import WRITERS
from ...core.files.whole import write_together, write_whole
from ...core.printing.gcode import gcode
from ..blender.files import MESH_SUFFIXES, check_output, export_mesh
from ..blender.new_geometry import add_spline, new_mesh
from ..blender.transaction import at_the_end, leave, only_for_now, set_aside, store, undone_by
from ..patterns.lines import add_splines
from .beads import add_beads
from .links import SOLID
from .report import program_facts

PROGRAM = ".gcode"
PATH_SUFFIXES = (*WRITERS, PROGRAM)
# Custom property of the collection of paths: the curve object of each layer.
_CURVES = "synch_path_objects"
# What is wrong with paths: the name of its curves, which points of a plan it is, and its colour in the view.
_FLAWS = {"Collisions": ("collided", (0.9, 0.1, 0.1, 1)), "Overhangs": ("overhangs", (0.95, 0.6, 0.1, 1))}


def export_layers(layering, path, together=False):
    """Write each layer of a Layering to a mesh file of its own, numbered upwards, or all together into one; returns the
    paths.

    The path part.stl stands for part_000.stl, part_001.stl ... where they are not together.
    """
    path = Path(path)
    check_output(path, MESH_SUFFIXES)
    surfaces = layering.surfaces
    digits = max(3, len(str(surfaces.count - 1)))
    numbers = [None] if together else range(surfaces.count)
    targets = [path if number is None else path.with_stem(f"{path.stem}_{number:0{digits}d}") for number in numbers]
    selected, active = bpy.context.selected_objects, bpy.context.view_layer.objects.active
    try:
        with write_together() as written:
            for number, target in zip(numbers, targets, strict=True):
                chosen = slice(None) if number is None else surfaces.layers == number
                with only_for_now():
                    export_mesh(_sheet(layering, surfaces.triangles[chosen]), target, z_up=True, written=written)
    finally:
        for obj in bpy.context.view_layer.objects:
            obj.select_set(obj in selected)
        bpy.context.view_layer.objects.active = active
    return [str(target) for target in targets]


def left_behind(path, written):
    """Names of layer files of an earlier run that seem to continue the ones just written."""
    path, names = Path(path), {Path(file).name for file in written}
    pattern = re.compile(rf"{re.escape(path.stem)}_\d{{3,}}{re.escape(path.suffix)}")
    return sorted(
        found.name for found in path.parent.iterdir() if pattern.fullmatch(found.name) and found.name not in names
    )


def _sheet(layering, triangles):
    """An object of some triangles of the layers."""
    used, corners = np.unique(triangles, return_inverse=True)
    obj = bpy.data.objects.new("Layer", new_mesh("Layer", layering.surfaces.vertices[used], corners.reshape(-1, 3)))
    obj.matrix_world = Matrix(layering.matrix)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return obj


def write_paths(obj, layering, paths, beads=None):
    """A curve object for each layer, numbered upwards, in a collection of their own, and tubes around the places where
    the tool meets what is printed or prints on air; with one of :data:`beads.LOOKS` the beads, too, in its
    colours. Returns the collection.

    An earlier run's curves are replaced.
    """
    digits = max(3, len(str(layering.surfaces.count - 1)))
    curves = {int(number): _curve(paths, number) for number in np.unique(paths.layers)}
    collection, objects = _collection(obj), {}
    for number, data in curves.items():
        data.name = f"{obj.name} Paths {number:0{digits}d}"
        made = objects[str(number)] = bpy.data.objects.new(data.name, data)
        made["synch_layer"] = number
    for name, (chosen, colour) in _FLAWS.items():
        runs = paths.runs_of(getattr(paths, chosen))
        if runs:
            data = _flaws(paths, runs)
            data.name = f"{obj.name} {name}"
            made = objects[chosen] = bpy.data.objects.new(data.name, data)
            made.color = colour
    if beads is not None:
        objects["beads"], tubes = add_beads(paths, beads, f"{obj.name} Beads")
    for made in objects.values():
        made[SOLID] = obj
        made.matrix_world = Matrix(layering.matrix)
        collection.objects.link(made)
    store(collection, _CURVES, objects if beads is None else objects | {"tubes": tubes})
    return collection


def _curve(paths, number):
    data = bpy.data.curves.new("Paths", "CURVE")
    data.dimensions, data.twist_mode = "3D", "Z_UP"
    add_splines(data, paths.lines.chosen(paths.layers == number), "poly")
    return data


def _flaws(paths, runs):
    """Tubes of half a step around pieces of paths; a single point gets the way to the next one."""
    data = bpy.data.curves.new("Flaws", "CURVE")
    data.dimensions, data.bevel_depth = "3D", paths.step / 4
    points, following = paths.lines.points, paths.lines.next
    for run in runs:
        run = run if len(run) > 1 else np.append(run, following[run])
        add_spline(data, points[run])
    return data


def beads_of(obj):
    """The object of beads that was made last of an object's layers and is in a scene, or None."""
    collection = _find_collection(obj)
    made = collection[_CURVES].get("beads") if collection and _CURVES in collection else None
    return made if made and made.users_collection else None


def _find_collection(obj):
    return next((found for found in bpy.data.collections if found.get(SOLID) == obj), None)


def _collection(obj):
    """The collection of an object's paths in the scene, without an earlier run's; copies by the user stay."""
    collection = _find_collection(obj)
    if collection is None:
        collection = bpy.data.collections.new(f"{obj.name} Paths")
        collection[SOLID] = obj
    kept = collection.get(_CURVES, {})
    blocks = getattr(kept, "values", list)()
    # Tubes that a copy of the beads shows stay: their other users are this property and the modifier of the beads.
    tubes = [made for made in blocks if isinstance(made, bpy.types.Collection) and made.users <= 2]
    earlier = [made for made in blocks if isinstance(made, bpy.types.Object)]
    earlier += [tube for made in tubes for tube in made.objects]
    leave(tubes)
    curves = {made.data for made in earlier}
    for data in curves:
        if data.users == sum(made.data == data for made in earlier):
            set_aside(data)
    leave(earlier)
    at_the_end(lambda: bpy.data.batch_remove([data for data in curves if not data.users]))
    if collection not in bpy.context.scene.collection.children_recursive:
        around = (obj.users_collection or (bpy.context.scene.collection,))[0]
        undone_by(collection, lambda: collection in around.children.values() and around.children.unlink(collection))
        around.children.link(collection)
    return collection


@contextmanager
def paths_file(paths, path):
    """Write paths to a file, in the world, which takes its place at the end: .csv with one row a point, or .obj with
    one polyline a path, or .gcode for the plan's machine. Yields the report's `files`.

    Closed paths come back to their first point. Normals point in the direction in which layers follow one another.
    """
    suffix, facts = Path(path).suffix.lower(), {"files": [str(path)]}
    if suffix == PROGRAM:
        program = gcode(paths.course, paths.machine)
        text, facts["program"] = program.text, program_facts(program)
    else:
        text = WRITERS[suffix](
            paths.lines, paths.layers, paths.places, paths.normals, paths.heights, paths.widths, paths.up
        )
    with write_whole(path) as made:
        made.write_text(text, encoding="utf-8")
        yield facts
