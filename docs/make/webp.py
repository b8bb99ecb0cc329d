# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Animated WebP files, from still ones and back: a container around the frames' own bytes.

Google's "WebP Container Specification" (RFC 9649): a RIFF file of chunks, each a name of four letters, its size in 32
bits, and its bytes, padded to an even number. Blender writes and reads still files only.
"""

import struct

# Of the header VP8X, the bit that says "animation"; of each frame, the bit that says "do not blend".
_ANIMATED, _REPLACES = 0x02, 0x02


def animated(stills, size, milliseconds):
    """The bytes of an animated file that shows still, opaque WebP files of one size (width, height) for so many
    milliseconds each, for ever."""
    sides = b"".join(_in_three_bytes(side - 1) for side in size)
    chunks = [_chunk(b"VP8X", bytes([_ANIMATED, 0, 0, 0]) + sides), _chunk(b"ANIM", bytes(6))]
    for still, shown in zip(stills, milliseconds, strict=True):
        head = bytes(6) + sides + _in_three_bytes(shown) + bytes([_REPLACES])
        chunks.append(_chunk(b"ANMF", head + _chunk(*_picture(still))))
    return _file(chunks)


def frames(data):
    """Bytes of the still files that an animated one holds, and the milliseconds for which each is shown."""
    found = [body for name, body in _chunks(data[12:]) if name == b"ANMF"]
    stills = [_file([_chunk(*_picture(bytes(12) + body[16:]))]) for body in found]
    return stills, [int.from_bytes(body[12:15], "little") for body in found]


def _picture(still):
    return next((name, body) for name, body in _chunks(still[12:]) if name in (b"VP8 ", b"VP8L"))


def _chunks(data):
    start = 0
    while start < len(data):
        name, size = struct.unpack_from("<4sI", data, start)
        yield name, data[start + 8 : start + 8 + size]
        start += 8 + size + size % 2


def _chunk(name, body):
    return name + struct.pack("<I", len(body)) + body + bytes(len(body) % 2)


def _file(chunks):
    body = b"WEBP" + b"".join(chunks)
    return b"RIFF" + struct.pack("<I", len(body)) + body


def _in_three_bytes(number):
    return number.to_bytes(3, "little")
