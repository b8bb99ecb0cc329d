# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortex filaments and tubes as text for other programs: tables, VTK's polylines and polygons, PLY and OBJ.

Each filament is one piece: a closed one returns to its first point, and one that goes around a periodic box ends a box
further. VTK's older form is an unstructured grid of segments, each with the values of its filament, and in PLY a
segment is a face of two corners: so both pyvista and meshio read them (meshio has no .vtp, and reads only points of
.obj lines).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ..extract.vortices.filaments import Filament
from ..extract.vortices.linking_numbers import Linked
from ..extract.vortices.tubes import Tubes
from .digits import DIGITS, number_format

# Columns of values of a filament: name, and kind in VTK.
_VALUES = (
    ("circulation", "Float64"),
    ("length", "Float64"),
    ("writhe", "Float64"),
    ("vorticity_share", "Float64"),
    ("closed", "Int32"),
    ("winding_x", "Int32"),
    ("winding_y", "Int32"),
    ("winding_z", "Int32"),
)
_FORM = f"%.{DIGITS}g"
# Kinds of cells of VTK.
_SEGMENT, _TRIANGLE = 3, 5


@dataclass(frozen=True)
class VortexShape:
    """Filaments or tubes to write.

    Attributes
    ----------
    points : (n, 3)
    cells : numbers of the points along each filament, or around each triangle
    are_lines : whether the cells are filaments
    values : of each cell, by name and kind in VTK
    colors : (n, 3) red, green and blue of the points from 0 to 1, or None
    """

    points: np.ndarray
    cells: list[list[int]]
    are_lines: bool
    values: dict[tuple[str, str], list[float]] = field(default_factory=dict)
    colors: np.ndarray | None = None

    @property
    def segments(self) -> "VortexShape":
        """The shape with a cell for each segment of a filament, and the filaments' numbers."""
        if not self.are_lines:
            return self
        counts = [len(cell) - 1 for cell in self.cells]
        columns = self.values | {("filament", "Int32"): list(range(len(counts)))}
        values = {name: np.repeat(column, counts).tolist() for name, column in columns.items()}
        pairs = [list(pair) for cell in self.cells for pair in pairwise(cell)]
        return VortexShape(self.points, pairs, True, values, self.colors)


def filament_shape(lines: Sequence[Filament], winding: Linked | None) -> VortexShape:
    """The shape of filaments; their winding is None if unknown."""
    ends = np.cumsum([0, *(len(line.whole) for line in lines)]).tolist()
    cells = [list(range(begin, end)) for begin, end in pairwise(ends)]
    columns = zip(*_values(lines, winding), strict=True) if lines else [()] * len(_VALUES)
    values = {name: list(column) for name, column in zip(_VALUES, columns, strict=True)}
    return VortexShape(_points(lines), cells, True, values)


def tube_shape(tubes: Tubes) -> VortexShape:
    """The shape of tubes, in the colours of the sphere."""
    return VortexShape(tubes.vertices, tubes.triangles.tolist(), False, {}, 0.5 + 0.5 * tubes.sphere)


def table_of(lines: Sequence[Filament], winding: Linked | None) -> str:
    """Text of a .csv file, a row for each point."""
    rows = ["filament,x,y,z," + ",".join(name for name, _ in _VALUES)]
    form = ",".join(3 * [number_format(_points(lines))] + len(_VALUES) * [_FORM])
    for number, (line, values) in enumerate(zip(lines, _values(lines, winding), strict=True)):
        rows += [f"{number}," + form % (*point, *values) for point in line.whole]
    return "\n".join(rows) + "\n"


def polydata_of(shape: VortexShape) -> str:
    """Text of a .vtp file."""
    name, count = ("Lines" if shape.are_lines else "Polys"), len(shape.cells)
    lines, polygons = (count, 0) if shape.are_lines else (0, count)
    ends = np.cumsum([len(cell) for cell in shape.cells], dtype=int).tolist()
    parts = [
        '<?xml version="1.0"?>',
        '<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian">',
        f'<PolyData><Piece NumberOfPoints="{len(shape.points)}" NumberOfVerts="0" NumberOfLines="{lines}" '
        f'NumberOfStrips="0" NumberOfPolys="{polygons}">',
        '<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">',
        *_rows(shape.points),
        f'</DataArray></Points><{name}><DataArray type="Int32" Name="connectivity" format="ascii">',
        *(" ".join(map(str, cell)) for cell in shape.cells),
        '</DataArray><DataArray type="Int32" Name="offsets" format="ascii">',
        " ".join(map(str, ends)),
        f"</DataArray></{name}>",
    ]
    if shape.colors is not None:
        head = '<PointData><DataArray type="UInt8" Name="color" NumberOfComponents="3" format="ascii">'
        parts += [head, *_bytes(shape.colors), "</DataArray></PointData>"]
    parts.append("<CellData>")
    for (called, kind), column in shape.values.items():
        parts += [f'<DataArray type="{kind}" Name="{called}" format="ascii">', _row(column), "</DataArray>"]
    return "\n".join([*parts, "</CellData></Piece></PolyData></VTKFile>"]) + "\n"


def legacy_of(shape: VortexShape) -> str:
    """Text of a .vtk file, VTK's older form."""
    shape = shape.segments
    count, kind = len(shape.cells), _SEGMENT if shape.are_lines else _TRIANGLE
    parts = [
        "# vtk DataFile Version 3.0",
        "vortices",
        "ASCII",
        "DATASET UNSTRUCTURED_GRID",
        f"POINTS {len(shape.points)} double",
        *_rows(shape.points),
        f"CELLS {count} {count + sum(map(len, shape.cells))}",
        *(" ".join(map(str, [len(cell), *cell])) for cell in shape.cells),
        f"CELL_TYPES {count}",
        *[str(kind)] * count,
    ]
    if shape.values:
        parts.append(f"CELL_DATA {count}")
    for (called, number), column in shape.values.items():
        head = f"SCALARS {called} {'int' if number == 'Int32' else 'double'} 1"
        parts += [head, "LOOKUP_TABLE default", _row(column)]
    if shape.colors is not None:
        parts += [f"POINT_DATA {len(shape.points)}", "VECTORS color double", *_rows(shape.colors)]
    return "\n".join(parts) + "\n"


def ply_of(shape: VortexShape) -> str:
    """Text of a .ply file; each piece of a filament is a face of two corners."""
    cells = shape.segments.cells
    places = _rows(shape.points)
    colors = [""] * len(places) if shape.colors is None else [f" {color}" for color in _bytes(shape.colors)]
    channels = [] if shape.colors is None else [f"property uchar {name}" for name in ("red", "green", "blue")]
    parts = [
        *("ply", "format ascii 1.0", f"element vertex {len(places)}"),
        *(f"property double {axis}" for axis in "xyz"),
        *channels,
        *(f"element face {len(cells)}", "property list uchar int vertex_indices", "end_header"),
        *(place + color for place, color in zip(places, colors, strict=True)),
        *(" ".join(map(str, [len(cell), *cell])) for cell in cells),
    ]
    return "\n".join(parts) + "\n"


def obj_of(shape: VortexShape) -> str:
    """Text of an .obj file, an element for each cell."""
    kind = "l" if shape.are_lines else "f"
    cells = (" ".join([kind, *(str(1 + number) for number in cell)]) for cell in shape.cells)
    return "\n".join([*(f"v {row}" for row in _rows(shape.points)), *cells]) + "\n"


def _values(lines: Sequence[Filament], winding: Linked | None) -> list[tuple[float, ...]]:
    """The values of each filament; nan for a writhe that is not known."""
    writhes = np.full(len(lines), np.nan) if winding is None else winding.all_writhes
    return [
        (line.strength, line.length, twist, line.share, int(line.is_closed), *line.winding)
        for line, twist in zip(lines, writhes, strict=True)
    ]


def _points(lines: Sequence[Filament]) -> np.ndarray:
    """(n, 3) points of all filaments."""
    return np.vstack([np.empty((0, 3)), *(line.whole for line in lines)])


def _rows(points: np.ndarray) -> list[str]:
    """A row of text for each point."""
    form = " ".join(3 * [number_format(points)])
    return [form % tuple(point) for point in points]


def _bytes(colors: np.ndarray) -> list[str]:
    """A row of text for each colour, in whole numbers up to 255."""
    return [" ".join(map(str, color)) for color in np.rint(255 * np.clip(colors, 0, 1)).astype(int).tolist()]


def _row(values: Sequence[float]) -> str:
    return " ".join(_FORM % value for value in values)


WRITERS = {".vtp": polydata_of, ".vtk": legacy_of, ".ply": ply_of, ".obj": obj_of}
