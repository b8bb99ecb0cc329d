# SPDX-License-Identifier: GPL-3.0-or-later
""".obj files with all their digits, written at any size and place, and read relative to their centre.

Blender's exporter writes six decimals, too few for a mesh that is a millionth long, and its importer keeps single
precision, which moves points at 5e6 by up to 0.25.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np

from .border import border, check_promise, read_bytes
from .digits import number_format

# Meshes are far from the origin beyond this multiple of their size, where single precision leaves 2e5 steps to it.
FAR = 100.0
# Vertices that are checked first: nearly all meshes are not far.
_SAMPLE = 1000
# Bytes of a vertex while all places of a file are read, and rows of a text that are made at once.
_VERTEX_BYTES, _ROWS_AT_ONCE = 400, 65536
_PLACE = re.compile(rb"^[ \t]*v[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)", re.MULTILINE)


@dataclass(frozen=True)
class ObjMesh:
    """A mesh as an .obj file holds it.

    Attributes
    ----------
    vertices : (n, 3)
    corners : (c,) vertex of each corner
    sizes : (f,) number of corners of each face
    smooth : (f,) bool, faces that are shaded smooth
    normals : (c, 3) at the corners
    places : (c, 2) in the UV map, or None
    """

    name: str
    vertices: np.ndarray
    corners: np.ndarray
    sizes: np.ndarray
    smooth: np.ndarray
    normals: np.ndarray
    places: np.ndarray | None = None


def write_obj(file: TextIO, mesh: ObjMesh) -> None:
    """Write a mesh to an open text file."""
    file.write(f"# Synch Fields\no {re.sub(r'[^!-~]+', '_', mesh.name) or 'mesh'}\n")
    _write_rows(file, "v", mesh.vertices, number_format(mesh.vertices))
    # Equal normals and places are written once; to add 0 makes -0 and 0 equal.
    normals, normal_of = np.unique(np.round(mesh.normals, 6) + 0.0, axis=0, return_inverse=True)
    _write_rows(file, "vn", normals, "%.6g")
    columns = [mesh.corners + 1, normal_of.reshape(-1) + 1]
    if mesh.places is not None:
        places, place_of = np.unique(mesh.places, axis=0, return_inverse=True)
        _write_rows(file, "vt", places, "%.9g")
        columns.insert(1, place_of.reshape(-1) + 1)
    between = "/" if mesh.places is not None else "//"
    words = [between.join(map(str, row)) for row in np.column_stack(columns).tolist()]
    ends, before = np.cumsum(mesh.sizes).tolist(), None
    for end, size, smooth in zip(ends, mesh.sizes.tolist(), mesh.smooth.tolist(), strict=True):
        if smooth != before:
            file.write(f"s {int(smooth)}\n")
            before = smooth
        file.write(f"f {' '.join(words[end - size : end])}\n")


def _write_rows(file: TextIO, keyword: str, values: np.ndarray, form: str) -> None:
    row = f"{keyword} " + " ".join([form] * values.shape[1]) + "\n"
    for first in range(0, len(values), _ROWS_AT_ONCE):
        file.write("".join(row % tuple(numbers) for numbers in values[first : first + _ROWS_AT_ONCE].tolist()))


def far_centre(path: Path) -> np.ndarray | None:
    """(3,) centre of a file's vertices in single precision if they are far from the origin, else None; SettingError for
    a file that cannot be read."""
    with border(path):
        content = read_bytes(path)
        if not _is_far(_places(_PLACE.finditer(content), _SAMPLE)):
            return None
        check_promise(path, _VERTEX_BYTES * (content.count(b"\nv") + 1))
        return centre_of_far(_places(_PLACE.finditer(content)))


def centre_of_far(places: np.ndarray) -> np.ndarray | None:
    """(3,) centre of (n, 3) places in single precision if they are far from the origin, else None."""
    if not _is_far(places):
        return None
    return np.float32((places.min(axis=0) + places.max(axis=0)) / 2).astype(float)


def write_centred(path: Path, centre: np.ndarray, target: Path) -> None:
    """Write a copy of a file with its vertices relative to a centre; everything else stays as it is."""
    with border(path):
        content = read_bytes(path, 3)

        def relative(found: re.Match[bytes]) -> bytes:
            place = np.array([float(word) for word in found.groups()]) - centre
            return b"v " + " ".join(f"{value:.12g}" for value in place).encode()

        target.write_bytes(_PLACE.sub(relative, content))


def _places(found: Iterable[re.Match[bytes]], most: int | None = None) -> np.ndarray:
    places: list[tuple[bytes, ...]] = []
    for place in found:
        if most is not None and len(places) == most:
            break
        places.append(place.groups())
    return np.array(places, float).reshape(-1, 3)


def _is_far(places: np.ndarray) -> bool:
    """Whether places are farther from the origin than :data:`FAR` times their extent."""
    if len(places) < 2 or not np.isfinite(places).all():
        return False
    extent = np.ptp(places, axis=0).max()
    return bool(extent > 0 and np.abs(places).max() > FAR * extent)
