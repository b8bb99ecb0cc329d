# SPDX-License-Identifier: GPL-3.0-or-later
"""The OpenVDB module, which only Blender has, and the sizes that a file promises, checked before the module reads it: a
damaged count keeps it busy for many minutes, and nothing interrupts it.

The layout is that of files since version 222 (OpenVDB 3): a header, metadata, and for each grid a descriptor, metadata,
a transform, and the tree with the counts of its root.
"""

import importlib
import importlib.util
import re
import struct
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import BinaryIO

from ..errors import SettingError
from ..interrupts import hold_interrupts

_MAGIC, _OLDEST = b" BDV\0\0\0\0", 222
# Bytes of the header behind the version, of a descriptor behind its names, of transforms by their names, and of values.
_HEADER, _DESCRIPTOR = 4 + 4 + 1 + 36, 24
_MAPS = {"UniformScaleMap": 120, "ScaleMap": 120, "TranslationMap": 24, "AffineMap": 128, "UnitaryMap": 128}
_MAPS |= {"UniformScaleTranslateMap": 144, "ScaleTranslateMap": 144}
_VALUES = {"bool": 1, "float": 4, "int32": 4, "double": 8, "int64": 8, "vec3s": 12, "vec3i": 12, "vec3d": 24}
# Bytes of an origin, and of whether a tile is active.
_ORIGIN, _ACTIVE = 12, 1


def check_vdb_sizes(path: Path) -> None:
    """Raise ValueError for a file whose counts promise more than its bytes hold; other kinds and older ones pass."""
    size = path.stat().st_size
    with path.open("rb") as file:
        if file.read(len(_MAGIC)) != _MAGIC or _Reader(file, size).number() < _OLDEST:
            return
        reader = _Reader(file, size)
        reader.skip(_HEADER)
        reader.metadata()
        for _ in range(reader.count(3 * 4 + _DESCRIPTOR)):
            _, kind, parent = (reader.text() for _ in range(3))
            begin, _, end = struct.unpack("<3q", reader.take(_DESCRIPTOR))
            if not parent:
                _check_grid(reader, begin, kind)
            reader.seek(end)


def _check_grid(reader: "_Reader", begin: int, kind: str) -> None:
    """Compare the numbers of tiles and children of the grid at a byte with the bytes that are left."""
    reader.seek(begin)
    reader.number()  # how it is compressed
    reader.metadata()
    moved = _MAPS.get(reader.text())
    value = _VALUES.get(re.sub(r"Tree_|_\d.*", "", kind))
    if moved is None or value is None:
        return
    reader.skip(moved)
    reader.number()  # of buffers
    reader.skip(value)
    tiles, children = reader.number(), reader.number()
    reader.check(tiles * (_ORIGIN + value + _ACTIVE) + children * _ORIGIN)


class _Reader:
    """Reads a file of a known size, and never beyond it."""

    def __init__(self, file: BinaryIO, size: int) -> None:
        self._file, self._size = file, size

    def check(self, length: int) -> None:
        if length > self._size - self._file.tell():
            raise ValueError(f"it promises {length} bytes and has {self._size - self._file.tell()}")

    def take(self, length: int) -> bytes:
        self.check(length)
        return self._file.read(length)

    def skip(self, length: int) -> None:
        self.check(length)
        self._file.seek(length, 1)

    def seek(self, place: int) -> None:
        if not 0 <= place <= self._size:
            raise ValueError(f"it has something at byte {place} of {self._size}")
        self._file.seek(place)

    def number(self) -> int:
        return struct.unpack("<I", self.take(4))[0]

    def count(self, least: int) -> int:
        """Read a number of parts of at least ``least`` bytes each, and check that the file is long enough for them."""
        number = self.number()
        self.check(number * least)
        return number

    def text(self) -> str:
        return self.take(self.number()).decode("utf-8", "replace")

    def metadata(self) -> None:
        for _ in range(self.count(3 * 4)):
            self.text()
            self.text()
            self.skip(self.number())


@cache
def openvdb_module(file: str | None = None) -> ModuleType:
    """The module, loaded once from a compiled file, or found by its name; SettingError if it does not exist.

    Signals wait until it is initialized: an exception inside would crash the process.
    """
    try:
        with hold_interrupts():
            if file is None:
                return importlib.import_module("openvdb")
            spec = importlib.util.spec_from_file_location(Path(file).name.split(".")[0], file)
            if spec is None or spec.loader is None:
                raise ImportError(file)
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
    except ImportError:
        raise SettingError("this Blender has no OpenVDB module: use another one, or flows as .npz") from None
    return module
