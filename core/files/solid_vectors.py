# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors in solids: arrays of three numbers of a ``.vtu``, or a ``.sol`` of MEDIT beside the ``.mesh`` that it is of.

- ``.vtu``: as :mod:`.tets` reads it; arrays of floating-point numbers with three components, on points or on cells.
- ``.sol``: the keyword SolAtVertices or SolAtTetrahedra, a count, how many fields and the type of each (1 a number, 2 a
  vector, 3 six numbers of a symmetric matrix), and as many rows (Frey, "MEDIT", 2001, Section 3).
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import SettingError
from ..geometry.tet_mesh import TetMesh
from .border import TEXT_BYTES, border, read_bytes, text_numbers
from .tets import VTK_TET, medit_sections, read_numbered_tets, vtu_array, vtu_root, vtu_sizes

SUFFIXES = (".vtu", ".sol")
# Numbers of MEDIT's types of fields.
_WIDTHS = {1: 1, 2: 3, 3: 6}


@dataclass(frozen=True)
class SolidVectors:
    """Vectors in a solid: (n, 3) at its vertices, or (m, 3) in its tetrahedra."""

    mesh: TetMesh
    values: np.ndarray
    at_vertices: bool


def read_vectors(path: str | Path, name: str = "") -> SolidVectors:
    """Read the vectors of a .vtu, or of a .sol beside its .mesh; SettingError names the file and the remedy.

    The name is that of an array of a .vtu, "" for the only one.
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise SettingError(f"{path}: vectors in solids are read from {' and '.join(SUFFIXES)} files")
    with border(path):
        return _read(path, name)


def _read(path: Path, name: str) -> SolidVectors:
    """As :func:`read_vectors`; errors of the format may be of other types."""
    content = read_bytes(path, TEXT_BYTES)
    is_vtu = path.suffix.lower() == ".vtu"
    mesh, _, own = read_numbered_tets(path if is_vtu else path.with_suffix(".mesh"))
    fields = _of_vtu(path, content) if is_vtu else _of_sol(path, content)
    have = ", ".join(f"{field} on {'points' if at_points else 'cells'}" for field, at_points in fields) or "none"
    chosen = [key for key in fields if name in ("", key[0])]
    if len(chosen) != 1:
        named = f"has no single array of vectors {name!r}" if name else "has not one array of vectors"
        raise SettingError(f"{path} {named} (it has {have}): name one of these")
    values, at_points = fields[chosen[0]], chosen[0][1]
    wanted = mesh.vertex_count if at_points else len(own)
    if len(values) != wanted:
        kind = "vertices" if at_points else "tetrahedra"
        raise SettingError(f"{path} has {len(values)} vectors for {wanted} {kind} of the solid: give one for each")
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if len(bad):
        raise SettingError(f"{path}: vector {bad[0]} is not finite: set its numbers")
    return SolidVectors(mesh, values if at_points else values[own], at_points)


def _of_vtu(path: Path, content: bytes) -> dict[tuple[str, bool], np.ndarray]:
    """Vectors by the name of their array, and whether they are on points."""
    root, appended = vtu_root(path, content)
    found: dict[tuple[str, bool], list[np.ndarray]] = {}
    pieces = list(root.iter("Piece"))
    for piece in pieces:
        points, cells = vtu_sizes(piece)
        types = next(a for a in piece.iterfind("Cells/DataArray") if a.get("Name") == "types")
        is_tet = vtu_array(root, appended, types, cells) == VTK_TET
        for place, count in (("PointData", points), ("CellData", cells)):
            for array in piece.iterfind(f"{place}/DataArray"):
                if "Float" in array.get("type", "") and array.get("NumberOfComponents") == "3":
                    values = vtu_array(root, appended, array, 3 * count).reshape(-1, 3).astype(float)
                    key = str(array.get("Name")), place == "PointData"
                    found.setdefault(key, []).append(values if key[1] else values[is_tet])
    return {key: np.concatenate(parts) for key, parts in found.items() if len(parts) == len(pieces)}


def _of_sol(path: Path, content: bytes) -> dict[tuple[str, bool], np.ndarray]:
    """Read the vector fields of a .sol file, whose names are numbers."""
    sections = medit_sections(path, content)
    found = {}
    for keyword, at_vertices in (("SolAtVertices", True), ("SolAtTetrahedra", False)):
        if keyword not in sections:
            continue
        count, number, *rest = text_numbers(sections[keyword]).tolist()
        widths = [_WIDTHS[kind] for kind in rest[: int(number)]]
        rows = np.array(rest[int(number) :], float).reshape(int(count), sum(widths))
        for field, (width, end) in enumerate(zip(widths, np.cumsum(widths), strict=True)):
            if width == 3:
                found[str(field), at_vertices] = rows[:, end - 3 : end]
    return found
