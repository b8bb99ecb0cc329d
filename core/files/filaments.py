# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortex filaments as text: a table with a row for each point, or polylines as VTK has them, in one piece each.

Closed filaments come back to their first point; those that go around a periodic box end a box further on.
"""

import numpy as np

from .digits import DIGITS, number_format

# Of each filament, in the order of the columns: what it is called, and its kind in VTK.
_VALUES = (
    ("circulation", "Float64"),
    ("length", "Float64"),
    ("writhe", "Float64"),
    ("closed", "Int32"),
    ("winding_x", "Int32"),
    ("winding_y", "Int32"),
    ("winding_z", "Int32"),
)
# Of what is not a place.
_FORM = f"%.{DIGITS}g"


def table_of(lines, winding):
    """Text of a .csv file, a row for each point.

    Parameters
    ----------
    lines : list of Filament
    winding : Linked of these, None where it is not known
    """
    rows = ["filament,x,y,z," + ",".join(name for name, _ in _VALUES)]
    form = ",".join(3 * [number_format(_points(lines))] + len(_VALUES) * [_FORM])
    for number, (line, values) in enumerate(zip(lines, _values(lines, winding), strict=True)):
        rows += [f"{number}," + form % (*point, *values) for point in line.whole]
    return "\n".join(rows) + "\n"


def polydata_of(lines, winding):
    """Text of a .vtp file, a polyline and its values for each filament; parameters as :func:`table_of`."""
    sizes, values = [len(line.whole) for line in lines], _values(lines, winding)
    total = sum(sizes)
    parts = [
        '<?xml version="1.0"?>',
        '<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian">',
        f'<PolyData><Piece NumberOfPoints="{total}" NumberOfVerts="0" NumberOfLines="{len(lines)}" '
        'NumberOfStrips="0" NumberOfPolys="0">',
        '<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">',
        *_places(lines),
        "</DataArray></Points>",
        '<Lines><DataArray type="Int32" Name="connectivity" format="ascii">',
        " ".join(map(str, range(total))),
        '</DataArray><DataArray type="Int32" Name="offsets" format="ascii">',
        " ".join(map(str, np.cumsum(sizes, dtype=int).tolist())),
        "</DataArray></Lines>",
        "<CellData>",
    ]
    for (name, kind), column in zip(_VALUES, _columns(values), strict=True):
        parts += [f'<DataArray type="{kind}" Name="{name}" format="ascii">', _row(column), "</DataArray>"]
    return "\n".join([*parts, "</CellData></Piece></PolyData></VTKFile>"]) + "\n"


def legacy_of(lines, winding):
    """Text of a .vtk file, the same in VTK's older form; parameters as :func:`table_of`."""
    sizes, values = [len(line.whole) for line in lines], _values(lines, winding)
    firsts = np.cumsum(sizes, dtype=int) - sizes
    parts = [
        "# vtk DataFile Version 3.0",
        "vortex filaments",
        "ASCII",
        "DATASET POLYDATA",
        f"POINTS {sum(sizes)} double",
        *_places(lines),
        f"LINES {len(lines)} {len(lines) + sum(sizes)}",
        *(_row([size, *range(first, first + size)]) for first, size in zip(firsts, sizes, strict=True)),
        f"CELL_DATA {len(lines)}",
    ]
    for (name, kind), column in zip(_VALUES, _columns(values), strict=True):
        parts += [
            f"SCALARS {name} {'int' if kind == 'Int32' else 'double'} 1",
            "LOOKUP_TABLE default",
            _row(column),
        ]
    return "\n".join(parts) + "\n"


def _values(lines, winding):
    """List of the values of each filament; nan for a writhe that is not known."""
    writhes = np.full(len(lines), np.nan)
    if winding is not None:
        writhes[list(winding.loops)] = winding.writhes
    return [
        (line.strength, line.length, twist, int(line.is_closed), *line.winding)
        for line, twist in zip(lines, writhes, strict=True)
    ]


def _columns(values):
    """The values of each kind."""
    return list(zip(*values, strict=True)) or [()] * len(_VALUES)


def _points(lines):
    """(n, 3) points of all filaments."""
    return np.vstack([np.empty((0, 3)), *(line.whole for line in lines)])


def _places(lines):
    """A row of text for each point."""
    points = _points(lines)
    form = " ".join(3 * [number_format(points)])
    return [form % tuple(point) for point in points]


def _row(values):
    return " ".join(_FORM % value for value in values)


WRITERS = {".csv": table_of, ".vtp": polydata_of, ".vtk": legacy_of}
