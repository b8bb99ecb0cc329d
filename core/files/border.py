# SPDX-License-Identifier: GPL-3.0-or-later
"""The border for data from outside: files of other programs, and texts stored in files and objects.

Each reader works inside :func:`border`, where every error of damaged data becomes one line, and calls
:func:`check_promise` or :func:`read_bytes` before it allocates what a file promises.
"""

import math
import re
import struct
import zlib
from codecs import BOM_UTF8
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tokenize import TokenError
from zipfile import BadZipFile

import numpy as np
from numpy.typing import DTypeLike

from ..errors import MeshError, SettingError, SynchError
from ..memory import check_memory

# Errors of reading damaged data. RuntimeError: an encrypted member of an archive, or an unknown compression;
# SyntaxError: damaged XML, or a damaged header of an array.
UNREADABLE = (
    *(ValueError, TypeError, AttributeError, LookupError, ArithmeticError, StopIteration, EOFError),
    *(RuntimeError, SyntaxError, TokenError, BadZipFile, zlib.error, struct.error),
)
# Characters of a text whose numbers are made at once: each number is first a Python object of about 60 bytes.
_AT_ONCE = 1 << 20
# Bytes of memory for each byte of a text file while it is read: the file, its text, its parts, and the numbers; and for
# each byte of a file of settings, whose words become Python objects.
TEXT_BYTES, SETTINGS_BYTES = 8, 100
# The largest whole number that a double distinguishes from its neighbours.
_LARGEST_WHOLE = 2**53


@contextmanager
def border(source: str | Path, remedy: str = "export it again") -> Iterator[None]:
    """Turn errors of damaged data into one line that names its source, such as a path, and a remedy.

    Raises SettingError for damaged data, files that cannot be opened, and more data than memory holds; SynchError of a
    reader, with the source in front if it names none.
    """
    cause: BaseException
    try:
        yield
    except SynchError as error:
        if str(source) in str(error) or type(error) not in (SynchError, SettingError, MeshError) or error.source:
            raise
        line, kind, cause = f"{source}: {error}", type(error), error
    except MemoryError as error:
        line, kind, cause = f"{source}: reading it takes more memory than is left: {remedy}", SettingError, error
    except OSError as error:
        line, kind, cause = f"{source} cannot be read ({error.strerror or error}): check the path", SettingError, error
    except RecursionError as error:
        line, kind, cause = f"{source} cannot be read (it is nested too deeply): {remedy}", SettingError, error
    except UNREADABLE as error:
        line, kind, cause = f"{source} cannot be read ({error or type(error).__name__}): {remedy}", SettingError, error
    else:
        return
    refused = kind(line, getattr(cause, "vertices", ()))
    refused.source = str(source)
    raise refused from cause


def check_promise(path: str | Path, size: int) -> None:
    """Refuse bytes that a file promises and memory cannot hold, before they are allocated."""
    check_memory(size, str(path), reserved=1.0)


def read_bytes(path: str | Path, each: int = 1) -> bytes:
    """The bytes of a file, refused before they are read if memory cannot hold ``each`` times as many."""
    check_promise(path, each * Path(path).stat().st_size)
    return Path(path).read_bytes()


def read_text(path: str | Path, each: int = TEXT_BYTES, encoding: str = "utf-8") -> str:
    """The text of a file, as :func:`read_bytes` reads its bytes, without the mark that Windows may put before it."""
    return read_bytes(path, each).removeprefix(BOM_UTF8).decode(encoding)


def text_numbers(text: str, dtype: DTypeLike = float) -> np.ndarray:
    """(n,) numbers of a text, made in parts to save memory; ValueError or OverflowError for other words."""
    parts, place = [], 0
    while place < len(text):
        found = re.compile(r"\s").search(text, place + _AT_ONCE)
        end = len(text) if found is None else found.start()
        parts.append(np.array(text[place:end].split(), dtype))
        place = end
    return np.concatenate(parts) if parts else np.empty(0, dtype)


def whole_numbers(values: np.ndarray) -> np.ndarray:
    """The numbers as int64; ValueError for one that is not whole, or too large for a double to be exact."""
    if values.dtype.kind != "f":
        return values.astype(np.int64)
    wrong = ~((np.abs(values) < _LARGEST_WHOLE) & (values == np.rint(values)))
    if wrong.any():
        raise ValueError(f"{values[wrong][0]:g} is not a whole number, or too large")
    return values.astype(np.int64)


def array_bytes(shape: tuple[int, ...], dtype: np.dtype) -> int:
    """Size of an array in bytes; ValueError for an impossible shape or type."""
    if any(length < 0 for length in shape) or dtype.hasobject:
        raise ValueError(f"an array of shape {shape} and type {dtype}")
    return math.prod(shape) * dtype.itemsize
