# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages between two processes: pickled objects whose arrays travel beside them through a pipe.

A parcel is a mark, the number of its parts, their sizes, and the parts, each filled up to whole blocks: the pickle,
then its arrays (pickle protocol 5), which are used where they lie. Only a process that was started for it is at the
other end: what is unpickled here is our own.
"""

import io
import pickle
import struct
from itertools import accumulate

import numpy as np

# Begins every parcel: whatever else a process writes to the same pipe is told from one.
MARK = b"\x00synch parcel\x01\n\x00"
_NUMBER = struct.Struct("<Q")
# Where arrays may begin.
_BLOCK = 64
# What says that it has more parts than this, or more bytes than any machine, is no parcel.
_MOST_PARTS, _MOST_BYTES = 1 << 20, 1 << 44


class BrokenParcel(Exception):
    """Bytes that are no parcel."""


def pack_parts(message, shared=()):
    """The parts of a parcel, bytes-like, in the order in which they are to be written.

    Parameters
    ----------
    message : any object that can be pickled
    shared : objects that the other end has as well: they travel as their place in this sequence
    """
    arrays: list[pickle.PickleBuffer] = []
    stream = io.BytesIO()
    _Pickler(stream, shared, arrays.append).dump(message)
    parts = [memoryview(stream.getvalue()), *(array.raw() for array in arrays)]
    pieces: list = [MARK + b"".join(map(_NUMBER.pack, [len(parts), *(part.nbytes for part in parts)]))]
    for part in parts:
        pieces += [part, bytes(-part.nbytes % _BLOCK)]
    return [piece for piece in pieces if len(piece)]


class _Pickler(pickle.Pickler):
    def __init__(self, stream, shared, keep):
        super().__init__(stream, protocol=5, buffer_callback=keep)
        self._places = {id(one): place for place, one in enumerate(shared)}

    def persistent_id(self, one):
        return self._places.get(id(one))


class _Unpickler(pickle.Unpickler):
    def __init__(self, stream, shared, buffers):
        super().__init__(stream, buffers=buffers)
        self._shared = shared

    def persistent_load(self, place):
        return self._shared[place]


class Unpacker:
    """Puts parcels together from bytes as they come.

    Attributes
    ----------
    shared : objects that stand for their places, see :func:`pack_parts`
    """

    def __init__(self, shared=()):
        self.shared = shared
        self._head = bytearray()
        self._sizes: list[int] | None = None
        self._body, self._filled = np.empty(0, np.uint8), 0

    @property
    def is_amid(self):
        """Whether a parcel has begun and is not whole yet."""
        return len(self._head) > 0

    def feed(self, data):
        """The messages that are whole with some more bytes.

        Raises
        ------
        BrokenParcel
            where the bytes cannot be a parcel, or what it holds cannot be read
        """
        data, messages = memoryview(data), []
        while len(data):
            data = data[self._take(data) :]
            if self._sizes is not None and self._filled == len(self._body):
                messages.append(self._opened())
        return messages

    def _take(self, data):
        """Use up bytes of one parcel; returns how many."""
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
        total = sum(map(_whole, self._sizes))
        if total > _MOST_BYTES:
            raise BrokenParcel(f"it has {total} bytes")
        # Not a bytearray: filling hundreds of megabytes with zeros takes its time, at once.
        self._body, self._filled = np.empty(total, np.uint8), 0
        return taken

    @property
    def _head_length(self):
        """Bytes of the head, as far as that is known."""
        counted = len(MARK) + _NUMBER.size
        if len(self._head) < counted:
            return counted
        count = self._number(0)
        if not 0 < count <= _MOST_PARTS:
            raise BrokenParcel(f"it has {count} parts")
        return counted + _NUMBER.size * count

    def _number(self, place):
        return _NUMBER.unpack_from(self._head, len(MARK) + _NUMBER.size * place)[0]

    def _opened(self):
        body, sizes = memoryview(self._body), self._sizes or []
        starts = accumulate(map(_whole, sizes), initial=0)
        parts = [body[start : start + size] for start, size in zip(starts, sizes, strict=False)]
        self._head, self._sizes, self._body, self._filled = bytearray(), None, np.empty(0, np.uint8), 0
        try:
            return _Unpickler(io.BytesIO(parts[0]), self.shared, parts[1:]).load()
        except MemoryError:
            raise
        except Exception as error:  # whatever bytes can do to an unpickler
            raise BrokenParcel(f"{type(error).__name__}: {error}") from error


def _whole(size):
    return size + -size % _BLOCK
