# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows of other programs: VTK's images (.vti), NetCDF, HDF5, and files for pyvista or meshio where they are installed.

.vti is read here, as text, base64, or appended raw, compressed by zlib or not; NetCDF of version 3 by SciPy, version 4
and HDF5 by h5py. Axes of their arrays are z, y, x, as usual in these formats, unless the lengths of coordinates say
otherwise. Flows on other meshes of VTK are sampled on a grid, whose nodes outside the mesh count as solid.
"""

import importlib
import math
import re
import warnings
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from types import ModuleType
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from scipy.io import netcdf_file
from scipy.ndimage import map_coordinates

from ..errors import SettingError
from ..fields.clebsch import edge_integrals
from ..fields.quantum import sampling_noise
from ..fields.vorticity import vorticity_integrals
from ..geometry.grid import Grid, box_grid
from ..memory import at_most
from .border import TEXT_BYTES, border, check_promise, read_bytes
from .tets import vtu_array, vtu_arrays, vtu_root
from .volumes import SOUND_BYTES, SOUND_RATIO, choose_flow

IMAGE, ARRAYS, MESHES = (".vti",), (".nc", ".h5", ".hdf5"), (".vts", ".vtr", ".vtk", ".vtu")
# Names of arrays that are not 0 in obstacles, and of arrays that are 0 outside the flow.
_SOLIDS, _MASKS = ("solid", "obstacle", "obstacles"), ("mask", "vtkvalidpointmask")
# Names of coordinates along each axis, and by what share their spacings may differ.
_COORDINATES = (("x", "xcoor", "lon", "longitude"), ("y", "ycoor", "lat", "latitude"), ("z", "zcoor", "lev", "depth"))
_EVEN = 1e-3
# Name of the vectors that are sampled on a mesh.
_SAMPLED = "synch flow"
_PIP = "install it for Python (pip install synch-fields[flows]), or save the flow as .vti or .npz"


@dataclass(frozen=True)
class GridFlow:
    """A flow at the nodes of a grid.

    Attributes
    ----------
    own : the grid
    velocity : (n, 3) or (n, 2) at its nodes
    is_vorticity : whether these vectors are the vorticity of the flow
    warnings : lines that the user should read
    """

    own: Grid
    velocity: np.ndarray
    is_vorticity: bool = False
    warnings: tuple[str, ...] = ()

    @property
    def noise(self) -> float | None:
        """The :func:`sampling_noise`; None where it cannot be measured."""
        return None if self.is_vorticity else sampling_noise(self.own, self.velocity)

    def grid(self, _resolution: int) -> Grid:
        """The flow's own grid."""
        return self.own

    def integrals(self, grid: Grid) -> np.ndarray:
        """(e,) of the velocity along the grid's edges."""
        return vorticity_integrals(grid, self.velocity) if self.is_vorticity else edge_integrals(grid, self.velocity)


@dataclass(frozen=True)
class SampledFlow:
    """A flow on a mesh in a box, by a function that gives (n, 3) vectors at (n, 3) places, nan outside the mesh; the
    rest as in :class:`GridFlow`."""

    low: np.ndarray
    high: np.ndarray
    sample: Callable[[np.ndarray], np.ndarray]
    is_vorticity: bool = False
    warnings: tuple[str, ...] = ()
    noise = None

    def grid(self, resolution: int) -> Grid:
        """A grid with ``resolution`` nodes along its longest side, solid outside the mesh."""
        grid = box_grid(self.low, self.high, resolution)
        outside = np.isnan(self.sample(grid.places)).any(axis=1).reshape(grid.shape)
        return Grid(grid.shape, grid.spacing, grid.origin, solid=outside)

    def integrals(self, grid: Grid) -> np.ndarray:
        """(e,) of the velocity along the grid's edges."""
        flow = GridFlow(grid, np.nan_to_num(self.sample(grid.places)), self.is_vorticity)
        return flow.integrals(grid)


@dataclass(frozen=True)
class OtherFile:
    """A flow in a file of another program; the attribute is the name of its vectors, as in :func:`choose_flow`."""

    path: Path
    attribute: str

    @property
    def name(self) -> str:
        """The file's name."""
        return self.path.name

    def read(self) -> GridFlow | SampledFlow:
        """Read the flow; SettingError for a file of another kind."""
        suffix = self.path.suffix.lower()
        with border(self.path, "export it again"):
            if suffix in IMAGE:
                return _read_image(self.path, self.attribute)
            if suffix in ARRAYS:
                return _read_arrays(self.path, self.attribute)
            return _read_mesh(self.path, self.attribute)


# Images of VTK


def _read_image(path: Path, attribute: str) -> GridFlow:
    root, appended = vtu_root(path, read_bytes(path, TEXT_BYTES), "ImageData")
    image = next(root.iter("ImageData"))
    pieces = list(image.iter("Piece"))
    if len(pieces) != 1:
        raise SettingError(f"it has {len(pieces)} pieces: save it as one")
    extent = _numbers(image, "WholeExtent", 6)
    if np.abs(extent).max() >= 2**31:
        raise SettingError(f"its WholeExtent is {extent.tolist()}: give numbers of nodes")
    extent = extent.astype(int)
    if pieces[0].get("Extent") is not None and (_numbers(pieces[0], "Extent", 6) != extent).any():
        raise SettingError("its piece is not the whole: save it as one")
    turn = _numbers(image, "Direction", 9, (1, 0, 0, 0, 1, 0, 0, 0, 1)).reshape(3, 3)
    if not np.allclose(turn, np.eye(3)):
        raise SettingError("its axes are turned: resample it along x, y and z")
    spacing = _numbers(image, "Spacing", 3, (1, 1, 1))
    first, shape = extent[::2], extent[1::2] - extent[::2] + 1
    kind = "PointData"
    if not pieces[0].findall("PointData/DataArray"):  # cells, whose middles are a grid of their own
        kind, shape = "CellData", shape - 1
    origin = _numbers(image, "Origin", 3, (0, 0, 0)) + (first + 0.5 * (kind == "CellData")) * spacing
    if (shape < 1).any():
        raise SettingError(f"its extent is {extent.tolist()}: export a flow in space")
    count = math.prod(shape.tolist())
    found = {str(a.get("Name")): a for a in pieces[0].iterfind(f"{kind}/DataArray")}
    sizes = {name: int(array.get("NumberOfComponents") or 1) for name, array in found.items()}
    chosen, is_curl, warnings = choose_flow(
        path, [n for n in found if sizes[n] == 3], [n for n in found if sizes[n] == 1], attribute
    )
    extra = [name for name in found if name.lower() in (*_SOLIDS, *_MASKS) and sizes[name] == 1]
    check_promise(path, 16 * count * sum(sizes[name] for name in (*chosen, *extra)))
    with vtu_arrays():
        arrays = {n: vtu_array(root, appended, found[n], count * sizes[n]) for n in (*chosen, *extra)}
    # The first axis counts fastest.
    arrays = {n: a.reshape(*shape[::-1], sizes[n]).transpose(2, 1, 0, 3) for n, a in arrays.items()}
    vectors = np.concatenate([arrays[name] for name in chosen], axis=3)
    return _grid_flow(vectors, spacing, origin, {n: arrays[n][..., 0] for n in extra}, is_curl, warnings)


def _numbers(element: Element, name: str, count: int, default: Sequence[float] | None = None) -> np.ndarray:
    """The finite numbers of an attribute of XML, ``count`` of them."""
    text = element.get(name)
    words = default if text is None and default is not None else (text or "").split()
    numbers = np.array([float(word) for word in words])
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise SettingError(f"its {name} is {text!r}: give {count} numbers")
    return numbers


def _grid_flow(
    vectors: np.ndarray,
    spacing: Sequence[float] | np.ndarray,
    origin: Sequence[float] | np.ndarray,
    extra: dict[str, np.ndarray],
    is_curl: bool,
    warnings: tuple[str, ...],
) -> GridFlow:
    """A flow of (nx, ny, nz, 3) vectors; nodes in obstacles, outside masks and with nan are solid."""
    solid = ~np.isfinite(vectors).all(axis=3)
    for name, values in extra.items():
        solid |= (values != 0) if name.lower() in _SOLIDS else (values == 0)
    grid = Grid(vectors.shape[:3], spacing, origin, solid=solid if solid.any() else None)
    return GridFlow(grid, np.where(solid[..., None], 0, vectors).reshape(-1, 3).astype(float), is_curl, warnings)


# NetCDF and HDF5


def _read_arrays(path: Path, attribute: str) -> GridFlow:
    with ExitStack() as stack:
        with path.open("rb") as head:
            is_classic = head.read(3) == b"CDF"
        if is_classic:
            check_promise(path, path.stat().st_size)  # all of it is read
            # In memory, where SciPy reads no more than there is, whatever sizes the file promises.
            file = stack.enter_context(netcdf_file(BytesIO(path.read_bytes()), maskandscale=True))
            arrays = dict(file.variables)
        else:
            h5py = _library("h5py", "NetCDF of version 4 and HDF5 are")
            file = stack.enter_context(h5py.File(path, "r"))
            names: list[str] = []
            file.visit(names.append)
            names = [name for name in names if hasattr(file[name], "shape")]
            bare = [_bare(name) for name in names]
            shorts = [short if bare.count(short) == 1 else name for name, short in zip(names, bare, strict=True)]
            arrays = {short: file[name] for name, short in zip(names, shorts, strict=True)}
        return _flow_of_arrays(path, arrays, attribute)


def _bare(name: str) -> str:
    """The name of an array without its groups and a frame's number at its end."""
    return re.sub(r"[_-]?\d+$", "", name.rsplit("/", 1)[-1]) or name


def _flow_of_arrays(path: Path, arrays: dict[str, Any], attribute: str) -> GridFlow:
    vectors = [n for n, a in arrays.items() if len(a.shape) in (4, 5) and a.shape[-1] == 3]
    numbers = [n for n, a in arrays.items() if len(a.shape) in (3, 4) and n not in vectors]
    chosen, is_curl, warnings = choose_flow(path, vectors, numbers, attribute)
    sizes = 1 + (chosen[0] in vectors)
    steps = arrays[chosen[0]].shape[: len(arrays[chosen[0]].shape) - 2 - sizes]
    shape = arrays[chosen[0]].shape[len(steps) : len(steps) + 3]
    if any(count != 1 for count in steps):
        warnings += (f"of {steps[0]} times the first one is shown: save the others as files of their own",)
    extra = [n for n in numbers if n.lower() in (*_SOLIDS, *_MASKS) and arrays[n].shape[-3:] == shape]
    check_promise(path, 24 * math.prod(shape) * (3 + len(extra)))
    read = {n: _values(arrays[n], len(arrays[n].shape) - 2 - sizes) for n in chosen}
    read |= {n: _values(arrays[n], len(arrays[n].shape) - 3) for n in extra}
    if any(values.shape[:3] != shape for values in read.values()):
        raise SettingError("its components are on grids of different sizes: put them on one")
    field = read[chosen[0]] if sizes == 2 else np.stack([read[name] for name in chosen], axis=3)
    axes = [_axis(arrays, names) for names in _COORDINATES]
    lengths = tuple(None if axis is None else len(axis) for axis in axes)
    if lengths != shape or shape == shape[::-1]:  # z, y, x
        field, extras = field.transpose(2, 1, 0, 3), {n: read[n].transpose(2, 1, 0) for n in extra}
    else:
        extras = {n: read[n] for n in extra}
    places = [
        np.arange(count) if axis is None or len(axis) != count else axis
        for axis, count in zip(axes, field.shape[:3], strict=True)
    ]
    return _resample_evenly(field, places, extras, is_curl, warnings)


def _values(array: Any, leading: int) -> np.ndarray:
    """The numbers of the first time step of an array, nan where it has none."""
    values = array[(0,) * leading] if leading else array[:]
    scale = getattr(array, "attrs", {})
    empty = scale.get("_FillValue", scale.get("missing_value"))
    values = np.ma.filled(np.ma.asarray(values, float), np.nan)
    if empty is not None:
        values = np.where(values == np.ravel(empty)[0], np.nan, values)
    return values * np.ravel(scale.get("scale_factor", 1.0))[0] + np.ravel(scale.get("add_offset", 0.0))[0]


def _axis(arrays: dict[str, Any], names: Sequence[str]) -> np.ndarray | None:
    """The coordinates along an axis, None where the file has none."""
    for name, array in arrays.items():
        if name.lower() in names and len(array.shape) == 1:
            return np.asarray(array[:], float)
    return None


def _resample_evenly(
    field: np.ndarray, places: list[np.ndarray], extra: dict[str, np.ndarray], is_curl: bool, warnings: tuple[str, ...]
) -> GridFlow:
    """A flow of values at coordinates along each axis, resampled where these are uneven."""
    for axis, along in enumerate(places):
        steps = np.diff(along)
        if len(steps) and (steps < 0).all():
            places[axis] = along = along[::-1]
            field, extra = np.flip(field, axis), {n: np.flip(a, axis) for n, a in extra.items()}
            steps = -steps[::-1]
        if not len(steps) or not (steps > 0).all():
            raise SettingError(f"its coordinates along {'xyz'[axis]} do not increase: sort them, two at least")
        if np.ptp(steps) > _EVEN * steps.mean():
            wanted = np.interp(np.linspace(along[0], along[-1], len(along)), along, np.arange(len(along)))
            index = np.meshgrid(
                *[wanted if k == axis else np.arange(n) for k, n in enumerate(field.shape[:3])], indexing="ij"
            )
            field = np.stack([map_coordinates(field[..., k], index, order=1) for k in range(3)], axis=3)
            extra = {n: map_coordinates(a, index, order=0) for n, a in extra.items()}
    spacing = [(along[-1] - along[0]) / (len(along) - 1) for along in places]
    return _grid_flow(field, spacing, [along[0] for along in places], extra, is_curl, warnings)


# Meshes of VTK


def _read_mesh(path: Path, attribute: str) -> GridFlow | SampledFlow:
    with at_most(SOUND_BYTES + SOUND_RATIO * path.stat().st_size):
        try:
            pyvista = importlib.import_module("pyvista")
        except ImportError:
            return _by_meshio(path, attribute)
        return _by_pyvista(pyvista, path, attribute)


def _by_pyvista(pyvista: ModuleType, path: Path, attribute: str) -> GridFlow | SampledFlow:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.simplefilter("error", UserWarning)  # pyvista's form of what VTK reports
        try:
            mesh = pyvista.read(path)
        except UserWarning:
            raise SettingError("VTK reports an error in it") from None
    if not hasattr(mesh, "point_data"):
        raise SettingError("it has several blocks: save one of them")
    if not len(mesh.point_data):
        mesh = mesh.cell_data_to_point_data()
    vectors, is_curl, lines = _vectors(path, mesh.point_data, attribute)
    if isinstance(mesh, pyvista.ImageData | pyvista.RectilinearGrid):
        axes = [np.asarray(axis, float) for axis in (mesh.x, mesh.y, mesh.z)]
        if isinstance(mesh, pyvista.ImageData):
            axes = [o + s * np.arange(n) for o, s, n in zip(mesh.origin, mesh.spacing, mesh.dimensions, strict=True)]
        field = vectors.reshape(*mesh.dimensions[::-1], 3).transpose(2, 1, 0, 3)
        extra = {
            n: np.asarray(mesh.point_data[n]).reshape(mesh.dimensions[::-1]).transpose(2, 1, 0)
            for n in mesh.point_data.keys()
            if n.lower() in (*_SOLIDS, *_MASKS)
        }
        return _resample_evenly(field, axes, extra, is_curl, lines)

    mesh.point_data[_SAMPLED] = _blank(vectors, mesh.point_data)

    def sample(places: np.ndarray) -> np.ndarray:
        found = pyvista.PolyData(places).sample(mesh)
        values = np.asarray(found.point_data[_SAMPLED], float)
        values[np.asarray(found.point_data["vtkValidPointMask"]) == 0] = np.nan
        return values

    low, high = np.array(mesh.bounds).reshape(3, 2).T
    return SampledFlow(low, high, sample, is_curl, lines)


def _by_meshio(path: Path, attribute: str) -> SampledFlow:
    meshio = _library("meshio", f"{path.suffix} is")
    from scipy.interpolate import LinearNDInterpolator

    mesh = meshio.read(path)
    data, points = mesh.point_data, mesh.points
    if not data:
        data = {name: np.concatenate(parts) for name, parts in mesh.cell_data.items()}
        points = np.concatenate([mesh.points[block.data].mean(axis=1) for block in mesh.cells])
    vectors, is_curl, warnings = _vectors(path, data, attribute)
    sample = LinearNDInterpolator(points, _blank(vectors, data))
    warnings += ("the flow is taken between all points of the mesh: with pyvista installed, its cells bound it",)
    return SampledFlow(points.min(axis=0), points.max(axis=0), sample, is_curl, warnings)


def _vectors(path: Path, data: Any, attribute: str) -> tuple[np.ndarray, bool, tuple[str, ...]]:
    """(n, 3) vectors of a mesh's points, and the rest of :func:`choose_flow`."""
    arrays = {name: np.asarray(data[name]) for name in data.keys()}
    whole = [n for n, a in arrays.items() if a.ndim == 2 and a.shape[1] == 3]
    parts = [n for n, a in arrays.items() if a.ndim == 1]
    chosen, is_curl, warnings = choose_flow(path, whole, parts, attribute)
    return np.column_stack([arrays[name] for name in chosen]).astype(float), is_curl, warnings


def _blank(vectors: np.ndarray, data: Any) -> np.ndarray:
    """(n, 3) vectors of a mesh's points, nan in obstacles and outside masks."""
    solid = np.zeros(len(vectors), bool)
    for name in data.keys():
        if name.lower() in (*_SOLIDS, *_MASKS):
            values = np.asarray(data[name]).reshape(len(vectors), -1)[:, 0]
            solid |= (values != 0) if name.lower() in _SOLIDS else (values == 0)
    return np.where(solid[:, None], np.nan, vectors)


def _library(name: str, what: str) -> ModuleType:
    """An optional module."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise SettingError(f"{what} read by {name}, which is not here: {_PIP}") from None
