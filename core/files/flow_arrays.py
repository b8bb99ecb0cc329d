# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows in NetCDF and HDF5: version 3 of NetCDF by SciPy, version 4 and HDF5 by h5py.

The axes of arrays are those that their dimensions are named after, or where these have no such names that coordinates
of their own lengths belong to; otherwise z, y, x, as usual in these formats, or x, y, z where the flow has less
divergence so.
"""

import importlib
import math
import re
from contextlib import ExitStack
from io import BytesIO
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from scipy.io import netcdf_file

from ..errors import SettingError
from .border import check_promise
from .regular_flows import MASKS, PLANE, SOLIDS, GridFlow, Placed, resample_evenly
from .volumes import ROTATIONS, USUAL, choose_flow

# Beginnings of the names of dimensions along each axis and along time, and names of their coordinates in one file.
_DIMENSIONS = (
    ("x", "lon", "west_east", "ni", "nx"),
    ("y", "lat", "south_north", "eta", "nj", "ny"),
    ("z", "lev", "depth", "height", "alt", "bottom_top", "plev", "s_", "nk", "nz"),
)
_TIMES, _DEGREES = ("time", "date", "month", "record"), ("lon", "lat")
_COORDINATES = (
    ("x", "xcoor", "lon", "longitude"),
    ("y", "ycoor", "lat", "latitude"),
    ("z", "zcoor", "lev", "level", "depth", "height", "altitude", "plev"),
)
_PIP = "install it for Python (pip install synch-fields[flows]), or save the flow as .vti or .npz"


def read_arrays(path: Path, attribute: str) -> GridFlow:
    """Read the flow in a NetCDF or HDF5 file; ``attribute`` names its array, or is "" to find it."""
    with ExitStack() as stack:
        with path.open("rb") as head:
            is_classic = head.read(3) == b"CDF"
        if is_classic:
            # SciPy believes the sizes in a header. Given the bytes, it cannot read beyond the end of the file.
            check_promise(path, path.stat().st_size)
            file = stack.enter_context(netcdf_file(BytesIO(path.read_bytes()), maskandscale=True))
            arrays = dict(file.variables)
        else:
            h5py = library("h5py", "NetCDF of version 4 and HDF5 are")
            file = stack.enter_context(h5py.File(path, "r"))
            names: list[str] = []
            file.visit(names.append)
            names = [name for name in names if hasattr(file[name], "shape") and not _is_bare_dimension(file[name])]
            bare = [_bare(name, file[name].shape) for name in names]
            shorts = [short if bare.count(short) == 1 else name for name, short in zip(names, bare, strict=True)]
            arrays = {short: file[name] for name, short in zip(names, shorts, strict=True)}
        return _flow_of_arrays(path, arrays, attribute)


def _is_bare_dimension(array: Any) -> bool:
    """Whether NetCDF wrote an array for a dimension alone, which has a length and no coordinates."""
    note = array.attrs.get("NAME", b"")
    return isinstance(note, bytes) and note.startswith(b"This is a netCDF dimension but not a netCDF variable")


def _bare(name: str, shape: tuple[int, ...]) -> str:
    """The name of an array without its groups and a frame's number at its end; B/x, B/y and B/z keep their group."""
    parts = name.split("/")
    is_component = len(shape) > 1 and parts[-1] in ("x", "y", "z")
    return "/".join(parts[-2:]) if is_component else re.sub(r"[_-]?\d+$", "", parts[-1]) or name


def _flow_of_arrays(path: Path, arrays: dict[str, Any], attribute: str) -> GridFlow:
    """Choose the arrays of the flow by their names and shapes, and resample them on an even grid; SettingError names
    what is missing."""
    component = {n: axis for n, a in arrays.items() if (axis := _component_axis(n, a.shape)) is not None}
    numbers = [n for n, a in arrays.items() if len(a.shape) in (2, 3, 4) and n not in component]
    chosen, is_curl, warnings = choose_flow(path, list(component), numbers, attribute, may_be_level=True)
    first, axis = arrays[chosen[0]], component.get(chosen[0])
    space = _space(first, axis)
    names = [_dimensions(first)[dim] for dim in space]
    shape = tuple(first.shape[dim] for dim in space)
    if len(shape) < 3 or min(shape) < 2 or any(_begins(name, _TIMES) for name in names):
        raise SettingError(PLANE)
    steps = first.shape[: space[0] - (axis is not None and axis < space[0])]
    if any(count != 1 for count in steps):
        warnings += (f"of {steps[0]} times the first one is shown: save the others as files of their own",)
    if any(_begins(name, _DEGREES) for name in names):
        warnings += ("x, y and z are longitude, latitude and level as the file counts them, and so are circulations",)
    elif not (any(name in arrays for name in names) or any(_axis(arrays, axis) is not None for axis in _COORDINATES)):
        if "gridSpacing" not in _grid_of(first) and _own_spacing(arrays) is None:
            warnings += ("distances are counted in nodes, as the file has no coordinates along x, y and z",)
    extra = [n for n in numbers if n.lower() in (*SOLIDS, *MASKS) and arrays[n].shape[-3:] == shape]
    known = _order(first, arrays, space)
    orders = ([2, 1, 0], [0, 1, 2]) if known is None else (known,)  # usually z, y, x
    check_promise(path, 24 * math.prod(shape) * (3 + len(extra)) * len(orders))
    found = [(_components([arrays[name] for name in chosen], arrays, order, axis), order) for order in orders]
    components, order = found[0] if len(found) == 1 else min(found, key=lambda one: _divergence(one[0]))
    return resample_evenly(components, {n: _placed(arrays[n], arrays, order) for n in extra}, is_curl, warnings)


def _components(chosen: list[Any], arrays: dict[str, Any], order: list[int], axis: int | None) -> list[Placed]:
    """Three components of an array of vectors, whose axis of components is given, or of an array for each, with 0 for a
    third one; SettingError where their sizes do not fit."""
    if axis is not None:
        values, places = _placed(chosen[0], arrays, order, axis)
        return [(values[..., k], places) for k in range(3)]
    components = [_placed(array, arrays, order) for array in chosen]
    for axis, (values, places) in enumerate(components):
        other_values, other_places = components[axis - 1]
        is_longer = values.shape[axis] == other_values.shape[axis] + 1
        if is_longer and places[axis][0] == other_places[axis][0]:  # on the sides of cells, without coordinates
            places[axis] = places[axis] - 0.5 * (places[axis][1] - places[axis][0])
    components += [(0 * components[0][0], components[0][1])] * (3 - len(components))
    sizes = np.array([part.shape for part, _ in components])
    if (np.ptp(sizes, axis=0) > 1).any():
        raise SettingError("its components are on grids of different sizes: put them on one")
    return components


def _divergence(components: list[Placed]) -> float:
    """The sum of a flow's absolute divergence over the nodes that all components have."""
    shape = np.min([values.shape for values, _ in components], axis=0)
    within = tuple(map(slice, shape))
    with np.errstate(all="ignore"):  # coordinates that do not increase are refused later
        slopes = [
            np.gradient(values[within], places[axis][: shape[axis]], axis=axis)
            for axis, (values, places) in enumerate(components)
        ]
    return float(np.nansum(np.abs(np.sum(slopes, axis=0))))


def _component_axis(name: str, shape: tuple[int, ...]) -> int | None:
    """The axis of an array along which its vectors' components lie, the last one or that before x, y and z; None for an
    array of numbers."""
    if len(shape) in (3, 4, 5) and shape[-1] == 3:
        return len(shape) - 1
    is_vector = len(name) > 1 and name.lower() in (*USUAL, *ROTATIONS)  # u and v are components, at three times or more
    return len(shape) - 4 if is_vector and len(shape) in (4, 5) and shape[-4] == 3 else None


def _space(array: Any, component: int | None) -> list[int]:
    """The last three axes of an array, without that of components."""
    return [axis for axis in range(len(array.shape)) if axis != component][-3:]


def _order(array: Any, arrays: dict[str, Any], space: list[int]) -> list[int] | None:
    """Which of an array's axes in space are x, y and z, by the names of its dimensions or the lengths of coordinates;
    None where neither does."""
    names, shape = [_dimensions(array)[dim] for dim in space], tuple(array.shape[dim] for dim in space)
    order = [next((k for k, name in enumerate(names) if _begins(name, begins)), -1) for begins in _DIMENSIONS]
    if sorted(order) == [0, 1, 2]:
        return order
    coordinates = [_axis(arrays, wanted) for wanted in _COORDINATES]
    lengths = tuple(None if axis is None else len(axis) for axis in coordinates)
    if shape == shape[::-1]:
        return None
    return {shape: [0, 1, 2], shape[::-1]: [2, 1, 0]}.get(lengths)


def _placed(array: Any, arrays: dict[str, Any], order: list[int], component: int | None = None) -> Placed:
    """The numbers of the first time step along x, y, z, and components behind these, with their coordinates."""
    space = _space(array, component)
    leading = space[0] - (component is not None and component < space[0])
    names, shape = [_dimensions(array)[dim] for dim in space], tuple(array.shape[dim] for dim in space)
    values = _values(array, leading)
    if component is not None:
        values = np.moveaxis(values, component - leading, -1)
    values = np.moveaxis(values, order, [0, 1, 2])
    of_grid = _grid_of(array)
    own_spacing = _own_spacing(arrays)
    spacing = of_grid.get("gridSpacing", np.ones(3) if own_spacing is None else own_spacing[np.argsort(order)])
    origin = of_grid.get("gridGlobalOffset", np.zeros(3))
    aside = np.ravel(getattr(array, "attrs", {}).get("position", ()))  # of openPMD, in spacings: staggered components
    aside = aside if len(aside) == 3 else np.zeros(3)
    places = []
    for axis, number in enumerate(order):
        own, usual = arrays.get(names[number]), _axis(arrays, _COORDINATES[axis])
        given = [along for along in (own, usual) if along is not None and along.shape == (shape[number],)]
        even = origin[number] + spacing[number] * (aside[number] + np.arange(shape[number]))
        places.append(_values(given[0], 0) if given else even)
    return values, places


def _own_spacing(arrays: dict[str, Any]) -> np.ndarray | None:
    """(3,) distances of nodes along x, y and z, if the file has an array of them; otherwise None."""
    found = next((arrays[name] for name in ("spacing", "dx") if name in arrays), None)
    if found is None or math.prod(found.shape) not in (1, 3):
        return None
    numbers = np.asarray(found[...], float)
    return np.broadcast_to(numbers.ravel(), 3) if np.isfinite(numbers).all() and (numbers > 0).all() else None


def _grid_of(array: Any) -> Any:
    """The attributes by which openPMD places an array's nodes, if there are any."""
    return array.parent.attrs if hasattr(array, "parent") else {}


def _dimensions(array: Any) -> list[str]:
    """Lower-case names of an array's dimensions, empty where they have none."""
    names = getattr(array, "dimensions", None)  # of NetCDF 3
    if names is None:
        names = [dim[0].name.rsplit("/", 1)[-1] if len(dim) else dim.label for dim in array.dims]
        labels = np.ravel(array.parent.attrs.get("axisLabels", ()))  # of openPMD
        if len(labels) == len(names):
            names = [label.decode() if isinstance(label, bytes) else str(label) for label in labels]
    return list(names)


def _begins(name: str, beginnings: tuple[str, ...]) -> bool:
    return name.lower().startswith(beginnings)


def _values(array: Any, leading: int) -> np.ndarray:
    """The numbers of the first time step of an array, nan where it has none."""
    values = array[(0,) * leading] if leading else array[:]
    scale = getattr(array, "attrs", {})
    empty = scale.get("_FillValue", scale.get("missing_value"))
    values = np.ma.filled(np.ma.asarray(values, float), np.nan)
    if empty is not None:
        values = np.where(values == np.ravel(empty)[0], np.nan, values)
    return values * np.ravel(scale.get("scale_factor", 1.0))[0] + np.ravel(scale.get("add_offset", 0.0))[0]


def _axis(arrays: dict[str, Any], names: tuple[str, ...]) -> np.ndarray | None:
    """The coordinates along an axis, None where the file has none."""
    for name, array in arrays.items():
        if name.lower() in names and len(array.shape) == 1:
            return _values(array, 0)
    return None


def library(name: str, what: str) -> ModuleType:
    """An optional module."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise SettingError(f"{what} read by {name}, which is not here: {_PIP}") from None
