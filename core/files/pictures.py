# SPDX-License-Identifier: GPL-3.0-or-later
"""Image files, looked at without their pixels: whether one was written to its end."""

from pathlib import Path

# What files of a kind end with; the other kinds tell errors while they are written.
_ENDS = {".png": b"IEND\xaeB`\x82", ".jpg": b"\xff\xd9", ".jpeg": b"\xff\xd9"}


def is_whole(path: str | Path) -> bool:
    """Whether an image file ends as its kind does."""
    end = _ENDS.get(Path(path).suffix.lower(), b"")
    return Path(path).read_bytes().endswith(end)
