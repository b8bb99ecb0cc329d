# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows in files: arrays of NumPy, and OpenVDB.

A source says what is to be read and can be pickled; its ``read()`` gives the flow, which has ``grid(resolution)``,
``integrals(grid)`` and ``warnings``, lines that the user should read.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from zipfile import ZipFile

import numpy as np
from scipy.ndimage import map_coordinates

from ..errors import SettingError
from ..fields.clebsch import edge_integrals
from ..fields.quantum import sampling_noise
from ..geometry.grid import Grid, box_grid
from ..memory import at_most, machine_bytes
from ..settings.flow import VELOCITY
from .border import array_bytes, border, check_promise
from .openvdb import openvdb_module
from .vdb_sizes import check_vdb_sizes

SUFFIXES = (".vdb", ".npz")
# Names of a flow's vectors, the first of which Blender's own liquids have.
_USUAL = (VELOCITY, "vel", "v")
# Of a vector in single precision.
_VOXEL_BYTES = 12
# What reading a volume may take: so many bytes, and for each byte of its file, which is compressed, so many more.
_SOUND_BYTES, _SOUND_RATIO = 2**31, 200
# Volumes so thin, as a share of their width, are flat: their scale is rounded to about as much.
_FLAT = 1e-6
# Arrays that say where a file's nodes are: their names, kinds of values, and what those are.
_PLACES = {
    "spacing": ("fiu", "one positive number"),
    "origin": ("fiu", "one number"),
    "periodic": ("biu", "one true or false"),
}
# Array that says which nodes lie in obstacles.
SOLID = "solid"
# No transform of a volume has a number as large as this.
_FARTHEST = 1e30
# The library crashes at copying voxels whose numbers are above 2**29.
_FARTHEST_VOXEL = 2**28


def flow_file(path, attribute=VELOCITY, module=None):
    """The :class:`ArrayFile` or :class:`VolumeFile` of a path; see those for the rest.

    Raises
    ------
    SettingError
        for a file of another kind, or none
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise SettingError(f"{path}: flows are read from {' and '.join(SUFFIXES)} files")
    if not path.is_file():
        raise SettingError(f"{path}: no such file")
    if path.suffix.lower() == ".npz":
        return ArrayFile(path)
    return VolumeFile(path, np.eye(4), path.name, attribute, module)


@dataclass(frozen=True)
class GridFlow:
    """A flow at the nodes of a grid of its own.

    Attributes
    ----------
    own : Grid
    velocity : (n, 3) or (n, 2) at its nodes
    warnings : none
    """

    own: Grid
    velocity: np.ndarray
    warnings: tuple[str, ...] = ()

    def grid(self, _resolution):
        """The flow's own grid."""
        return self.own

    def integrals(self, grid):
        """(e,) of the velocity along the grid's edges."""
        return edge_integrals(grid, self.velocity)

    @property
    def noise(self):
        """As :func:`sampling_noise` has it."""
        return sampling_noise(self.own, self.velocity)


@dataclass(frozen=True)
class ArrayFile:
    """A .npz file with velocity (nx, ny, nz, 3) or (nx, ny, 2), and optional spacing, origin, periodic and solid.

    Solid, (nx, ny, nz) or (nx, ny), is true at nodes in obstacles, whose velocity does not count.

    Attributes
    ----------
    path : of the file
    """

    path: Path

    @property
    def name(self):
        """Of the file."""
        return self.path.name

    @property
    def is_plane(self):
        """Whether the velocity has the shape of one in a plane, as its header says; False where that cannot be read."""
        try:
            with border(self.path), ZipFile(self.path) as archive:
                return len(_headers(archive)["velocity"].shape) == 3
        except (SettingError, KeyError):
            return False

    def read(self):
        """The :class:`GridFlow`.

        Raises
        ------
        SettingError
            in one line, for a file that is not such a flow
        """
        with border(self.path, "write it with numpy.savez"):
            arrays = self._arrays()
        velocity = arrays["velocity"]
        grid = Grid(velocity.shape[:-1], **{name: arrays[name] for name in (*_PLACES, SOLID) if name in arrays})
        return GridFlow(grid, np.where(grid.solid[..., None], 0, velocity).reshape(-1, velocity.shape[-1]))

    def _arrays(self):
        """The arrays of a flow by their names; nothing is read before the headers of all of them are sound."""
        with self.path.open("rb") as file:
            if file.read(len(np.lib.format.MAGIC_PREFIX)) == np.lib.format.MAGIC_PREFIX:
                raise SettingError("a single array without a name: write it with numpy.savez")
        with ZipFile(self.path) as archive:
            headers = _headers(archive)
            if "velocity" not in headers:
                have = ", ".join(name.removesuffix(".npy") for name in archive.namelist()) or "nothing"
                raise SettingError(f"has no array 'velocity' (it has {have}): save the flow under that name")
            _check_headers(headers)
            check_promise(self.path, 2 * sum(array_bytes(header.shape, header.dtype) for header in headers.values()))
            found = {name: _read_member(archive, name) for name in headers}
        axes = found["velocity"].ndim - 1
        for name, (kinds, wanted) in _PLACES.items():
            given = found.get(name)
            if given is None:
                continue
            if given.dtype.kind not in kinds or given.shape not in ((), (1,), (axes,)) or not np.isfinite(given).all():
                raise SettingError(f"{name} is {given.tolist()!r}: give {wanted}, or {axes} of them")
        return found


class _Header(NamedTuple):
    """Shape and type of an array that a file promises."""

    shape: tuple[int, ...]
    dtype: np.dtype


def _headers(archive):
    """The :class:`_Header` of each array of an archive that a flow has, by its name."""
    members, found = archive.namelist(), {}
    for name in ("velocity", *_PLACES, SOLID):
        if f"{name}.npy" in members:
            with archive.open(f"{name}.npy") as file:
                try:
                    version = np.lib.format.read_magic(file)
                except ValueError:
                    raise SettingError(f"its member {name} is not an array: write it with numpy.savez") from None
                is_old = version == (1, 0)
                read = np.lib.format.read_array_header_1_0 if is_old else np.lib.format.read_array_header_2_0
                shape, _, dtype = read(file)
                promised, there = file.tell() + array_bytes(shape, dtype), archive.getinfo(f"{name}.npy").file_size
                if promised != there:
                    raise SettingError(
                        f"its member {name} promises {promised} bytes and has {there}: write it with numpy.savez"
                    )
            found[name] = _Header(shape, dtype)
    return found


def _check_headers(headers):
    """Refuse arrays of shapes and types that no flow has."""
    shape, dtype = headers["velocity"]
    if len(shape) not in (3, 4) or shape[-1] != len(shape) - 1:
        raise SettingError(f"velocity has the shape {shape}: use (nx, ny, nz, 3) or (nx, ny, 2)")
    if dtype.kind not in "fiu":
        raise SettingError(f"velocity holds {dtype} values: save it as floating-point numbers")
    for name in _PLACES.keys() & headers.keys():
        if math.prod(headers[name].shape) > 3:
            raise SettingError(
                f"{name} is of the shape {headers[name].shape}: give {_PLACES[name][1]}, or {shape[-1]} of them"
            )
    solid = headers.get(SOLID)
    if solid is not None and (solid.dtype.kind not in "biu" or solid.shape != shape[:-1]):
        has = f"{solid.dtype} values of the shape {solid.shape}"
        raise SettingError(f"{SOLID} has {has}: give true or false for each node of the velocity")


def _read_member(archive, name):
    with archive.open(f"{name}.npy") as file:
        return np.lib.format.read_array(file, allow_pickle=False)


@dataclass(frozen=True)
class VoxelFlow:
    """A flow at the voxels of a volume.

    Attributes
    ----------
    values : (nx, ny, nz, 3) velocity along the file's axes
    low : (3,) index of the first voxel
    to_world : (4, 4) matrix that takes indices to the world
    turn : (3, 3) matrix that takes velocities to the world
    warnings : lines that the user should read
    """

    values: np.ndarray
    low: np.ndarray
    to_world: np.ndarray
    turn: np.ndarray
    warnings: tuple[str, ...]

    @property
    def noise(self):
        """Of the voxels, as :func:`sampling_noise` has it."""
        spacing = np.linalg.norm(self.to_world[:3, :3], axis=0)
        return sampling_noise(Grid(self.values.shape[:3], spacing), self.values.reshape(-1, 3))

    @property
    def box(self):
        """Lowest and highest corner in the world."""
        return world_box(self.low, self.low + self.values.shape[:3] - 1, self.to_world)

    def grid(self, resolution):
        """A grid along the world's axes, with so many nodes along its longest side."""
        low, high = self.box
        return box_grid(low, high, resolution)

    def integrals(self, grid):
        """(e,) of the velocity, sampled at the grid's nodes, along its edges."""
        inverse = np.linalg.inv(self.to_world)
        places = inverse[:3, :3] @ grid.places.T + inverse[:3, 3:] - self.low[:, None]
        sampled = [map_coordinates(self.values[..., k], places, order=1, mode="nearest") for k in range(3)]
        return edge_integrals(grid, np.stack(sampled, axis=1) @ self.turn.T)


@dataclass(frozen=True)
class VolumeFile:
    """A grid of vectors of a .vdb file.

    Attributes
    ----------
    path : of the file
    matrix : (4, 4) that takes the file's world to the scene's
    name : what errors call the volume
    attribute : name of its grid, as :func:`_vector_grid` has it
    module : file of the OpenVDB module, None where that is found by its name
    """

    path: Path
    matrix: np.ndarray
    name: str
    attribute: str
    module: str | None

    def read(self):
        """The :class:`VoxelFlow`.

        Raises
        ------
        SettingError
            in one line, for a file that is no such flow, and for a matrix that makes it flat
        """
        path, vdb = self.path, openvdb_module(self.module)
        if not path.is_file():
            raise SettingError(f"{path}: no such file")
        with border(path, "choose an OpenVDB file"):
            return self._read(vdb)

    def _read(self, vdb):
        path = self.path
        try:
            with self._limited():
                chosen, warnings = _vector_grid(path, self._metadata(vdb), self.attribute)
                found = vdb.read(str(path), chosen.name)
        except SettingError:
            raise
        except MemoryError:
            raise SettingError("reading it takes more memory than a sound file of its size: export it again") from None
        except Exception as error:  # the reader's library raises whatever it likes at damaged files
            raise SettingError(f"{error}: choose an OpenVDB file") from None
        empty = SettingError(f"the grid {found.name} is empty: export a frame that has a flow")
        if found.activeVoxelCount() == 0:  # its box may be anything
            raise empty
        low, high = found.evalActiveVoxelBoundingBox()
        if max(map(abs, (*low, *high))) > _FARTHEST_VOXEL:
            raise SettingError(f"the grid {found.name} has voxels too far from its origin: move them nearer to it")
        counts = np.array(high, float) - low + 1
        if counts.prod() * _VOXEL_BYTES > machine_bytes() / 2:
            size = " x ".join(f"{count:.0f}" for count in counts)
            raise SettingError(
                f"the grid {found.name} spans {size} voxels, more than memory holds: remove what lies far away"
            )
        counts = counts.astype(int)
        if (counts < 2).any():
            raise empty
        values = np.empty((*counts, 3), np.float32)
        found.copyToArray(values, ijk=low)
        if not np.isfinite(values).all():
            raise SettingError(f"the grid {found.name} has voxels that are not numbers: mend the simulation")
        own = _index_to_world(found)
        if not (np.abs(own) < _FARTHEST).all():
            raise SettingError(f"the grid {found.name} has a transform that is not finite: export it again")
        to_world = self.matrix @ own
        stretches = np.linalg.svd(to_world[:3, :3], compute_uv=False)
        if not stretches[-1] > _FLAT * stretches[0]:
            raise SettingError(f"the volume {self.name} is scaled to nothing along an axis: give it another scale")
        return VoxelFlow(values, np.array(low), to_world, self.matrix[:3, :3], warnings)

    def _limited(self):
        """Hold the reader to the memory that a sound file can take."""
        return at_most(_SOUND_BYTES + _SOUND_RATIO * self.path.stat().st_size)

    def _metadata(self, vdb):
        """The headers of the file's grids, whose promises its bytes can hold."""
        check_vdb_sizes(self.path)
        return vdb.readAllGridMetadata(str(self.path))

    def header(self):
        """Lowest and highest index of the file's grid, and the (4, 4) matrix that takes indices to the file's world,
        without reading any voxel; None where the header does not tell them."""
        try:
            with self._limited():
                grids = self._metadata(openvdb_module(self.module))
            chosen, _ = _vector_grid(self.path, grids, self.attribute)
            low, high = (np.array(chosen[name]) for name in ("file_bbox_min", "file_bbox_max"))
        except Exception:  # as in read(), which says what is wrong
            return None
        return low, high, _index_to_world(chosen)


def _vector_grid(path, grids, attribute):
    """The grid of a volume that is the velocity, among all by their headers, and lines that the user should read.

    It is the one that ``attribute`` names; where that is "velocity" and there is none, one of another usual name, then
    the first one of vectors. SettingError names those that there are when there is none.
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


def _index_to_world(grid):
    """(4, 4) matrix of a grid's linear transform."""
    origin = np.array(grid.transform.indexToWorld((0, 0, 0)))
    matrix = np.eye(4)
    for axis in range(3):
        matrix[:3, axis] = np.array(grid.transform.indexToWorld(tuple(np.eye(3)[axis]))) - origin
    matrix[:3, 3] = origin
    return matrix


def world_box(low, high, to_world):
    """Lowest and highest corner in the world of a box of indices."""
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, -1)
    world = to_world[:3, :3] @ corners + to_world[:3, 3:]
    return world.min(axis=1), world.max(axis=1)
