# SPDX-License-Identifier: GPL-3.0-or-later
"""The border that data from outside crosses: files of other programs, and what files and objects have kept as text.

Each reader works inside :func:`border`, where every error that damaged data can raise becomes one line, and asks
:func:`check_promise` or :func:`read_bytes` before it allocates what a file promises. Errors of our own outside a reader
are not touched.
"""

import math
import re
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tokenize import TokenError
from zipfile import BadZipFile

import numpy as np
from numpy.typing import DTypeLike

from ..errors import MeshError, SettingError, SynchError
from ..memory import check_memory

# What damaged data raises while it is read. RuntimeError is an encrypted member of an archive, or one of an unknown
# compression; SyntaxError is damaged XML, or a damaged header of an array.
UNREADABLE = (
    *(ValueError, TypeError, AttributeError, LookupError, ArithmeticError, StopIteration, EOFError),
    *(RuntimeError, SyntaxError, TokenError, BadZipFile, zlib.error, struct.error),
)
# Characters of a text whose numbers are made at once: each of them is a Python object of about 60 bytes for a moment.
_AT_ONCE = 1 << 20
# Bytes of memory for each byte of a text file while it is read: the file, its text, its parts, and the numbers.
TEXT_BYTES = 8
# The same of a file of settings, whose words become Python objects.
SETTINGS_BYTES = 100
# The largest whole number that a double tells from its neighbours.
_LARGEST_WHOLE = 2**53


@contextmanager
def border(source: str | Path, remedy: str = "export it again") -> Iterator[None]:
    """Turn what damaged data raises inside into one line that names its source and a remedy.

    Parameters
    ----------
    source : path of the file, or what the data is, such as "the result that Body keeps"
    remedy : what helps

    Raises
    ------
    SettingError
        for damaged data, files that cannot be opened, and more data than memory holds
    SynchError
        of a reader's own, with the source in front where it names none
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
    """Refuse so many bytes that a file promises where memory does not hold them, before they are allocated."""
    check_memory(size, str(path), reserved=1.0)


def read_bytes(path: str | Path, each: int = 1) -> bytes:
    """The bytes of a file, refused before they are read where memory does not hold ``each`` times as many."""
    check_promise(path, each * Path(path).stat().st_size)
    return Path(path).read_bytes()


def read_text(path: str | Path, each: int = TEXT_BYTES, encoding: str = "utf-8") -> str:
    """The text of a file, as :func:`read_bytes` reads its bytes."""
    return read_bytes(path, each).decode(encoding)


def text_numbers(text: str, dtype: DTypeLike = float) -> np.ndarray:
    """(n,) numbers of a text, made a part at a time so that they take no more memory than the text.

    Raises
    ------
    ValueError, OverflowError
        for a word that is not a number of the kind
    """
    parts, place = [], 0
    while place < len(text):
        found = re.compile(r"\s").search(text, place + _AT_ONCE)
        end = len(text) if found is None else found.start()
        parts.append(np.array(text[place:end].split(), dtype))
        place = end
    return np.concatenate(parts) if parts else np.empty(0, dtype)


def whole_numbers(values: np.ndarray) -> np.ndarray:
    """The same numbers as int64; ValueError for one that is not whole, or that a double cannot tell from others."""
    if values.dtype.kind != "f":
        return values.astype(np.int64)
    wrong = ~((np.abs(values) < _LARGEST_WHOLE) & (values == np.rint(values)))
    if wrong.any():
        raise ValueError(f"the number {values[wrong][0]:g}")
    return values.astype(np.int64)


def array_bytes(shape: tuple[int, ...], dtype: np.dtype) -> int:
    """Bytes of an array; ValueError for a shape that no array has."""
    if any(length < 0 for length in shape) or dtype.hasobject:
        raise ValueError(f"an array of shape {shape} and type {dtype}")
    return math.prod(shape) * dtype.itemsize
