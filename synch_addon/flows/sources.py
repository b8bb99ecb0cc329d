# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows as the core's grids: from OpenVDB files, volume objects, arrays, and curves that stand for filaments."""

import math
import zlib
from collections.abc import Iterable
from functools import cached_property
from numbers import Integral, Real
from pathlib import Path
from zipfile import BadZipFile, ZipFile

import bpy
import numpy as np
from scipy.ndimage import map_coordinates

from ...core.errors import SettingError
from ...core.fields.biot_savart import filament_integrals
from ...core.fields.clebsch import edge_integrals
from ...core.geometry.grid import Grid
from ..blender.modifiers import is_of_filaments
from ..blender.openvdb import openvdb_module
from ..blender.strokes import SOURCE_TYPES, polylines
from ..blender.volume_files import shown_file
from ..nodes.vortices import STRENGTH

SUFFIXES = (".vdb", ".npz")
# Vector attribute of a mesh, the one that Blender's own liquids have, and names of a volume's.
VELOCITY = "velocity"
_USUAL = (VELOCITY, "vel", "v")
# Volumes so thin, as a share of their width, are flat: their scale is rounded to about as much.
_FLAT = 1e-6
# Space around curves, as a share of their longest side, and the radius of their cores in cells unless one is given.
MARGIN, CORE = 0.35, 0.5
# Bytes that a solve takes for each node with a proved bound, which is tried up to so many nodes, and without; and the
# most nodes, 47 GB.
_PROVED, _PROVED_NODES, _ESTIMATED, _MOST_NODES = 22_000, 36_000, 5_000, 10_000_000


def check_resolution(resolution):
    """Refuse a resolution that nothing can be seen at."""
    if not isinstance(resolution, Integral) or resolution < 8:
        raise SettingError(f"a resolution of {resolution!r} nodes shows no vortex: give a whole number from 8 on")


def solve_memory(nodes):
    """Bytes that a solve takes at its peak, measured on 24^3 to 64^3 nodes."""
    return nodes * (_PROVED if nodes <= _PROVED_NODES else _ESTIMATED)


def check_grid(grid, name):
    """Refuse the grid of a source if it lies in a plane, or if no usual machine can hold a solve of it."""
    if grid.dimension != 3:
        raise SettingError(f"{name}: a flow in a plane has no filaments to show: give one in space")
    if grid.node_count > _MOST_NODES:
        shape, needed = " x ".join(map(str, grid.shape)), solve_memory(grid.node_count) / 2**30
        raise SettingError(
            f"the grid has {shape} nodes, which take about {needed:.0f} GB: give a lower resolution, or a smaller file"
        )


def flow_source(source, core=CORE, attribute=VELOCITY):
    """What a flow is read from, a :class:`VolumeFile`, :class:`ArrayFile` or :class:`FilamentCurves`.

    The vorticity of curves is spread over a radius of ``core`` cells; of a volume ``attribute`` is the grid's name, as
    in :func:`vector_grid`.
    All that Blender's data is needed for is read here; the grid and the integrals may be asked for in another thread.
    """
    if isinstance(source, str | Path):
        return _file(Path(source), attribute)
    if isinstance(source, bpy.types.Object) and source.type == "VOLUME":
        return VolumeFile(shown_file(source), np.array(source.matrix_world), source.name, attribute)
    return FilamentCurves(objects_of(source), core)


def objects_of(source):
    """The objects that a source other than a file is: one, or several.

    Raises
    ------
    SettingError
        for anything else
    """
    objects = [source] if isinstance(source, bpy.types.Object) else source
    objects = list(objects) if isinstance(objects, Iterable) else []
    if not objects or not all(isinstance(obj, bpy.types.Object) for obj in objects):
        raise SettingError(f"{source!r} is no flow: give a file, a volume, a mesh, or curves that stand for filaments")
    return objects


def _file(path, attribute):
    if path.suffix.lower() not in SUFFIXES:
        raise SettingError(f"{path}: flows are read from {' and '.join(SUFFIXES)} files")
    if not path.is_file():
        raise SettingError(f"{path}: no such file")
    return VolumeFile(path, np.eye(4), path.name, attribute) if path.suffix.lower() == ".vdb" else ArrayFile(path)


# Arrays that say where a file's nodes are: their names, kinds of values, and what those are.
_PLACES = {
    "spacing": ("fiu", "one positive number"),
    "origin": ("fiu", "one number"),
    "periodic": ("biu", "one true or false"),
}


class ArrayFile:
    """A .npz file with velocity (nx, ny, nz, 3) or (nx, ny, 2), and optional spacing, origin and periodic."""

    warnings = ()

    def __init__(self, path):
        self.path, self.name = path, path.name

    @property
    def is_plane(self):
        """Whether the velocity has the shape of one in a plane, as its header says; False where that cannot be read."""
        try:
            with ZipFile(self.path) as archive, archive.open("velocity.npy") as file:
                version = np.lib.format.read_magic(file)
                read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
                shape, _, _ = read(file)
        except (ValueError, OSError, EOFError, KeyError, BadZipFile, zlib.error):
            return False
        return len(shape) == 3

    @cached_property
    def _arrays(self):
        path = self.path
        try:
            found = _read_arrays(path)
        except (ValueError, OSError, EOFError, MemoryError, BadZipFile, zlib.error) as error:
            raise SettingError(f"{path}: {error}: write it with numpy.savez") from None
        if "velocity" not in found:
            have = ", ".join(found) or "nothing"
            raise SettingError(f"{path}: has no array 'velocity' (it has {have}): save the flow under that name")
        velocity = found["velocity"]
        if velocity.ndim not in (3, 4) or velocity.shape[-1] != velocity.ndim - 1:
            raise SettingError(f"{path}: velocity has the shape {velocity.shape}: use (nx, ny, nz, 3) or (nx, ny, 2)")
        if velocity.dtype.kind not in "fiu":
            raise SettingError(f"{path}: velocity holds {velocity.dtype} values: save it as floating-point numbers")
        for name in _PLACES.keys() & found.keys():
            (kinds, wanted), given, axes = _PLACES[name], found[name], velocity.ndim - 1
            if given.dtype.kind not in kinds or given.shape not in ((), (1,), (axes,)) or not np.isfinite(given).all():
                has = given.tolist() if given.size < 4 else f"of the shape {given.shape}"
                raise SettingError(f"{path}: {name} is {has!r}: give {wanted}, or {axes} of them")
        return found

    def grid(self, _resolution):
        """The file's own grid."""
        more = {name: self._arrays[name] for name in ("spacing", "origin", "periodic") if name in self._arrays}
        return Grid(self._arrays["velocity"].shape[:-1], **more)

    def integrals(self, grid):
        """(e,) of the velocity along the grid's edges."""
        return edge_integrals(grid, self.velocity)

    @property
    def velocity(self):
        """(n, 3) or (n, 2) at the nodes."""
        velocity = self._arrays["velocity"]
        return velocity.reshape(-1, velocity.shape[-1])


def _read_arrays(path):
    arrays = np.load(path, allow_pickle=False)
    if not isinstance(arrays, np.lib.npyio.NpzFile):
        raise ValueError("a single array without a name")
    with arrays:
        return {name: arrays[name] for name in arrays.files}


class VolumeFile:
    """A grid of vectors of a .vdb file, under a 4 x 4 matrix; ``warnings`` are known once it is read."""

    warnings = ()

    def __init__(self, path, matrix, name, attribute):
        self.path, self.name, self._matrix, self._attribute = path, name, matrix, attribute

    @cached_property
    def _vectors(self):
        """(nx, ny, nz, 3) values, the index of the first one, and the (4, 4) matrix that takes indices to the world."""
        path, vdb = self.path, openvdb_module()
        if not path.is_file():
            raise SettingError(f"{path}: no such file")
        try:
            grids = vdb.readAllGridMetadata(str(path))
            chosen, self.warnings = vector_grid(path, grids, self._attribute)
            found = vdb.read(str(path), chosen.name)
        except (OSError, KeyError, RuntimeError) as error:
            raise SettingError(f"{path}: {error}: choose an OpenVDB file") from None
        low, high = found.evalActiveVoxelBoundingBox()
        counts = np.array(high) - low + 1
        if found.activeVoxelCount() == 0 or (counts < 2).any():
            raise SettingError(f"{path}: the grid {found.name} is empty: export a frame that has a flow")
        values = np.empty((*counts, 3), np.float32)
        found.copyToArray(values, ijk=low)
        if not np.isfinite(values).all():
            raise SettingError(f"{path}: the grid {found.name} has voxels that are not numbers: mend the simulation")
        to_world = self._matrix @ index_to_world(found)
        stretches = np.linalg.svd(to_world[:3, :3], compute_uv=False)
        if not stretches[-1] > _FLAT * stretches[0]:
            raise SettingError(f"the volume {self.name} is scaled to nothing along an axis: give it another scale")
        return values, np.array(low), to_world

    @property
    def box(self):
        """Lowest and highest corner in the world."""
        values, low, to_world = self._vectors
        return world_box(low, low + values.shape[:3] - 1, to_world)

    def grid(self, resolution):
        """A grid along the world's axes, with so many nodes along its longest side."""
        return box_grid(*self.box, resolution)

    def integrals(self, grid):
        """(e,) of the velocity, sampled at the grid's nodes, along its edges."""
        values, low, to_world = self._vectors
        inverse = np.linalg.inv(to_world)
        places = inverse[:3, :3] @ grid.places.T + inverse[:3, 3:] - low[:, None]
        sampled = [map_coordinates(values[..., k], places, order=1, mode="nearest") for k in range(3)]
        return edge_integrals(grid, np.stack(sampled, axis=1) @ self._matrix[:3, :3].T)


def vector_grid(path, grids, attribute):
    """The grid of a volume that is the velocity, among all by their headers, and lines that the user should read.

    It is the one that ``attribute`` names; where that is "velocity" and there is none, one of another usual name, then
    the first one of vectors.

    Raises
    ------
    SettingError
        when there is none, naming those that there are
    """
    vectors = [grid for grid in grids if grid.valueTypeName.startswith("vec3")]
    have = ", ".join(f"{grid.name} ({grid.valueTypeName})" for grid in grids) or "none"
    if not vectors:
        raise SettingError(f"{path}: has no grid of vectors (it has {have}): export the velocity")
    wanted = _USUAL if attribute == VELOCITY else (attribute,)
    named = [grid for name in wanted for grid in vectors if grid.name == name]
    if named:
        return named[0], ()
    if attribute != VELOCITY:
        raise SettingError(f"{path}: has no grid of vectors {attribute!r} (it has {have}): name one of these")
    warning = f"{vectors[0].name} is taken for the velocity (there are {have}): name another grid as the attribute"
    return vectors[0], (warning,) if len(vectors) > 1 else ()


class FilamentCurves:
    """Curve objects as vortex filaments, and the flow that they induce in a box around them."""

    warnings = ()

    def __init__(self, objects, core):
        self._curves, self._core = [], core
        for obj in objects:
            if obj.type not in SOURCE_TYPES:
                raise SettingError(f"{obj.name} is no curve: choose curves, a volume, or a .vdb or .npz file")
            strength = obj.get(STRENGTH, 1.0)
            if not isinstance(strength, Real) or not math.isfinite(strength):
                raise SettingError(f"{obj.name}: its {STRENGTH} is {strength!r}: give the circulation as a number")
            matrix = np.array(obj.matrix_world)
            for line, number in _strands(obj):
                self._curves.append((line @ matrix[:3, :3].T + matrix[:3, 3], number * strength))
        if not self._curves:
            raise SettingError("there is no curve with two points: draw the vortex filaments")
        self.name = objects[0].name

    def grid(self, resolution):
        """A grid with so many nodes along the longest side of the box."""
        points = np.concatenate([points for points, _ in self._curves])
        margin = MARGIN * np.ptp(points, axis=0).max()
        return box_grid(points.min(axis=0) - margin, points.max(axis=0) + margin, resolution)

    def integrals(self, grid):
        """(e,) of the velocity along the grid's edges."""
        return filament_integrals(grid, self._curves, self._core * grid.spacing[0])


def _strands(obj):
    """(p, 3) points of every curve of an object, and how many filaments lie on it: in what a flow has shown, the square
    of its radius."""
    splines = obj.data.splines if obj.type == "CURVE" and any(map(is_of_filaments, obj.modifiers)) else ()
    if not splines or any(spline.type != "POLY" for spline in splines):
        return [(line, 1.0) for line in polylines(obj)]
    strands = []
    for spline in splines:
        points = np.array([point.co[:3] for point in spline.points])
        number = np.mean([point.radius**2 for point in spline.points])
        strands.append((np.concatenate([points, points[:1]]) if spline.use_cyclic_u else points, number))
    return [(points, number) for points, number in strands if np.ptp(points, axis=0).any()]


def world_box(low, high, to_world):
    """Lowest and highest corner in the world of a box of indices."""
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, -1)
    world = to_world[:3, :3] @ corners + to_world[:3, 3:]
    return world.min(axis=1), world.max(axis=1)


def index_to_world(grid):
    """(4, 4) matrix of a grid's linear transform."""
    origin = np.array(grid.transform.indexToWorld((0, 0, 0)))
    matrix = np.eye(4)
    for axis in range(3):
        matrix[:3, axis] = np.array(grid.transform.indexToWorld(tuple(np.eye(3)[axis]))) - origin
    matrix[:3, 3] = origin
    return matrix


def box_grid(low, high, resolution):
    """A grid of cubes over a box, with so many nodes along its longest side."""
    size = np.maximum(high - low, 1e-9)
    spacing = size.max() / (resolution - 1)
    counts = np.maximum(np.round(size / spacing).astype(int) + 1, 4)
    origin = (low + high) / 2 - spacing * (counts - 1) / 2
    return Grid(counts, spacing, origin)
