# SPDX-License-Identifier: GPL-3.0-or-later
"""What is made of layers to print: a mesh file for each layer, and paths for a tool as curves and as a file."""

import math
import re
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ...core.errors import SettingError
from ...core.extract.toolpaths import rim_distances, toolpaths
from ...core.keywords import check_choice
from ..blender.files import MESH_SUFFIXES, check_output, export_mesh, unwritten
from ..blender.transaction import only_for_now
from ..patterns.lines import add_splines
from .links import SOLID

FILLS = ("contour", "across-x", "across-y", "across-z")
PATH_SUFFIXES = (".csv", ".obj")
# Custom property of the collection of paths: the curve object of each layer.
_CURVES = "synch_path_objects"
# Points of a path closer than this are one, in steps.
_SAME = 1e-4


@dataclass(frozen=True)
class PathSettings:
    """Which paths a tool follows on each layer.

    Attributes
    ----------
    step : distance between two, in scene units; None for the mean spacing of the layers
    fill : "contour", one inside the other from the rim inwards, the first half a step from it; or in planes across
        an axis of the object, a step apart, "across-x" ...
    """

    step: float | None = None
    fill: str = "contour"

    def __post_init__(self):
        check_choice(self, "fill", FILLS)
        if self.step is not None and not (isinstance(self.step, int | float) and 0 < self.step < math.inf):
            raise SettingError(f"the step between paths is {self.step!r}: give a positive number")


@dataclass(frozen=True)
class Paths:
    """Lines over the triangles of the layers, the layer of each, and the step between them."""

    lines: object
    layers: np.ndarray
    step: float


def export_layers(layering, path, together=False):
    """Write each layer to a mesh file of its own, numbered upwards, or all into one; returns the paths.

    Parameters
    ----------
    layering : Layering
    path : of one file; without ``together``, part.stl stands for part_000.stl, part_001.stl ...
    together : bool
    """
    path = Path(path)
    check_output(path, MESH_SUFFIXES)
    surfaces = layering.surfaces
    digits = max(3, len(str(surfaces.count - 1)))
    written = []
    selected, active = bpy.context.selected_objects, bpy.context.view_layer.objects.active
    try:
        for number in [None] if together else range(surfaces.count):
            chosen = slice(None) if number is None else surfaces.layers == number
            target = path if number is None else path.with_stem(f"{path.stem}_{number:0{digits}d}")
            with only_for_now():
                export_mesh(_sheet(layering, surfaces.triangles[chosen]), target, z_up=True)
            written.append(str(target))
    finally:
        for obj in bpy.context.view_layer.objects:
            obj.select_set(obj in selected)
        bpy.context.view_layer.objects.active = active
    return written


def left_behind(path, written):
    """Names of layer files that an earlier run has left beside those that were written, which they seem to continue."""
    path, names = Path(path), {Path(file).name for file in written}
    pattern = re.compile(rf"{re.escape(path.stem)}_\d{{3,}}{re.escape(path.suffix)}")
    return sorted(
        found.name for found in path.parent.iterdir() if pattern.fullmatch(found.name) and found.name not in names
    )


def _sheet(layering, triangles):
    """An object of some triangles of the layers."""
    used, corners = np.unique(triangles, return_inverse=True)
    data = bpy.data.meshes.new("Layer")
    data.from_pydata(layering.surfaces.vertices[used].tolist(), [], corners.reshape(-1, 3).tolist())
    obj = bpy.data.objects.new("Layer", data)
    obj.matrix_world = Matrix(layering.matrix)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return obj


def paths_of(layering, settings):
    """:class:`Paths` on the layers.

    Raises
    ------
    SettingError
        where the step is wider than every layer
    """
    surfaces = layering.surfaces
    step = settings.step
    if step is None:
        step = layering.pattern.spacings.mean
    if settings.fill == "contour":
        values = rim_distances(surfaces) - step / 2
    else:
        values = surfaces.vertices[:, "xyz".index(settings.fill[-1])]
    lines, layers = toolpaths(surfaces, values, step)
    if len(lines.sizes) == 0:
        raise SettingError(f"no path of the step {step:g} fits on a layer: reduce it")
    return Paths(lines, layers, float(step))


def write_paths(obj, layering, paths):
    """A curve object for each layer, numbered upwards, in a collection of their own; returns the collection.

    An earlier run's curves are replaced.
    """
    collection = _collection(obj)
    shown, curves = paths.lines.without_repeats(_SAME * paths.step), {}
    digits = max(3, len(str(layering.surfaces.count - 1)))
    for number in np.unique(paths.layers):
        data = bpy.data.curves.new(f"{obj.name} Paths {number:0{digits}d}", "CURVE")
        data.dimensions, data.twist_mode = "3D", "Z_UP"
        add_splines(data, shown.chosen(paths.layers == number), "poly")
        made = bpy.data.objects.new(data.name, data)
        made[SOLID], made["synch_layer"] = obj, int(number)
        made.matrix_world = Matrix(layering.matrix)
        collection.objects.link(made)
        curves[str(number)] = made
    collection[_CURVES] = curves
    return collection


def _collection(obj):
    """The collection of an object's paths in the scene, without an earlier run's; copies by the user stay."""
    collection = next((found for found in bpy.data.collections if found.get(SOLID) == obj), None)
    if collection is None:
        collection = bpy.data.collections.new(f"{obj.name} Paths")
        collection[SOLID] = obj
    earlier = [made for made in collection.get(_CURVES, {}).values() if made is not None]
    curves = {made.data for made in earlier}
    bpy.data.batch_remove(earlier)
    bpy.data.batch_remove([data for data in curves if not data.users])
    if collection not in bpy.context.scene.collection.children_recursive:
        (obj.users_collection or (bpy.context.scene.collection,))[0].children.link(collection)
    return collection


def export_paths(layering, paths, path):
    """Write paths to a file, in the world: .csv with one row a point, or .obj with one polyline a path.

    Closed paths come back to their first point. Normals point in the direction in which layers follow one another.
    """
    check_output(path, PATH_SUFFIXES)
    lines = paths.lines.without_repeats(_SAME * paths.step)
    matrix = np.asarray(layering.matrix)
    points = lines.points @ matrix[:3, :3].T + matrix[:3, 3]
    # Turned and mirrored like the layers; there is no scale in the matrix.
    normals = lines.normals @ matrix[:3, :3].T
    writer = _write_table if Path(path).suffix.lower() == ".csv" else _write_polylines
    try:
        Path(path).write_text(writer(lines, paths.layers, points, normals))
    except OSError as error:
        raise unwritten(path, error.strerror) from None
    return str(path)


def _runs(lines):
    """Points of each line, the first one again where it is closed."""
    for start, size, closed in zip(lines.starts, lines.sizes, lines.closed, strict=True):
        run = np.arange(start, start + size)
        yield np.append(run, start) if closed else run


def _write_table(lines, layers, points, normals):
    rows = ["layer,path,x,y,z,nx,ny,nz"]
    for number, (layer, run) in enumerate(zip(layers, _runs(lines), strict=True)):
        for values in np.hstack([points[run], normals[run]]):
            rows.append(f"{layer},{number}," + ",".join(f"{value:.9g}" for value in values))
    return "\n".join(rows) + "\n"


def _write_polylines(lines, layers, points, normals):
    rows, before = [], None
    rows += ["v " + " ".join(f"{value:.9g}" for value in point) for point in points]
    for layer, run in zip(layers, _runs(lines), strict=True):
        if layer != before:
            rows.append(f"o layer_{layer:03d}")
            before = layer
        rows.append("l " + " ".join(map(str, run + 1)))
    return "\n".join(rows) + "\n"
