# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows in OpenVDB files: grids of vectors, centred or staggered, or a grid for each component."""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from scipy.ndimage import map_coordinates

from ..errors import SettingError
from ..fields.clebsch import edge_integrals
from ..fields.quantum import sampling_noise
from ..fields.vorticity import vorticity_integrals
from ..geometry.grid import Grid, box_grid
from ..memory import at_most, machine_bytes
from ..settings.flow import VELOCITY
from .border import border
from .openvdb import check_vdb_sizes, openvdb_module

# The memory that reading a volume may take: this number of bytes, and this many for each byte of its compressed file.
SOUND_BYTES, SOUND_RATIO = 2**31, 200
# Volumes thinner than this share of their width are flat: their scale is rounded to about as much.
_FLAT = 1e-6
# Numbers of transforms are smaller than this; the library crashes at copying voxels with indices above 2**29.
_FARTHEST, _FARTHEST_VOXEL = 1e30, 2**28
# Indices this near to whole numbers are rounded to them.
_ASIDE = 1e-3
# Names of velocities, the first of which Blender's own liquids have, and of vorticities.
USUAL, ROTATIONS = (VELOCITY, "vel", "v", "u"), ("vorticity", "vort", "omega", "curl")
# Letters in which the names of components differ, such as vel.x, X Velocity, B/x, uwnd, vel[0] and vx1.
_AXES = ("xyz", "uvw", "012", "123")


def choose_flow(
    path: Path,
    vectors: Sequence[str],
    numbers: Sequence[str],
    attribute: str,
    have: str | None = None,
    may_be_level: bool = False,
) -> tuple[tuple[str, ...], bool, tuple[str, ...]]:
    """Choose the flow among a file's arrays or grids: the one, or the components of the one, that ``attribute`` names;
    if that is "velocity" and missing, one with another usual name, else a vorticity, else the first one.

    Parameters
    ----------
    vectors, numbers : names of arrays of vectors, and of plain numbers
    have : the content of the file for errors; None for these names
    may_be_level : whether two components will do, where the file has no third one

    Returns
    -------
    names : of the vectors, or of their components
    is_curl : whether they are the vorticity
    warnings : lines that the user should read

    Raises SettingError naming the content of a file without such vectors.
    """
    have = have or ", ".join([*vectors, *numbers]) or "none"
    flows = component_names(numbers) | {name: (name,) for name in vectors}
    level: tuple[str, ...] = ()
    if not flows and may_be_level:
        flows = component_names(numbers, 2)
        level = ("the flow has two components alone: it counts as level, without a vertical one",)
    if not flows:
        raise SettingError(f"{path}: has no vectors (it has {have}): export the velocity")
    wanted = (*USUAL, *ROTATIONS) if attribute == VELOCITY else (attribute,)
    by_name = {name.lower(): name for name in reversed(flows)}
    found = next((by_name[name.lower()] for name in wanted if name.lower() in by_name), None)
    if found is not None:
        return flows[found], found.lower() in ROTATIONS, level
    if attribute != VELOCITY:
        raise SettingError(f"{path}: has no vectors {attribute!r} (it has {have}): name one of these")
    first = (*vectors, *flows)[0]
    warning = f"{first} is used as the velocity (there are {have}): name another one as the attribute"
    return flows[first], first.lower() in ROTATIONS, ((warning,) if len(flows) > 1 else ()) + level


def component_names(names: Sequence[str], count: int = 3) -> dict[str, tuple[str, ...]]:
    """The names of the first ``count`` components of each vector whose components are apart, by its name.

    They differ in one letter or digit: any x, y, z, a u, v, w at the beginning, or a number at the end.
    """
    found: dict[str, tuple[str, ...]] = {}
    for axes in _AXES if count == 3 else _AXES[:2]:
        for name in sorted(names, key=len) if axes == "uvw" else names:
            for place in range(len(name)):
                begin, letter, end = name[:place], name[place], name[place + 1 :]
                if letter.lower() != axes[0] or (begin if axes == "uvw" else axes.isdigit() and end not in ("", "]")):
                    continue
                parts = tuple(begin + (axis.upper() if letter.isupper() else axis) + end for axis in axes[:count])
                base = VELOCITY if axes == "uvw" else (begin + end).strip(" ._-:/[]")
                if base and set(parts) <= set(names) and parts not in found.values():
                    found.setdefault(base, parts)
    return found


@dataclass(frozen=True)
class Channel:
    """One component of a flow at the voxels of a volume.

    Attributes
    ----------
    values : (nx, ny, nz)
    to_world : (4, 4) matrix from indices of the values to the world
    """

    values: np.ndarray
    to_world: np.ndarray

    def at(self, places: np.ndarray) -> np.ndarray:
        """(n,) values at (n, 3) places in the world, interpolated linearly."""
        inverse = np.linalg.inv(self.to_world)
        return map_coordinates(self.values, inverse[:3, :3] @ places.T + inverse[:3, 3:], order=1, mode="nearest")


@dataclass(frozen=True)
class VoxelFlow:
    """A flow at the voxels of a volume.

    Attributes
    ----------
    channels : along the file's three axes
    box : lowest and highest corner in the world
    turn : (3, 3) matrix from the file's space to the world
    is_staggered : whether each component is known on the faces across its axis
    is_vorticity : whether the values are the vorticity of the flow
    warnings : lines that the user should read
    """

    channels: tuple[Channel, ...]
    box: tuple[np.ndarray, np.ndarray]
    turn: np.ndarray
    is_staggered: bool
    is_vorticity: bool
    warnings: tuple[str, ...]

    @property
    def noise(self) -> float | None:
        """The :func:`sampling_noise` of the voxels; None where it cannot be measured."""
        values = [channel.values for channel in self.channels]
        if self.is_vorticity or len({part.shape for part in values}) > 1:
            return None
        spacing = np.linalg.norm(self.channels[0].to_world[:3, :3], axis=0)
        return sampling_noise(Grid(values[0].shape, spacing), np.stack(values, axis=-1).reshape(-1, 3))

    def grid(self, resolution: int) -> Grid:
        """A grid along the world's axes with ``resolution`` nodes along its longest side."""
        return box_grid(*self.box, resolution)

    def at(self, places: np.ndarray) -> np.ndarray:
        """(n, 3) vectors at places in the world. Velocities grow with the volume's scale; vorticities do not, and they
        change their sign where it is mirrored."""
        turn = self.turn / np.cbrt(np.linalg.det(self.turn)) if self.is_vorticity else self.turn
        return np.stack([channel.at(places) for channel in self.channels], axis=1) @ turn.T

    def integrals(self, grid: Grid) -> np.ndarray:
        """(e,) integrals of the velocity along the grid's edges; for staggered files also by their middles, where the
        components are known."""
        values = self.at(grid.places)
        if self.is_vorticity:
            return vorticity_integrals(grid, values)
        integrals = edge_integrals(grid, values)
        if not self.is_staggered:
            return integrals
        axes = grid.edge_axes
        middles = grid.places[grid.edges[:, 0]]
        middles[np.arange(len(axes)), axes] += 0.5 * grid.spacing[axes]
        for axis in range(grid.dimension):
            chosen = axes == axis
            middle = self.at(middles[chosen])[:, axis] * grid.spacing[axis]
            integrals[chosen] = 0.5 * (integrals[chosen] + middle)
        return integrals


@dataclass(frozen=True)
class VolumeFile:
    """A grid of vectors of a .vdb file, or three grids of its components.

    Attributes
    ----------
    matrix : (4, 4) from the file's world to the scene's
    name : of the volume in errors
    attribute : name of its grid, as in :func:`choose_flow`
    module : file of the OpenVDB module; None to find it by its name
    """

    path: Path
    matrix: np.ndarray
    name: str
    attribute: str
    module: str | None

    def read(self) -> VoxelFlow:
        """Read the flow; SettingError for another file, and for a matrix that makes it flat."""
        path, vdb = self.path, openvdb_module(self.module)
        if not path.is_file():
            raise SettingError(f"{path}: no such file")
        with border(path, "choose an OpenVDB file"):
            return self._read(vdb)

    def _read(self, vdb: ModuleType) -> VoxelFlow:
        """Read the box of active voxels of the flow's grids; each component with its own transform, as they may be
        staggered."""
        path = self.path
        try:
            with self._limited():
                chosen, is_curl, warnings = _flow_grids(path, self._metadata(vdb), self.attribute)
                grids = [vdb.read(str(path), grid.name) for grid in chosen]
            name = chosen[0].name
        except SettingError:
            raise
        except MemoryError:
            raise SettingError("reading it takes more memory than a sound file of its size: export it again") from None
        except Exception as error:  # the reader's library raises whatever it likes at damaged files
            raise SettingError(f"{error}: choose an OpenVDB file") from None
        full = [number for number, grid in enumerate(grids) if grid.activeVoxelCount()]  # other boxes may be anything
        empty = SettingError(f"the grid {name} is empty: export a frame that has a flow")
        if not full:
            raise empty
        owns = [_index_to_world(grid) for grid in grids]
        if not (np.abs(owns) < _FARTHEST).all():
            raise SettingError(f"the grid {name} has a transform that is not finite: export it again")
        for own in owns:
            stretches = np.linalg.svd((self.matrix @ own)[:3, :3], compute_uv=False)
            if not stretches[-1] > _FLAT * stretches[0]:
                raise SettingError(f"the volume {self.name} is scaled to nothing along an axis: give it another scale")
        boxes = []
        for number in full:
            first, last = grids[number].evalActiveVoxelBoundingBox()
            boxes.append(world_box(first, last, owns[number]))
        low, high = np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)
        parts = [_read_box(name, grid, low, high, own, len(grids)) for grid, own in zip(grids, owns, strict=True)]
        if min(np.min(values.shape[:3]) for values, _ in parts) < 2:
            raise empty
        is_staggered = any(grid.gridClass == "staggered" for grid in grids)
        channels = []
        for axis in range(3):
            (values, first), own = (parts[axis], owns[axis]) if len(grids) == 3 else (parts[0], owns[0])
            shift = first - 0.5 * (is_staggered and len(grids) == 1) * np.eye(3)[axis]
            to_world = self.matrix @ own
            to_world[:3, 3] += to_world[:3, :3] @ shift
            channels.append(Channel(values if len(grids) == 3 else values[..., axis], to_world))
        is_staggered |= len({tuple(np.round(own[:3, 3], 9)) for own in owns}) == 3
        box = world_box(low, high, self.matrix)
        return VoxelFlow(tuple(channels), box, self.matrix[:3, :3], is_staggered, is_curl, warnings)

    def _limited(self) -> AbstractContextManager[None]:
        """Limit the reader to the memory that a sound file can take."""
        return at_most(SOUND_BYTES + SOUND_RATIO * self.path.stat().st_size)

    def _metadata(self, vdb: ModuleType) -> list[Any]:
        """The headers of the file's grids, whose sizes have been checked."""
        check_vdb_sizes(self.path)
        return vdb.readAllGridMetadata(str(self.path))

    def header(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Lowest and highest index of the file's grid, and the (4, 4) matrix from indices to the file's world, without
        reading a voxel; None where the header lacks them."""
        try:
            with self._limited():
                grids = self._metadata(openvdb_module(self.module))
            chosen, _, _ = _flow_grids(self.path, grids, self.attribute)
            boxes = [[np.array(grid[name]) for name in ("file_bbox_min", "file_bbox_max")] for grid in chosen]
        except Exception:  # as in read(), which says what is wrong
            return None
        low, high = np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)
        return low, high, _index_to_world(chosen[0])


def _flow_grids(path: Path, grids: list[Any], attribute: str) -> tuple[list[Any], bool, tuple[str, ...]]:
    """Headers of the grids that :func:`choose_flow` chooses, and the rest of its result."""
    by_name = {grid.name: grid for grid in reversed(grids)}
    vectors = [grid.name for grid in grids if grid.valueTypeName.startswith("vec3")]
    numbers = [grid.name for grid in grids if grid.valueTypeName in ("float", "double", "half")]
    have = ", ".join(f"{grid.name} ({grid.valueTypeName})" for grid in grids) or "none"
    names, is_curl, warnings = choose_flow(path, vectors, numbers, attribute, have)
    return [by_name[name] for name in names], is_curl, warnings


def _read_box(
    name: str, grid: Any, low: np.ndarray, high: np.ndarray, own: np.ndarray, share: int
) -> tuple[np.ndarray, np.ndarray]:
    """The values of one of ``share`` grids in a box of the file's world, and the lowest index there."""
    low, high = world_box(low, high, np.linalg.inv(own))
    low, high = np.floor(low + _ASIDE), np.ceil(high - _ASIDE)
    if max(map(abs, (*low, *high))) > _FARTHEST_VOXEL:
        raise SettingError(f"the grid {name} has voxels too far from its origin: move them nearer to it")
    counts = high - low + 1
    if counts.prod() * 3 * 4 > machine_bytes() / 2:
        size = " x ".join(f"{count:.0f}" for count in counts)
        raise SettingError(f"the grid {name} spans {size} voxels, more than memory holds: remove what lies far away")
    values = np.empty((*counts.astype(int), *[3] * (share == 1)), np.float32)
    grid.copyToArray(values, ijk=tuple(low.astype(int).tolist()))
    if not np.isfinite(values).all():
        raise SettingError(f"the grid {name} has voxels that are not numbers: mend the simulation")
    return values, low


def _index_to_world(grid: Any) -> np.ndarray:
    """(4, 4) matrix of a grid's linear transform."""
    origin = np.array(grid.transform.indexToWorld((0, 0, 0)))
    matrix = np.eye(4)
    for axis in range(3):
        matrix[:3, axis] = np.array(grid.transform.indexToWorld(tuple(np.eye(3)[axis]))) - origin
    matrix[:3, 3] = origin
    return matrix


def world_box(low: np.ndarray, high: np.ndarray, to_world: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner in the world of a box of indices."""
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, -1)
    world = to_world[:3, :3] @ corners + to_world[:3, 3:]
    return world.min(axis=1), world.max(axis=1)
