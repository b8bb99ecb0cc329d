# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of a small random flow as other programs write them."""

import struct
import zlib
from base64 import b64encode

import numpy as np
import pytest
from scipy.io import netcdf_file

SHAPE, SPACING, ORIGIN = (5, 6, 7), (0.5, 0.25, 0.125), (1.0, 2.0, -3.0)
VELOCITY = np.random.default_rng(0).standard_normal((*SHAPE, 3))
AXES = {axis: o + h * np.arange(n) for axis, o, h, n in zip("xyz", ORIGIN, SPACING, SHAPE, strict=True)}
UVW = {name: VELOCITY[..., k].transpose(2, 1, 0) for k, name in enumerate("uvw")}


def fortran(values):
    """In VTK's order: the first axis fastest."""
    return values.transpose(2, 1, 0, 3).ravel() if values.ndim == 4 else values.transpose(2, 1, 0).ravel()


def vti(path, arrays, kind="ascii", where="PointData", shape=SHAPE, spacing=SPACING, origin=ORIGIN):
    """Write arrays as an image: "ascii", "binary", "zlib" or "raw"."""
    packed, bodies, offset = [], b"", 0
    for name, values in arrays.items():
        flat = np.ascontiguousarray(fortran(values))
        data = flat.astype("<f8").tobytes()
        count = values.shape[3] if values.ndim == 4 else 1
        head = f'<DataArray type="Float64" Name="{name}" NumberOfComponents="{count}" '
        if kind == "ascii":
            packed.append(head + 'format="ascii">' + " ".join(map(repr, flat.tolist())) + "</DataArray>")
        elif kind == "raw":
            packed.append(head + f'format="appended" offset="{offset}"/>')
            bodies += struct.pack("<I", len(data)) + data
            offset = len(bodies)
        elif kind == "binary":
            text = b64encode(struct.pack("<I", len(data)) + data).decode()
            packed.append(head + f'format="binary">{text}</DataArray>')
        else:
            body = zlib.compress(data)
            text = b64encode(struct.pack("<IIII", 1, len(data), 0, len(body))).decode() + b64encode(body).decode()
            packed.append(head + f'format="binary">{text}</DataArray>')
    extent = " ".join(f"0 {n - (where == 'PointData')}" for n in shape)
    compressor = ' compressor="vtkZLibDataCompressor"' if kind == "zlib" else ""
    text = (
        f'<?xml version="1.0"?><VTKFile type="ImageData" version="1.0" byte_order="LittleEndian"{compressor}>'
        f'<ImageData WholeExtent="{extent}" Origin="{" ".join(map(str, origin))}" '
        f'Spacing="{" ".join(map(str, spacing))}"><Piece Extent="{extent}"><{where}>{"".join(packed)}</{where}>'
        "</Piece></ImageData>"
    ).encode()
    if kind == "raw":
        text += b'<AppendedData encoding="raw">_' + bodies + b"</AppendedData>"
    path.write_bytes(text + b"</VTKFile>")
    return path


def netcdf(path, variables, coordinates, steps=0, axes=None):
    """Write variables in the order (time,) z, y, x, or of the axes of each, with NetCDF 3."""
    with netcdf_file(path, "w") as file:
        for name, values in coordinates.items():
            file.createDimension(name, len(values))
            file.createVariable(name, "f8", (name,))[:] = values
        if steps:
            file.createDimension("time", steps)
        for name, values in variables.items():
            along = (axes or {}).get(name, ("z", "y", "x"))
            for axis, count in zip(along, values.shape[bool(steps) :], strict=True):
                if axis not in file.dimensions:
                    file.createDimension(axis, count)
            file.createVariable(name, "f8", ("time",) * bool(steps) + tuple(along))[:] = values
    return path


def hdf5(path):
    """Write the flow as databases of turbulence do, by h5py."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        file.create_dataset("Velocity_0001", data=VELOCITY.transpose(2, 1, 0, 3).astype("f4"))
        for axis, values in AXES.items():
            file.create_dataset(f"{axis}coor", data=values)
    return path


def vtk_mesh(path):
    """Write the flow on the mesh of VTK that a suffix stands for, by pyvista."""
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.ImageData(dimensions=SHAPE, spacing=SPACING, origin=ORIGIN)
    mesh.point_data["velocity"] = fortran(VELOCITY).reshape(-1, 3)
    kinds = {".vtr": mesh.cast_to_rectilinear_grid, ".vts": mesh.cast_to_structured_grid}
    kinds |= {".vtu": mesh.cast_to_unstructured_grid}
    kinds.get(path.suffix, lambda: mesh)().save(path)
    return path
