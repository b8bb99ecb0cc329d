# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows of other programs: VTK's images (.vti), read here, files for pyvista or meshio where they are installed, and
NetCDF and HDF5 (flow_arrays.py).

.vti may be text, base64, or appended raw, compressed by zlib or not. Flows on other meshes of VTK are sampled on a
grid, whose nodes outside the mesh count as solid.
"""

import importlib
import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from ..errors import SettingError
from ..geometry.grid import Grid, box_grid
from ..memory import at_most
from .border import TEXT_BYTES, border, check_promise, read_bytes
from .flow_arrays import library, read_arrays
from .regular_flows import MASKS, PLANE, SOLIDS, GridFlow, grid_flow, is_solid, resample_evenly
from .tets import vtu_array, vtu_root
from .volumes import SOUND_BYTES, SOUND_RATIO, choose_flow, component_names

IMAGE, ARRAYS, MESHES = (".vti",), (".nc", ".h5", ".hdf5"), (".vts", ".vtr", ".vtk", ".vtu")
# Elements of the arrays of points, and of cells.
_KINDS = ("PointData", "CellData")
# Name of the vectors that are sampled on a mesh.
_SAMPLED = "synch flow"


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
                return read_arrays(self.path, self.attribute)
            return _read_mesh(self.path, self.attribute)


# Images of VTK


def _read_image(path: Path, attribute: str) -> GridFlow:
    """Read a .vti file: the first vectors at points, or else in cells, on axes that are not turned."""
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
    every = {kind: {str(a.get("Name")): a for a in pieces[0].iterfind(f"{kind}/DataArray")} for kind in _KINDS}
    sizes_of = {
        kind: {name: int(array.get("NumberOfComponents") or 1) for name, array in arrays.items()}
        for kind, arrays in every.items()
    }
    kind = next(
        (kind for kind in _KINDS if _has_vectors(sizes_of[kind])), max(_KINDS, key=lambda kind: len(every[kind]))
    )
    found, sizes = every[kind], sizes_of[kind]
    if kind == "CellData":  # the middles of cells are a grid of their own
        shape = shape - 1
    origin = _numbers(image, "Origin", 3, (0, 0, 0)) + (first + 0.5 * (kind == "CellData")) * spacing
    if (shape < 2).any():
        raise SettingError(PLANE if (shape > 0).all() else f"its extent is {extent.tolist()}: export a flow in space")
    count = math.prod(shape.tolist())
    chosen, is_curl, warnings = choose_flow(
        path, [n for n in found if sizes[n] == 3], [n for n in found if sizes[n] == 1], attribute
    )
    extra = [name for name in found if name.lower() in (*SOLIDS, *MASKS) and sizes[name] == 1]
    check_promise(path, 16 * count * sum(sizes[name] for name in (*chosen, *extra)))
    arrays = {n: vtu_array(root, appended, found[n], count * sizes[n]) for n in (*chosen, *extra)}
    # The first axis counts fastest.
    arrays = {n: a.reshape(*shape[::-1], sizes[n]).transpose(2, 1, 0, 3) for n, a in arrays.items()}
    vectors = np.concatenate([arrays[name] for name in chosen], axis=3)
    return grid_flow(vectors, spacing, origin, {n: arrays[n][..., 0] for n in extra}, is_curl, warnings)


def _has_vectors(sizes: dict[str, int]) -> bool:
    """Whether arrays, of ``sizes`` numbers for each point by their names, hold vectors or the components of one."""
    return 3 in sizes.values() or bool(component_names([name for name, size in sizes.items() if size == 1]))


def _numbers(element: Element, name: str, count: int, default: Sequence[float] | None = None) -> np.ndarray:
    """The finite numbers of an attribute of XML, ``count`` of them."""
    text = element.get(name)
    words = default if text is None and default is not None else (text or "").split()
    numbers = np.array([float(word) for word in words])
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise SettingError(f"its {name} is {text!r}: give {count} numbers")
    return numbers


# Meshes of VTK


def _read_mesh(path: Path, attribute: str) -> GridFlow | SampledFlow:
    with at_most(SOUND_BYTES + SOUND_RATIO * path.stat().st_size):
        try:
            pyvista = importlib.import_module("pyvista")
        except ImportError:
            return _by_meshio(path, attribute)
        return _by_pyvista(pyvista, path, attribute)


def _by_pyvista(pyvista: ModuleType, path: Path, attribute: str) -> GridFlow | SampledFlow:
    """Read a VTK file; images and rectilinear grids as they are, other meshes as a function to sample."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.simplefilter("error", UserWarning)  # pyvista's form of what VTK reports
        try:
            mesh = pyvista.read(path)
        except UserWarning:
            raise SettingError("VTK reports an error in it") from None
    if not hasattr(mesh, "point_data"):
        raise SettingError("it has several blocks: save one of them")
    if not _has_vectors({name: math.prod(mesh.point_data[name].shape[1:]) for name in mesh.point_data.keys()}):
        mesh = mesh.cell_data_to_point_data()
    vectors, is_curl, lines = _vectors(path, mesh.point_data, attribute)
    if isinstance(mesh, pyvista.ImageData | pyvista.RectilinearGrid):
        axes = [np.asarray(axis, float) for axis in (mesh.x, mesh.y, mesh.z)]
        if isinstance(mesh, pyvista.ImageData):
            axes = [o + s * np.arange(n) for o, s, n in zip(mesh.origin, mesh.spacing, mesh.dimensions, strict=True)]
        field = vectors.reshape(*mesh.dimensions[::-1], 3).transpose(2, 1, 0, 3)
        extra = {
            n: (np.asarray(mesh.point_data[n]).reshape(mesh.dimensions[::-1]).transpose(2, 1, 0), axes)
            for n in mesh.point_data.keys()
            if n.lower() in (*SOLIDS, *MASKS)
        }
        return resample_evenly([(field[..., k], axes) for k in range(3)], extra, is_curl, lines)

    mesh.point_data[_SAMPLED] = _blank(vectors, mesh.point_data)

    def sample(places: np.ndarray) -> np.ndarray:
        found = pyvista.PolyData(places).sample(mesh)
        values = np.asarray(found.point_data[_SAMPLED], float)
        values[np.asarray(found.point_data["vtkValidPointMask"]) == 0] = np.nan
        return values

    low, high = np.array(mesh.bounds).reshape(3, 2).T
    return SampledFlow(low, high, sample, is_curl, lines)


def _by_meshio(path: Path, attribute: str) -> SampledFlow:
    """Read a mesh without pyvista; the flow is interpolated between all its points."""
    meshio = library("meshio", f"{path.suffix} is")
    from scipy.interpolate import LinearNDInterpolator

    mesh = meshio.read(path)
    data, points = mesh.point_data, mesh.points
    if not _has_vectors({name: math.prod(array.shape[1:]) for name, array in data.items()}):
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
        if name.lower() in (*SOLIDS, *MASKS):
            values = np.asarray(data[name]).reshape(len(vectors), -1)[:, 0]
            solid |= is_solid(name, values)
    return np.where(solid[:, None], np.nan, vectors)
