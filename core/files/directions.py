# SPDX-License-Identifier: GPL-3.0-or-later
"""Direction fields of other programs: ``.rawfield`` (Directional) and ``.rosy`` (vcglib, QuadWild).

- ``.rawfield``: a line "N faces", then one line a face with the 3 N numbers of its N vectors
  (https://avaxman.github.io/Directional/file_formats).
- ``.rosy``: a line with the number of faces, a line with N, then one line a face with one vector whose turns about
  the normal are the others. vcglib writes and reads N = 4 only; its older versions wrote a line a vertex.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SettingError
from ..fields.guidance.face_directions import average_in_faces, face_frames
from ..fields.guidance.guides import Guide, face_guide
from ..geometry import TriangleMesh
from .border import border, check_promise, read_text
from .whole import write_whole

SUFFIXES = (".rawfield", ".rosy")
# Number and text of a line.
_Line = tuple[int, str]
# Bytes of a line of a file, besides its text, while it is read, and number of rows that are read at once.
_LINE_BYTES, _ROWS_AT_ONCE = 200, 4096
# Vectors that miss equal turns by more than this (as a cosine) cannot be written as one of them.
UNEQUAL = 1e-3


@dataclass(frozen=True)
class FaceField:
    """Directions on faces; SettingError for vectors of another shape.

    Attributes
    ----------
    symmetry : N: 1 vectors, 2 lines, 4 crosses
    vectors : (m, N, 3), counterclockwise, not matched from face to face; or (m, 1, 3), one that stands for all N
    """

    symmetry: int
    vectors: np.ndarray

    def __post_init__(self) -> None:
        shape = np.shape(self.vectors)
        if self.symmetry < 1 or len(shape) != 3 or shape[1] not in (1, self.symmetry) or shape[2] != 3:
            raise SettingError(
                f"vectors of shape {shape} do not make a field of symmetry {self.symmetry}: "
                "give each face one vector, or as many as the symmetry says"
            )


def read_field(path: str | Path) -> FaceField:
    """Read a ``.rawfield`` or ``.rosy`` file; SettingError names the file, the line, and the remedy."""
    path = Path(path)
    read_header = _raw_header if _known_suffix(path) == ".rawfield" else _rosy_header
    with border(path):
        try:
            text = read_text(path, encoding="ascii")
        except UnicodeDecodeError as error:
            raise SettingError(f"{path} is not a text file: export the field again, as text") from error
        check_promise(path, _LINE_BYTES * text.count("\n"))
        lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
        symmetry, count, width, rows = read_header(path, lines)
        if len(rows) != count:
            raise SettingError(
                f"{path} promises {count} faces and has {len(rows)} lines of vectors: it was cut short, export it again"
            )
        return FaceField(symmetry, _numbers(path, rows, 3 * width).reshape(count, width, 3))


def write_field(path: str | Path, face_field: FaceField) -> None:
    """Write a field as ``.rawfield`` or ``.rosy``, by the suffix; numbers keep all their digits.

    Raises SettingError for another suffix, a file that cannot be written, or a field that the format cannot hold:
    ``.rawfield`` needs all vectors of a face, ``.rosy`` equal turns between them.
    """
    path = Path(path)
    count, given, _ = face_field.vectors.shape
    if _known_suffix(path) == ".rosy":
        _refuse_unequal(path, face_field)
        header, rows = f"{count}\n{face_field.symmetry}", face_field.vectors[:, 0]
    else:
        if given != face_field.symmetry:
            raise SettingError(
                f"{path} needs {face_field.symmetry} vectors a face and the field has one: "
                "pass it through to_vertices and from_vertices, or write a .rosy file"
            )
        header, rows = f"{face_field.symmetry} {count}", face_field.vectors.reshape(count, -1)
    with write_whole(path) as made:
        np.savetxt(made, rows, fmt="%.17g", header=header, comments="")


def to_vertices(mesh: TriangleMesh, face_field: FaceField) -> Guide:
    """Make a guide from a field on the triangles of a mesh, in the same order.

    The vectors of a face are replaced by the N equal turns nearest to their directions, whose powers are averaged by
    area; faces whose vectors miss such turns count for less. The angles are one representative, up to turns by
    2 pi / N. A face with a vector that is zero or normal to it does not count.

    Raises SettingError where the numbers of faces and triangles differ, or no face has a direction.
    """
    vectors = face_field.vectors
    if len(vectors) != mesh.triangle_count:
        on_vertices = " (it may be a field on vertices)" if len(vectors) == mesh.vertex_count else ""
        raise SettingError(
            f"the field has {len(vectors)} faces{on_vertices} and the mesh has {mesh.triangle_count} triangles: "
            "load it on the triangle mesh that it was made for"
        )
    x, y = face_frames(mesh)
    tangent = np.einsum("tkc,tc->tk", vectors, x) + 1j * np.einsum("tkc,tc->tk", vectors, y)
    means, defined = _nearest_star(tangent, np.linalg.norm(vectors, axis=2))
    if not defined.any():
        raise SettingError("every vector of the field is zero or normal to its face: export the field again")
    sizes = np.abs(means)
    powers = np.divide(means, sizes, out=np.zeros_like(means), where=sizes > 0) ** face_field.symmetry
    return face_guide(mesh, np.where(defined, mesh.areas * sizes * powers, 0), face_field.symmetry)


def from_vertices(mesh: TriangleMesh, symmetry: int, angles: ArrayLike) -> FaceField:
    """(m, N, 3) unit vectors on faces, counterclockwise, from (n,) angles at vertices, radians in their tangent planes,
    by the mean of the three corners' powers."""
    powers = average_in_faces(mesh, np.exp(1j * symmetry * np.asarray(angles, float)), symmetry)
    turns = np.angle(powers)[:, None] / symmetry + 2 * np.pi / symmetry * np.arange(symmetry)
    x, y = face_frames(mesh)
    return FaceField(symmetry, np.cos(turns)[..., None] * x[:, None] + np.sin(turns)[..., None] * y[:, None])


def _nearest_star(tangent: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The first of the N equal turns nearest to (m, N) complex vectors, and whether all of them have a direction.

    Turned back by k / N turns, the k-th vector in counterclockwise order should be the first: the mean is the
    least-squares solution, and its length says how well they agree.
    """
    sizes = np.abs(tangent)
    defined = (sizes > np.maximum(1e-6 * lengths, np.finfo(float).tiny)).all(axis=1)
    units = np.divide(tangent, sizes, out=np.ones_like(tangent), where=sizes > np.finfo(float).tiny)
    ordered = np.take_along_axis(units, np.argsort(np.angle(units), axis=1), axis=1)
    count = tangent.shape[1]
    return (ordered * np.exp(-2j * np.pi / count * np.arange(count))).mean(axis=1), defined


def _known_suffix(path: Path) -> str:
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise SettingError(f"{path} is not a field file: use the suffix .rawfield or .rosy")
    return suffix


def _raw_header(path: Path, lines: list[_Line]) -> tuple[int, int, int, list[_Line]]:
    symmetry, count = _header_numbers(path, lines[:1], 2, 'start with "N faces"')
    return symmetry, count, symmetry, lines[1:]


def _rosy_header(path: Path, lines: list[_Line]) -> tuple[int, int, int, list[_Line]]:
    wanted = "start with a line for the number of faces and a line for N"
    (count,) = _header_numbers(path, lines[:1], 1, wanted)
    (symmetry,) = _header_numbers(path, lines[1:2], 1, wanted)
    return symmetry, count, 1, lines[2:]


def _header_numbers(path: Path, lines: list[_Line], wanted: int, remedy: str) -> list[int]:
    """The ``wanted`` positive integers of a header's first line; SettingError, with the remedy, for anything else."""
    if not lines:
        raise SettingError(f"{path} ends before its header: {remedy}")
    number, line = lines[0]
    words = line.split()
    if len(words) != wanted or not all(re.fullmatch(r"0*[1-9]\d{0,9}", word) for word in words):
        raise SettingError(f"{path}, line {number}: {' '.join(words)[:40]!r} is not a header, {remedy}")
    return [int(word) for word in words]


def _numbers(path: Path, rows: list[_Line], width: int) -> np.ndarray:
    """(rows, width) finite floats, read some rows at a time."""
    parts = []
    for first in range(0, len(rows), _ROWS_AT_ONCE):
        part = [(number, line.split()) for number, line in rows[first : first + _ROWS_AT_ONCE]]
        for number, words in part:
            if len(words) != width:
                raise SettingError(
                    f"{path}, line {number}: {len(words)} numbers where {width} are needed, "
                    "three for each vector of the face"
                )
        try:
            found = np.array([words for _, words in part], float)
        except ValueError:
            found = np.array([[_number(word) for word in words] for _, words in part])
        bad = np.flatnonzero(~np.isfinite(found).all(axis=1))
        if len(bad):
            number, words = part[bad[0]]
            raise SettingError(f"{path}, line {number}: {' '.join(words)[:40]!r} is not all finite numbers, correct it")
        parts.append(found)
    return np.concatenate(parts)


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return np.nan


def _refuse_unequal(path: Path, face_field: FaceField) -> None:
    """Refuse vectors of a face that are not equal turns of each other: one could not stand for all."""
    vectors = face_field.vectors
    lengths = np.linalg.norm(vectors, axis=2)
    cosines = np.einsum("tkc,tc->tk", vectors, vectors[:, 0])
    scale = lengths * lengths[:, :1]
    expected = np.cos(2 * np.pi / face_field.symmetry * np.arange(vectors.shape[1]))
    bad = np.flatnonzero((np.abs(cosines - expected * scale) > UNEQUAL * scale).any(axis=1))
    if len(bad):
        raise SettingError(
            f"{path} cannot hold face {bad[0]} ({len(bad)} in all), whose vectors are not equal turns of each other: "
            "write a .rawfield file"
        )
