# SPDX-License-Identifier: GPL-3.0-or-later
"""Which file a volume object shows."""

import re
from pathlib import Path

import bpy

from ...core.errors import SettingError

# The number at the end of the name of a sequence's file, as Blender finds it.
_NUMBER = re.compile(r"(\d+)(?=\D*$)")


def shown_file(obj):
    """The file that a volume object shows at the scene's present frame; raises SettingError without one."""
    volume = obj.data
    if not volume.filepath:
        raise SettingError(f"the volume {obj.name} has no file: save it as .vdb and choose that")
    if volume.is_sequence:
        return played_file(volume, bpy.context.scene.frame_current)
    return Path(bpy.path.abspath(volume.filepath, library=volume.library))


def played_file(volume, frame):
    """The file that a volume shows at a frame of the scene, by Blender's own rule.

    Raises SettingError outside a sequence that is shown at its own frames alone, and for a file without a number.
    """
    path = Path(bpy.path.abspath(volume.filepath, library=volume.library))
    found = _NUMBER.search(path.name)
    count = volume.frame_duration
    number = frame - volume.frame_start + 1
    if count == 0:
        raise SettingError(f"the sequence of {path.name} has 0 frames: set how many in the volume's properties")
    if volume.sequence_mode == "CLIP" and not 1 <= number <= count:
        raise SettingError(f"frame {frame} lies outside the sequence of {path.name}: choose frames that it has")
    if volume.sequence_mode == "EXTEND":
        number = min(max(number, 1), count)
    elif volume.sequence_mode == "REPEAT":
        number = (number - 1) % count + 1
    elif volume.sequence_mode == "PING_PONG":
        there = (number - 1) % max(2 * count - 2, 1)
        number = 1 + min(there, 2 * count - 2 - there)
    if found is None:
        raise SettingError(f"{path}: has no number in its name: choose the first file of a sequence")
    digits = f"{number + volume.frame_offset:0{len(found[1])}d}"
    return path.with_name(path.name[: found.start()] + digits + path.name[found.end() :])
