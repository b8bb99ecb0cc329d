# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A virtual display, and pictures of it: Xvfb keeps the screen as an X window dump in a file."""

import os
import struct
import subprocess
import zlib

import numpy as np

# Seconds that a display may take to come up on a busy machine.
_PATIENCE = 60


class Screen:
    """Xvfb on a display of its own.

    Attributes
    ----------
    name : what goes into DISPLAY
    size : width and height in pixels
    """

    def __init__(self, folder, size):
        self.size, self._dump = size, folder / "Xvfb_screen0"
        read, write = os.pipe()
        geometry = f"{size[0]}x{size[1]}x24"
        command = [
            "Xvfb",
            "-displayfd",
            str(write),
            "-screen",
            "0",
            geometry,
            "-fbdir",
            str(folder),
            "-nocursor",
            "-terminate",
        ]
        log = (folder / "xvfb.log").open("wb")
        self._process = subprocess.Popen(command, pass_fds=[write], stdout=log, stderr=log)
        os.close(write)
        with os.fdopen(read) as number:
            self.name = f":{number.readline().strip()}"
        if self.name == ":":
            raise RuntimeError(f"Xvfb did not start: {(folder / 'xvfb.log').read_text()}")

    def picture(self):
        """What the screen shows, (height, width, 3) bytes, first row on top."""
        dump = self._dump.read_bytes()
        header = struct.unpack(">25I", dump[:100])
        size, width, height, line, colours = header[0], header[4], header[5], header[12], header[19]
        start = size + 12 * colours
        pixels = np.frombuffer(dump, np.uint8, line * height, start).reshape(height, line // 4, 4)
        return pixels[:, :width, 2::-1].copy()

    def close(self):
        """End the display."""
        self._process.terminate()
        self._process.wait(_PATIENCE)


def write_png(path, picture):
    """Write (height, width, 3) bytes as a PNG."""
    height, width, _ = picture.shape
    # Filter 1 (what is to the left is subtracted) packs flat interfaces well.
    rows = picture.astype(np.int16)
    rows[:, 1:] -= picture[:, :-1]
    lines = np.column_stack([np.ones(height, np.uint8), (rows & 255).astype(np.uint8).reshape(height, -1)])
    chunks = (
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
        (b"IDAT", zlib.compress(lines.tobytes(), 9)),
        (b"IEND", b""),
    )
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        for kind, data in chunks:
            file.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))
