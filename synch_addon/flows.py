# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows as the core's grids: from OpenVDB files, volume objects, arrays, and curves that stand for filaments."""

import importlib.util
import sys
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from scipy.ndimage import map_coordinates

from ..core.errors import SettingError
from ..core.fields.biot_savart import filament_integrals
from ..core.fields.clebsch import edge_integrals
from ..core.geometry.grid import Grid
from .strokes import SOURCE_TYPES, polylines

SUFFIXES = (".vdb", ".npz")
# Custom property of a curve object: the circulation around it.
STRENGTH = "synch_strength"
# Space around curves, as a share of their longest side, and the radius of their cores in cells.
_MARGIN, _CORE = 0.35, 0.5


@dataclass(frozen=True)
class Flow:
    """A velocity as the core wants it.

    Attributes
    ----------
    grid : Grid, in the world
    integrals : (e,) of the velocity along its edges
    name : of what it was read from
    """

    grid: Grid
    integrals: np.ndarray
    name: str


def read_flow(source, resolution):
    """The :class:`Flow` of a path, of a volume object, or of curve objects.

    Parameters
    ----------
    source : path of a .vdb or .npz file, a volume object, or a list of curve objects
    resolution : nodes along the longest side that a file or curves are resampled to

    Raises
    ------
    SettingError
        with one line that says what is wrong with the source
    """
    if resolution < 8:
        raise SettingError(f"a resolution of {resolution} nodes shows no vortex: give 8 or more")
    if isinstance(source, str | Path):
        return _read_file(Path(source), resolution)
    if isinstance(source, bpy.types.Object) and source.type == "VOLUME":
        path = bpy.path.abspath(source.data.filepath, library=source.data.library)
        if not path:
            raise SettingError(f"the volume {source.name} has no file: save it as .vdb and choose that")
        return _read_vdb(Path(path), resolution, np.array(source.matrix_world), source.name)
    curves = [source] if isinstance(source, bpy.types.Object) else list(source)
    return _around_curves(curves, resolution)


def _read_file(path, resolution):
    if path.suffix.lower() not in SUFFIXES:
        raise SettingError(f"{path}: flows are read from {' and '.join(SUFFIXES)} files")
    if not path.is_file():
        raise SettingError(f"{path}: no such file")
    if path.suffix.lower() == ".vdb":
        return _read_vdb(path, resolution, np.eye(4), path.name)
    return _read_arrays(path)


def _read_arrays(path):
    """A .npz file with velocity (nx, ny, nz, 3) or (nx, ny, 2), and optional spacing, origin and periodic."""
    try:
        with np.load(path, allow_pickle=False) as arrays:
            found = {name: arrays[name] for name in arrays.files}
    except (ValueError, OSError) as error:
        raise SettingError(f"{path}: {error}: write it with numpy.savez") from None
    if "velocity" not in found:
        have = ", ".join(found) or "nothing"
        raise SettingError(f"{path}: has no array 'velocity' (it has {have}): save the flow under that name")
    velocity = found["velocity"]
    if velocity.ndim not in (3, 4) or velocity.shape[-1] != velocity.ndim - 1:
        raise SettingError(f"{path}: velocity has the shape {velocity.shape}: use (nx, ny, nz, 3) or (nx, ny, 2)")
    more = {name: found[name] for name in ("spacing", "origin", "periodic") if name in found}
    grid = Grid(velocity.shape[:-1], **more)
    return Flow(grid, edge_integrals(grid, velocity.reshape(-1, velocity.shape[-1])), path.name)


def _read_vdb(path, resolution, matrix, name):
    """The first vector grid of a file, sampled on a grid along the world's axes."""
    vdb = _openvdb()
    try:
        grids = vdb.readAllGridMetadata(str(path))
        vectors = [grid for grid in grids if grid.valueTypeName.startswith("vec3")]
        found = vdb.read(str(path), vectors[0].name) if vectors else None
    except (OSError, KeyError, RuntimeError) as error:
        raise SettingError(f"{path}: {error}: choose an OpenVDB file") from None
    if found is None:
        have = ", ".join(f"{grid.name} ({grid.valueTypeName})" for grid in grids) or "none"
        raise SettingError(f"{path}: has no grid of vectors (it has {have}): export the velocity")
    low, high = found.evalActiveVoxelBoundingBox()
    counts = np.array(high) - low + 1
    if found.activeVoxelCount() == 0 or (counts < 2).any():
        raise SettingError(f"{path}: the grid {found.name} is empty: export a frame that has a flow")
    values = np.empty((*counts, 3), np.float32)
    found.copyToArray(values, ijk=low)
    if not np.isfinite(values).all():
        raise SettingError(f"{path}: the grid {found.name} has voxels that are not numbers: mend the simulation")
    to_world = matrix @ _index_to_world(found)
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, -1)
    world = to_world[:3, :3] @ corners + to_world[:3, 3:]
    grid = _box_grid(world.min(axis=1), world.max(axis=1), resolution)
    inverse = np.linalg.inv(to_world)
    places = inverse[:3, :3] @ grid.places.T + inverse[:3, 3:] - np.array(low)[:, None]
    sampled = [map_coordinates(values[..., k], places, order=1, mode="nearest") for k in range(3)]
    velocity = np.stack(sampled, axis=1) @ matrix[:3, :3].T
    return Flow(grid, edge_integrals(grid, velocity), name)


def _index_to_world(grid):
    """(4, 4) matrix of a grid's linear transform."""
    origin = np.array(grid.transform.indexToWorld((0, 0, 0)))
    matrix = np.eye(4)
    for axis in range(3):
        matrix[:3, axis] = np.array(grid.transform.indexToWorld(tuple(np.eye(3)[axis]))) - origin
    matrix[:3, 3] = origin
    return matrix


def _openvdb():
    """Blender's own OpenVDB module, which the bpy wheel keeps beside its scripts."""
    try:
        import openvdb
    except ImportError:
        folder = Path(bpy.utils.resource_path("LOCAL")) / "python" / "lib"
        name = f"python{sys.version_info.major}.{sys.version_info.minor}/site-packages"
        for found in sorted((folder / name).glob("*openvdb*.so")) + sorted((folder / name).glob("*openvdb*.pyd")):
            module_name = found.name.split(".")[0]
            spec = importlib.util.spec_from_file_location(module_name, found)
            openvdb = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(openvdb)
            return openvdb
        raise SettingError("this Blender has no OpenVDB module: give the flow as a .npz file") from None
    return openvdb


def _around_curves(objects, resolution):
    """The flow that curve objects induce as vortex filaments, in a box around them."""
    curves = []
    for obj in objects:
        if obj.type not in SOURCE_TYPES:
            raise SettingError(f"{obj.name} is no curve: choose curves, a volume, or a .vdb or .npz file")
        strength = float(obj.get(STRENGTH, 1.0))
        matrix = np.array(obj.matrix_world)
        curves += [(line @ matrix[:3, :3].T + matrix[:3, 3], strength) for line in polylines(obj)]
    if not curves:
        raise SettingError("there is no curve with two points: draw the vortex filaments")
    points = np.concatenate([points for points, _ in curves])
    margin = _MARGIN * np.ptp(points, axis=0).max()
    grid = _box_grid(points.min(axis=0) - margin, points.max(axis=0) + margin, resolution)
    return Flow(grid, filament_integrals(grid, curves, _CORE * grid.spacing[0]), objects[0].name)


def _box_grid(low, high, resolution):
    """A grid of cubes over a box, with so many nodes along its longest side."""
    size = np.maximum(high - low, 1e-9)
    spacing = size.max() / (resolution - 1)
    counts = np.maximum(np.round(size / spacing).astype(int) + 1, 4)
    origin = (low + high) / 2 - spacing * (counts - 1) / 2
    return Grid(counts, spacing, origin)
