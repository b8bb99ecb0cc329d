# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of mesh files: whether an .obj, .ply or .stl is complete, and whether a reader survives a .ply or .glb."""

import json
import re
import struct
from pathlib import Path

import numpy as np

from ..errors import SettingError, quote_value
from .border import border, check_promise, read_bytes

_FORMATS = "ascii", "binary_little_endian", "binary_big_endian"
_SIZES = {"char": 1, "short": 2, "int": 4, "float": 4, "double": 8} | {"uchar": 1, "ushort": 2, "uint": 4}
_SIZES |= {"int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "float32": 4, "float64": 8}
_COUNTS = {"char": "i1", "uchar": "u1", "int8": "i1", "uint8": "u1", "short": "i2", "ushort": "u2"}
_COUNTS |= {"int16": "i2", "uint16": "u2", "int": "i4", "uint": "u4", "int32": "i4", "uint32": "u4"}
# Bytes of an .stl file before its triangles, the last four of which are their number, and of a triangle.
_STL_HEADER, _STL_TRIANGLE = 84, 50
# Bytes of a .glb file before its JSON, and bytes that Blender's importer takes for each number of an array.
_GLB_HEADER, _GLB_BYTES = 20, 16
_GLB_TYPES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


def is_whole(path: Path, vertices: int, faces: int) -> bool:
    """Whether a mesh file has these numbers of vertices and faces; an .stl or .ply some where they are not 0, and as
    many as it says."""
    content = Path(path).read_bytes()
    if path.suffix.lower() == ".stl":
        count = int.from_bytes(content[_STL_HEADER - 4 : _STL_HEADER], "little")
        return len(content) == _STL_HEADER + _STL_TRIANGLE * count and (count > 0) == (faces > 0)
    if path.suffix.lower() == ".ply":
        return _is_whole_ply(content, vertices > 0)
    lines = b"\n" + content
    return content.endswith(b"\n") and lines.count(b"\nv ") == vertices and lines.count(b"\nf ") == faces


def _is_whole_ply(content: bytes, has_vertices: bool) -> bool:
    """Whether a little-endian binary file is as long as its header says, and has vertices or none."""
    try:
        kind, elements, body = _ply_header(content)
    except ValueError:
        return False
    if kind != "binary_little_endian" or any(count for count, _ in elements) != has_vertices:
        return False
    place = 0
    for count, properties in elements:
        place = _after(body, place, count, properties)
    return place == len(body)


def check_ply(path: str | Path) -> None:
    """Raise SettingError for a .ply file whose header would crash Blender's importer."""
    with border(path):
        content = read_bytes(path)
        kind, elements, body = _ply_header(content)
    # The least size of an element: in text a character and a space for each number; lists may be empty.
    least = 0
    for count, properties in elements:
        sizes = [2 if kind == "ascii" else _SIZES[words[0] if len(words) == 1 else words[1]] for words in properties]
        least += count * sum(sizes)
    if least > len(body) + 1:
        raise SettingError(f"{path} promises more than {len(content)} bytes hold: it was cut short, export it again")


def check_glb(path: str | Path) -> None:
    """Raise SettingError for a .glb file whose accessors promise more than memory holds."""
    with border(path):
        content = read_bytes(path)
        magic, _, _, length, kind = struct.unpack_from("<4sIII4s", content)
        if (magic, kind) != (b"glTF", b"JSON"):
            raise ValueError("it does not begin with glTF and its JSON")
        found = json.loads(content[_GLB_HEADER : _GLB_HEADER + length])
        promised = 0
        for accessor in found.get("accessors", []):
            promised += abs(int(accessor["count"])) * _GLB_TYPES[accessor["type"]]
        check_promise(path, _GLB_BYTES * promised)


def _ply_header(content: bytes) -> tuple[str, list[tuple[int, list[list[str]]]], bytes]:
    """The format, the elements, each a count and the types of its properties, and the bytes after the header;
    ValueError for a bad header."""
    header, end, body = content.partition(b"end_header")
    if not content.startswith(b"ply") or not end:
        raise ValueError("it does not begin with ply, or end with end_header")
    kind: str | None = None
    elements: list[tuple[int, list[list[str]]]] = []
    for line in header.splitlines()[1:]:
        words = (text := line.decode("utf-8", "replace")).split()  # comments may be of any encoding
        match words:
            case [] | ["comment" | "obj_info", *_]:
                continue
            case ["format", word, _] if word in _FORMATS:
                kind = word
            case ["element", _, number] if re.fullmatch(r"\d{1,10}", number) and int(number) < 2**31:
                elements.append((int(number), []))
            case ["property", "list", count, item, _] if elements and count in _COUNTS and item in _SIZES:
                elements[-1][1].append(["list", count, item])
            case ["property", item, _] if elements and item in _SIZES:
                elements[-1][1].append([item])
            case _:
                raise ValueError(f"it has the line {quote_value(text)}")
    if kind is None:
        raise ValueError("it has no format")
    return kind, elements, body.removeprefix(b"\r").removeprefix(b"\n")


def _after(body: bytes, place: int, count: int, kinds: list[list[str]]) -> int:
    """The end of ``count`` elements that begin at a place; beyond the body's end if they do not fit."""
    if all(len(kind) == 1 for kind in kinds):
        return place + count * sum(_SIZES[kind] for (kind,) in kinds)
    for _ in range(count):
        for kind in kinds:
            if len(kind) == 1:
                place += _SIZES[kind[0]]
                continue
            _, numbers, items = kind
            if place + _SIZES[numbers] > len(body):
                return len(body) + 1
            length = np.frombuffer(body, _COUNTS[numbers], 1, place)[0]
            place += _SIZES[numbers] + int(length) * _SIZES[items]
    return place
