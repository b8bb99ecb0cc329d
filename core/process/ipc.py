# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages between a process and its children: pickled objects, with their arrays sent separately through the pipe.

A parcel consists of a mark, the number of its parts, their sizes, and the parts, each padded to whole blocks: the
pickle, then its arrays (pickle protocol 5), which are used in place. The other end is always a process that we started,
so that unpickling is safe.
"""

import io
import os
import pickle
import queue
import struct
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from itertools import accumulate
from typing import Any

import numpy as np

# Begins every parcel, and distinguishes it from other output on the same pipe.
MARK = b"\x00synch parcel\x01\n\x00"
_NUMBER = struct.Struct("<Q")
# Bytes that are read at once, and most bytes that a parent reads before the first parcel.
CHUNK, _MOST_NOISE = 1 << 20, 1 << 16
# Alignment of arrays in bytes.
_BLOCK = 64
# Limits on the parts and bytes of a parcel, beyond which its head must be broken.
_MOST_PARTS, _MOST_BYTES = 1 << 20, 1 << 44


class BrokenParcel(Exception):
    """Bytes that do not form a parcel."""


def pack_parts(message: object, shared: Sequence[object] = ()) -> list[bytes | memoryview]:
    """The parts of a parcel, in the order in which they are written.

    ``shared`` are objects that the other end has too: of these, only the index in this sequence is sent.
    """
    arrays: list[pickle.PickleBuffer] = []
    stream = io.BytesIO()
    _Pickler(stream, shared, arrays.append).dump(message)
    parts = [memoryview(stream.getvalue()), *(array.raw() for array in arrays)]
    head = MARK + b"".join(map(_NUMBER.pack, [len(parts), *(part.nbytes for part in parts)]))
    pieces: list[bytes | memoryview] = [head]
    for part in parts:
        pieces += [part, bytes(-part.nbytes % _BLOCK)]
    return [piece for piece in pieces if len(piece)]


class _Pickler(pickle.Pickler):
    def __init__(
        self, stream: io.BytesIO, shared: Sequence[object], keep: Callable[[pickle.PickleBuffer], object]
    ) -> None:
        super().__init__(stream, protocol=5, buffer_callback=keep)
        self._places = {id(one): place for place, one in enumerate(shared)}

    def persistent_id(self, one: object) -> int | None:
        return self._places.get(id(one))


class _Unpickler(pickle.Unpickler):
    def __init__(self, stream: io.BytesIO, shared: Sequence[object], buffers: Iterable[memoryview]) -> None:
        super().__init__(stream, buffers=buffers)
        self._shared = shared

    def persistent_load(self, place: int) -> object:
        return self._shared[place]


class Unpacker:
    """Assembles parcels from incoming bytes; ``shared`` as of :func:`pack_parts`.

    ``after_noise`` skips what a process prints before its first parcel.
    """

    def __init__(self, shared: Sequence[object] = (), after_noise: bool = False) -> None:
        self.shared = shared
        self._noise = b"" if after_noise else None
        self._head = bytearray()
        self._sizes: list[int] | None = None
        self._body, self._filled = np.empty(0, np.uint8), 0

    @property
    def is_amid(self) -> bool:
        """Whether a parcel has begun but is not complete."""
        return len(self._head) > 0

    def feed(self, data: bytes | memoryview) -> list[Any]:
        """The messages that further bytes complete; BrokenParcel if they cannot be read."""
        rest, messages = memoryview(self._without_noise(data)), []
        while len(rest):
            rest = rest[self._take(rest) :]
            if self._sizes is not None and self._filled == len(self._body):
                messages.append(self._unpack())
        return messages

    def _without_noise(self, data: bytes | memoryview) -> bytes | memoryview:
        """The bytes from the first parcel on; empty while none has begun."""
        if self._noise is None:
            return data
        self._noise += data
        start, seen = self._noise.find(MARK), self._noise
        if start >= 0:
            self._noise = None
            return seen[start:]
        if len(seen) > _MOST_NOISE:
            raise BrokenParcel("it does not begin as a message")
        return b""

    def _take(self, data: memoryview) -> int:
        """Take bytes of one parcel; returns their number."""
        if self._sizes is not None:
            count = min(len(data), len(self._body) - self._filled)
            self._body[self._filled : self._filled + count] = np.frombuffer(data[:count], np.uint8)
            self._filled += count
            return count
        taken = 0
        while (missing := self._head_length - len(self._head)) > 0:
            if taken == len(data):
                return taken
            self._head += data[taken : taken + missing]
            taken = min(taken + missing, len(data))
            if not MARK.startswith(self._head[: len(MARK)]):
                raise BrokenParcel("it does not begin as a message")
        self._sizes = [self._number(1 + place) for place in range(self._number(0))]
        total = sum(map(_padded, self._sizes))
        if total > _MOST_BYTES:
            raise BrokenParcel(f"it has {total} bytes")
        # Not a bytearray, which would be filled with zeros first.
        self._body, self._filled = np.empty(total, np.uint8), 0
        return taken

    @property
    def _head_length(self) -> int:
        """Number of bytes of the head, as far as it is known."""
        counted = len(MARK) + _NUMBER.size
        if len(self._head) < counted:
            return counted
        count = self._number(0)
        if not 0 < count <= _MOST_PARTS:
            raise BrokenParcel(f"it has {count} parts")
        return counted + _NUMBER.size * count

    def _number(self, place: int) -> int:
        return int(_NUMBER.unpack_from(self._head, len(MARK) + _NUMBER.size * place)[0])

    def _unpack(self) -> Any:
        """The message of the complete parcel; the next one begins."""
        body, sizes = memoryview(self._body), self._sizes or []
        starts = accumulate(map(_padded, sizes), initial=0)
        parts = [body[start : start + size] for start, size in zip(starts, sizes, strict=False)]
        self._head, self._sizes, self._body, self._filled = bytearray(), None, np.empty(0, np.uint8), 0
        try:
            return _Unpickler(io.BytesIO(parts[0]), self.shared, parts[1:]).load()
        except MemoryError:
            raise
        except Exception as error:  # broken bytes can raise anything here
            raise BrokenParcel(f"{type(error).__name__}: {error}") from error


def take_pipes() -> tuple[int, int]:
    """Descriptors of a child's standard input and output, for parcels alone: what libraries print goes to its standard
    error, and they read nothing.

    On Windows, libraries that query standard input while they are imported would wait for the thread that reads it.
    """
    into, out = os.dup(0), os.dup(1)
    os.dup2(2, 1)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    return into, out


def read_chunks(into: int, chunks: "queue.SimpleQueue[bytes]", leave: Callable[[int], object] = os._exit) -> None:
    """Put incoming bytes into a queue until the pipe is closed, then end the process with ``leave(0)``."""
    try:
        while data := os.read(into, CHUNK):
            chunks.put(data)
    finally:  # without a reader the process would wait for ever
        leave(0)


def send(out: int, message: object, shared: Sequence[object] = ()) -> None:
    """Write a parcel, see :func:`pack_parts`."""
    for part in pack_parts(message, shared):
        rest = memoryview(part).cast("B")
        while len(rest):
            rest = rest[os.write(out, rest) :]


def start_child(
    command: Sequence[str], variables: dict[str, str], is_low: bool = False, pipes: int = subprocess.PIPE
) -> subprocess.Popen[bytes]:
    """A child with unbuffered pipes, without a console, which does not receive its parent's Ctrl-C.

    ``is_low`` lowers its priority on Windows; elsewhere it does so itself. ``pipes``: subprocess.DEVNULL for none.
    """
    kind: dict[str, Any] = {"stdin": pipes, "stdout": pipes, "bufsize": 0, "env": variables}
    if sys.platform == "win32":
        kind["creationflags"] = subprocess.CREATE_NO_WINDOW | subprocess.CREATE_NEW_PROCESS_GROUP
        kind["creationflags"] |= subprocess.BELOW_NORMAL_PRIORITY_CLASS if is_low else 0
    else:
        kind["process_group"] = 0  # in the parent's session: Linux lets no process go behind those of another
    return subprocess.Popen(command, **kind)


def _padded(size: int) -> int:
    return size + -size % _BLOCK
