# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids of other programs: tetrahedra in MEDIT's ``.mesh`` (ASCII) and VTK's ``.vtu``.

- ``.mesh``: keywords, each followed by a count and as many rows of numbers; every row ends with a reference number, and
  vertices count from 1 (Frey, "MEDIT: an interactive mesh visualization software", 2001, Section 3).
- ``.vtu``: XML with arrays of text, of base64, or appended, compressed by zlib or not
  (https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html).
"""

import re
import zlib
from base64 import b64decode
from codecs import BOM_UTF8
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..errors import SettingError
from ..geometry.tet_mesh import TetMesh, positive
from ..graphs import components
from .border import TEXT_BYTES, border, check_promise, read_bytes, text_numbers, whole_numbers

SUFFIXES = (".mesh", ".vtu")
# Cells of VTK: a triangle, a tetrahedron, and other cells with a volume.
VTK_TRIANGLE, VTK_TET = 5, 10
VTK_SOLIDS = {11: "voxels", 12: "hexahedra", 13: "prisms", 14: "pyramids", 24: "curved tetrahedra", 42: "polyhedra"}
# Bytes of the arrays of a point and of a cell of a .vtu file while they are read, when they exist twice.
_POINT_BYTES, _CELL_BYTES = 48, 128
MEDIT_SOLIDS = ("Hexahedra", "Hexaedra", "Prisms", "Pyramids", "TetrahedraP2")
# Vertices, tetrahedra and triangles of a file, and numbers of the triangles by name.
_Read = tuple[np.ndarray, np.ndarray, np.ndarray, dict[str, np.ndarray]]


def read_tets(path: str | Path) -> TetMesh:
    """Read the solid in a ``.mesh`` or ``.vtu`` file.

    Inverted tetrahedra are reordered. Where triangles of the file enclose some of its tetrahedra and others fill the
    space around, up to a hull without triangles, only the enclosed ones are the solid. Vertices keep their numbers.

    Raises SettingError naming the file, what is wrong in it, and the remedy; MeshError likewise, for a sound file with
    bad tetrahedra.
    """
    return read_marked_tets(path)[0]


def read_marked_tets(path: str | Path) -> tuple[TetMesh, dict[str, np.ndarray]]:
    """Read a solid as :func:`read_tets`, and (k, 3) vertices of its marked triangles: by ``ref_NUMBER`` for the
    references of a ``.mesh``, by ``NAME_NUMBER`` for whole numbers on the cells of a ``.vtu``."""
    return read_numbered_tets(path)[:2]


def read_numbered_tets(path: str | Path) -> tuple[TetMesh, dict[str, np.ndarray], np.ndarray]:
    """Read a solid as :func:`read_marked_tets`, and which of the file's tetrahedra are its own, bool."""
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise SettingError(f"{path} is not a file of tetrahedra: use the suffix .mesh (MEDIT, text) or .vtu")
    with border(path):
        read = _read_medit if suffix == ".mesh" else _read_vtu
        vertices, tets, triangles, numbers = read(path, read_bytes(path, TEXT_BYTES))
        if not len(tets):
            raise SettingError(f"{path} has no tetrahedra: export the solid, not its surface")
        outside = np.flatnonzero(((tets < 0) | (tets >= len(vertices))).any(axis=1))
        if len(outside):
            raise SettingError(
                f"tetrahedron {outside[0]} names a vertex that is not among the {len(vertices)}: export it again"
            )
        mesh = TetMesh(vertices, positive(vertices, tets))
        own = _enclosed_parts(mesh, triangles)
        mesh = mesh if own.all() else TetMesh(vertices, mesh.tets[own])
        return mesh, _number_groups(triangles, numbers, len(vertices)), own


def _number_groups(triangles: np.ndarray, numbers: dict[str, np.ndarray], count: int) -> dict[str, np.ndarray]:
    """Triangles of existing vertices by name and number."""
    known = ((triangles >= 0) & (triangles < count)).all(axis=1)
    return {
        f"{name}_{number}": triangles[known & (values == number)]
        for name, values in numbers.items()
        for number in np.unique(values[known]).tolist()
    }


def _enclosed_parts(mesh: TetMesh, triangles: np.ndarray) -> np.ndarray:
    """(m,) bool: tetrahedra of the parts of a solid, cut by triangles, whose boundaries consist of triangles only; all
    where there are no such parts."""
    if not len(triangles):
        return np.ones(mesh.tet_count, bool)
    _, names = np.unique(np.concatenate([mesh.faces, np.sort(triangles, axis=1)]), axis=0, return_inverse=True)
    names = names.reshape(-1)
    is_wall = np.isin(names[: len(mesh.faces)], names[len(mesh.faces) :])
    is_hull = mesh.face_tets[:, 1] < 0
    parts = components(mesh.tet_count, mesh.face_tets[~is_wall & ~is_hull])
    is_open = np.zeros(parts.max(initial=-1) + 1, bool)
    is_open[parts[mesh.face_tets[is_hull & ~is_wall, 0]]] = True
    kept = ~is_open[parts]
    return kept | ~kept.any()


def medit_sections(path: Path, content: bytes) -> dict[str, str]:
    """The text after each keyword of a MEDIT file of dimension 3."""
    try:
        text = re.sub(rb"#.*", b"", content.removeprefix(BOM_UTF8)).decode("ascii")
    except UnicodeDecodeError as error:
        raise SettingError(f"{path} is not a text file: export it as ASCII .mesh") from error
    # Words of three letters and more are keywords; a digit or a point comes before the letter of a number.
    parts = re.split(r"(?<![\w.])([A-Za-z]\w{2,})", text)
    sections = dict(zip(parts[1::2], parts[2::2], strict=True))
    if "MeshVersionFormatted" not in sections:
        raise SettingError(f"{path} is not a MEDIT file: it lacks MeshVersionFormatted, export it again")
    if sections.get("Dimension", "3").strip() != "3":
        raise SettingError(f"{path} is flat: export a solid of dimension 3")
    return sections


def _read_medit(path: Path, content: bytes) -> _Read:
    """Read a MEDIT file, whose vertices count from 1; references of its triangles become "ref"."""
    sections = medit_sections(path, content)
    if not sections.get("Vertices", "").strip():
        raise SettingError(f"{path} is not a MEDIT file: it lacks Vertices, export it again")
    for name in MEDIT_SOLIDS:
        if len(sections.get(name, "").split(None, 2)) > 1:  # more than a count of 0
            raise SettingError(f"{path} has {name}: split all cells into straight tetrahedra")
    vertices = medit_rows("Vertices", sections["Vertices"], 3)[:, :3]
    tets = whole_numbers(medit_rows("Tetrahedra", sections.get("Tetrahedra", "0"), 4))[:, :4]
    rows = whole_numbers(medit_rows("Triangles", sections.get("Triangles", "0"), 3))
    return vertices, tets - 1, rows[:, :3] - 1, {"ref": rows[:, 3]}


def medit_rows(name: str, text: str, width: int) -> np.ndarray:
    """(count, width + 1) numbers of a section, the last of each row its reference."""
    head, *rest = text.split(None, 1)
    count, numbers = int(head), text_numbers(*rest or [""])
    if count < 0 or len(numbers) != count * (width + 1):
        raise SettingError(
            f"it promises {count} {name} of {width + 1} numbers and has {len(numbers)} numbers: "
            "it was cut short, export it again"
        )
    return numbers.reshape(count, width + 1)


def _read_vtu(path: Path, content: bytes) -> _Read:
    """Read points, tetrahedra, triangles and numbers of the triangles from all pieces of a .vtu file."""
    root, appended = vtu_root(path, content)
    points, tets, triangles = [np.zeros((0, 3))], [np.zeros((0, 4), np.int64)], [np.zeros((0, 3), np.int64)]
    count, marks = 0, []
    check_vtu_sizes(path, root)
    for piece in root.iter("Piece"):
        vertices, cells = vtu_sizes(piece)
        here = vtu_array(root, appended, piece.find("Points/DataArray"), 3 * vertices).reshape(-1, 3)
        arrays = {a.get("Name"): a for a in piece.iterfind("Cells/DataArray")}
        ends, types = (whole_numbers(vtu_array(root, appended, arrays[name], cells)) for name in ("offsets", "types"))
        corners = whole_numbers(vtu_array(root, appended, arrays["connectivity"], ends.max(initial=0)))
        values = {
            str(a.get("Name")): vtu_array(root, appended, a, cells)
            for a in piece.iterfind("CellData/DataArray")
            if "Int" in a.get("type", "") and a.get("NumberOfComponents", "1") == "1"
        }
        for kind in VTK_SOLIDS.keys() & set(types.tolist()):
            raise SettingError(f"{path} has {VTK_SOLIDS[kind]}: split all cells into straight tetrahedra")
        if (ends < 0).any():
            raise SettingError(f"{path} has cells whose corners are missing: it was cut short, export it again")
        sizes = np.diff(ends, prepend=0)
        if (sizes[types == VTK_TET] != 4).any() or (sizes[types == VTK_TRIANGLE] != 3).any():
            raise SettingError(f"{path} has tetrahedra without 4 corners, or triangles without 3: export it again")
        points.append(here)
        tets.append(corners[ends[types == VTK_TET][:, None] + np.arange(-4, 0)] + count)
        triangles.append(corners[ends[types == VTK_TRIANGLE][:, None] + np.arange(-3, 0)] + count)
        marks.append({name: found[types == VTK_TRIANGLE] for name, found in values.items()})
        count += len(here)
    shared = set.intersection(*map(set, marks)) if marks else set()
    numbers = {name: np.concatenate([mark[name] for mark in marks]) for name in sorted(shared)}
    return np.concatenate(points), np.concatenate(tets), np.concatenate(triangles), numbers


def vtu_sizes(piece: ElementTree.Element) -> tuple[int, int]:
    """The numbers of points and cells that a piece of a .vtu file promises."""
    points, cells = (int(_get(piece, f"NumberOf{name}")) for name in ("Points", "Cells"))
    if min(points, cells) < 0:
        raise ValueError(f"{points} points, {cells} cells")
    return points, cells


def _get(element: ElementTree.Element, name: str) -> str:
    value = element.get(name)
    if value is None:
        raise ValueError(f"{name} is missing")
    return value


def check_vtu_sizes(path: Path, root: ElementTree.Element) -> None:
    """Refuse a file whose pieces promise more points and cells than memory holds."""
    sizes = [vtu_sizes(piece) for piece in root.iter("Piece")]
    check_promise(path, sum(_POINT_BYTES * points + _CELL_BYTES * cells for points, cells in sizes))


def vtu_root(path: Path, content: bytes, kind: str = "UnstructuredGrid") -> tuple[ElementTree.Element, bytes]:
    """The XML of a .vtu file, or of VTK's file of another kind, and its appended bytes."""
    head, appended, tail = _without_raw_data(content)
    root = ElementTree.fromstring(head + tail)
    if root.tag != "VTKFile" or root.get("type") != kind:
        wanted = (
            "not an unstructured grid of VTK: export it as .vtu" if kind == "UnstructuredGrid" else f"not VTK's {kind}"
        )
        raise SettingError(f"{path} is {wanted}")
    return root, appended


def _without_raw_data(content: bytes) -> tuple[bytes, bytes, bytes]:
    """The XML before appended data, these data, and the XML after them: raw bytes are not XML."""
    tag = content.find(b"<AppendedData")
    first = content.find(b"_", content.find(b">", tag))
    last = content.rfind(b"</AppendedData>")
    if tag < 0 or first < 0 or last < first:
        return content, b"", b""
    return content[:first], content[first + 1 : last], content[last:]


def vtu_array(root: ElementTree.Element, appended: bytes, array: ElementTree.Element | None, count: int) -> np.ndarray:
    """(count,) numbers of an array of a .vtu file; raises one of ``UNREADABLE`` for a damaged array or another count,
    before anything is unpacked."""
    if array is None:
        raise ValueError("it is missing")
    order = ">" if root.get("byte_order") == "BigEndian" else "<"
    kinds = {"Float": "f", "Int": "i", "UInt": "u"}
    name = array.get("type", "")
    dtype = np.dtype(f"{order}{kinds[name.rstrip('0123456789')]}{int(re.sub('[^0-9]', '', name)) // 8}")
    if array.get("format") == "ascii":
        return _count_text(text_numbers(array.text or "", dtype), count)
    compressor = root.get("compressor")
    if compressor not in (None, "", "vtkZLibDataCompressor"):
        raise ValueError(f"compressed by {compressor}, use zlib")
    if array.get("format") == "appended":
        stored, raw = appended[int(_get(array, "offset")) :], root.find("AppendedData[@encoding='raw']") is not None
    else:
        stored, raw = "".join((array.text or "").split()).encode("ascii"), False
    header = np.dtype(order + {"UInt32": "u4", "UInt64": "u8"}[root.get("header_type", "UInt32")])
    unpack = _decompress_blocks if compressor else _plain
    return _count_text(np.frombuffer(unpack(stored, header, raw, int(count) * dtype.itemsize), dtype), count)


def _count_text(numbers: np.ndarray, count: int) -> np.ndarray:
    if len(numbers) != count:
        raise ValueError(f"{len(numbers)} numbers where {count} are promised")
    return numbers


def _plain(stored: bytes, header: np.dtype, raw: bool, wanted: int) -> bytes:
    """Bytes after a header with their number; in base64 both are one stream, or one each."""
    width = header.itemsize
    size = int(np.frombuffer(_bytes(stored, 0, width, raw), header)[0])
    if size != wanted:
        raise ValueError(f"{size} bytes where {wanted} are promised")
    if raw:
        return _bytes(stored, width, size, raw)
    alone = _characters(width)
    if stored[:alone].endswith(b"=" * (-width % 3)):  # a byte of data in the same stream leaves one "=" less
        return _bytes(stored, alone, size, raw)
    return _bytes(stored, 0, width + size, raw)[width:]


def _decompress_blocks(stored: bytes, header: np.dtype, raw: bool, wanted: int) -> bytes:
    """Blocks after a header of their number, their size, the last one's size and the compressed size of each."""
    blocks = int(np.frombuffer(_bytes(stored, 0, header.itemsize, raw), header)[0])
    width = (3 + blocks) * header.itemsize
    size, last, *lengths = (int(number) for number in np.frombuffer(_bytes(stored, 0, width, raw), header)[1:])
    if blocks and (blocks - 1) * size + (last or size) != wanted:
        raise ValueError(f"{blocks} blocks of {size} bytes where {wanted} bytes are promised")
    packed = _bytes(stored, width if raw else _characters(width), sum(lengths), raw)
    found, place = [], 0
    for number, length in enumerate(lengths, 1):
        promised = last if number == blocks and last else size
        block, place = packed[place : place + length], place + length
        found.append(zlib.decompressobj().decompress(block, promised + 1))
        if len(found[-1]) != promised:
            raise ValueError(f"a block of other than the {promised} bytes that are promised")
    return b"".join(found)


def _bytes(stored: bytes, first: int, count: int, raw: bool) -> bytes:
    """``count`` bytes from a place in raw bytes or in base64."""
    found = stored[first : first + count] if raw else b64decode(stored[first : first + _characters(count)])[:count]
    if len(found) < count:
        raise ValueError(f"{len(found)} bytes where {count} are promised")
    return found


def _characters(count: int) -> int:
    """Number of characters of base64 for a number of bytes."""
    return -(-count // 3) * 4
