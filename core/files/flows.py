# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows in files: arrays of NumPy here, OpenVDB and other programs' files in the modules beside it.

A source says what to read and can be pickled; its ``read()`` returns the flow, which has ``grid(resolution)``,
``integrals(grid)`` and ``warnings``, lines that the user should read.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from zipfile import ZipFile

import numpy as np

from ..errors import SettingError
from ..geometry.grid import Grid
from ..settings.flow import VELOCITY
from .border import array_bytes, border, check_promise
from .flow_grids import ARRAYS, IMAGE, MESHES, OtherFile
from .regular_flows import GridFlow
from .volumes import VolumeFile

SUFFIXES = (".vdb", ".npz", *IMAGE, *ARRAYS, *MESHES)
# Names of arrays that place a file's nodes, their kinds of values, and what errors ask for.
_PLACES = {
    "spacing": ("fiu", "one positive number"),
    "origin": ("fiu", "one number"),
    "periodic": ("biu", "one true or false"),
}
# Names of arrays of nodes in obstacles, and of the vorticity that may replace the velocity.
SOLID, VORTICITY = "solid", "vorticity"


def flow_file(
    path: str | Path, attribute: str = VELOCITY, module: str | None = None
) -> "ArrayFile | VolumeFile | OtherFile":
    """The source of a path; SettingError for a file that is missing or of another kind."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise SettingError(f"{path}: flows are read from {', '.join(SUFFIXES)} files")
    if not path.is_file():
        raise SettingError(f"{path}: no such file")
    if path.suffix.lower() == ".npz":
        return ArrayFile(path)
    if path.suffix.lower() != ".vdb":
        return OtherFile(path, attribute)
    return VolumeFile(path, np.eye(4), path.name, attribute, module)


@dataclass(frozen=True)
class ArrayFile:
    """A .npz file with velocity (nx, ny, nz, 3) or (nx, ny, 2), and optional spacing, origin, periodic and solid.

    Vorticity (nx, ny, nz, 3) may replace the velocity. Solid, (nx, ny, nz) or (nx, ny), is true at nodes in obstacles,
    whose velocity does not count.
    """

    path: Path

    @property
    def name(self) -> str:
        """The file's name."""
        return self.path.name

    @property
    def is_plane(self) -> bool:
        """Whether the velocity is one in a plane, by its header; False where that cannot be read."""
        try:
            with border(self.path), ZipFile(self.path) as archive:
                return len(_headers(archive)["velocity"].shape) == 3
        except (SettingError, KeyError):
            return False

    def read(self) -> GridFlow:
        """Read the flow; SettingError for a file of another kind."""
        with border(self.path, "write it with numpy.savez"):
            arrays = self._arrays()
        is_curl = "velocity" not in arrays
        velocity = arrays[VORTICITY if is_curl else VELOCITY]
        grid = Grid(velocity.shape[:-1], **{name: arrays[name] for name in (*_PLACES, SOLID) if name in arrays})
        return GridFlow(grid, np.where(grid.solid[..., None], 0, velocity).reshape(-1, velocity.shape[-1]), is_curl)

    def _arrays(self) -> dict[str, np.ndarray]:
        """The arrays of a flow by their names; all headers are checked before an array is read."""
        with self.path.open("rb") as file:
            if file.read(len(np.lib.format.MAGIC_PREFIX)) == np.lib.format.MAGIC_PREFIX:
                raise SettingError("a single array without a name: write it with numpy.savez")
        with ZipFile(self.path) as archive:
            headers = _headers(archive)
            if not headers.keys() & {VELOCITY, VORTICITY}:
                have = ", ".join(name.removesuffix(".npy") for name in archive.namelist()) or "nothing"
                raise SettingError(f"has no array 'velocity' (it has {have}): save the flow under that name")
            _check_headers(headers)
            check_promise(self.path, 2 * sum(array_bytes(header.shape, header.dtype) for header in headers.values()))
            found = {name: _read_member(archive, name) for name in headers}
        axes = found[VELOCITY if VELOCITY in found else VORTICITY].ndim - 1
        for name, (kinds, wanted) in _PLACES.items():
            given = found.get(name)
            if given is None:
                continue
            if given.dtype.kind not in kinds or given.shape not in ((), (1,), (axes,)) or not np.isfinite(given).all():
                raise SettingError(f"{name} is {given.tolist()!r}: give {wanted}, or {axes} of them")
        return found


class _Header(NamedTuple):
    """Shape and type of an array, as a file promises them."""

    shape: tuple[int, ...]
    dtype: np.dtype


def _headers(archive: ZipFile) -> dict[str, _Header]:
    """The headers of an archive's arrays that belong to a flow, by their names."""
    members, found = archive.namelist(), {}
    vectors = VELOCITY if f"{VELOCITY}.npy" in members else VORTICITY
    for name in (vectors, *_PLACES, SOLID):
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


def _check_headers(headers: dict[str, _Header]) -> None:
    """Refuse arrays that have not the shape and type of a flow."""
    vectors = VELOCITY if VELOCITY in headers else VORTICITY
    shape, dtype = headers[vectors]
    if len(shape) not in (3, 4) or shape[-1] != len(shape) - 1:
        raise SettingError(f"{vectors} has the shape {shape}: use (nx, ny, nz, 3) or (nx, ny, 2)")
    if dtype.kind not in "fiu":
        raise SettingError(f"{vectors} holds {dtype} values: save it as floating-point numbers")
    for name in _PLACES.keys() & headers.keys():
        if math.prod(headers[name].shape) > 3:
            raise SettingError(
                f"{name} is of the shape {headers[name].shape}: give {_PLACES[name][1]}, or {shape[-1]} of them"
            )
    solid = headers.get(SOLID)
    if solid is not None and (solid.dtype.kind not in "biu" or solid.shape != shape[:-1]):
        has = f"{solid.dtype} values of the shape {solid.shape}"
        raise SettingError(f"{SOLID} has {has}: give true or false for each node of the velocity")


def _read_member(archive: ZipFile, name: str) -> np.ndarray:
    with archive.open(f"{name}.npy") as file:
        return np.lib.format.read_array(file, allow_pickle=False)
