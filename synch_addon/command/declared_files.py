# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of each command, declared once: what it reads, with the files whose content counts, and what it writes.

The check for clashes, the keys of a batch's rows, the check between these rows and the making of folders ask here.
"""

import math
import os
import re
from pathlib import Path

import bpy

from ...core.errors import SettingError
from ...core.files.declared import DeclaredFile
from ...core.settings.bake import BakeSettings
from ...core.settings.guidance import parse_guidance
from ...core.settings.layers import LayerGuide
from ...core.validation import check_path
from ..bakes.images import file_name
from .settings import settings_of

# Options of all commands that name one file; the others are declared by functions below.
READ = {"input": "the input", "constraints": "--constraints", "machine": "--machine"}
WRITTEN = "output", "render", "report", "export_mesh", "export_field", "export_layers", "export_paths"
WRITTEN += "export_gcode", "export_volume", "export_filaments"
# The option that stands for a numbered set.
_NUMBERED = "export_layers"
# Those whose names mean the same to the system and to Blender.
_PLAIN = "the input", "--constraints", "--output", "--render", "--report", "--export-mesh"
# What a command's --folder gets.
DEMO = {"output": "demo.blend", "render": "demo.png", "report": "demo.json"}
# Digits of a frame's number that are read: Python takes no more than some thousand.
_DIGITS = 18
SUMMARY = "summary.csv", "summary.json", "sheet.html"


def declared_files(options):
    """The :class:`DeclaredFile` of all files of a command, those that it reads first.

    Raises SettingError for names that no file can have.
    """
    files = [
        DeclaredFile(path, flag)
        for name, flag in READ.items()
        for path in _frames(options, name) or [getattr(options, name, None)]
        if path
    ]
    if hasattr(options, "input") and not options.input and bpy.data.filepath:
        files.append(DeclaredFile(bpy.data.filepath, "the open file"))
    files += [DeclaredFile(path, "the guidance") for path in _guides(options)]
    if options.command == "batch":
        files.append(DeclaredFile(options.rows, "the rows"))
    for name in WRITTEN:
        path = getattr(options, name, None)
        if path:
            flag = f"--{name.replace('_', '-')}"
            files.append(DeclaredFile(path, flag, is_written=True, is_numbered=name == _NUMBERED))
    files += [DeclaredFile(str(path), "--folder", is_written=True) for path in _in_folder(options)]
    return [_absolute_path(file, options) for file in files]


def _absolute_path(file, options):
    """A file with its whole name; // is the folder of the .blend that is the input, or else of the open one."""
    path = check_path(file.path, file.flag)
    if path.startswith("//") and file.flag not in _PLAIN:
        blend = str(getattr(options, "input", None) or bpy.data.filepath)
        path = str(Path(blend).parent / path[2:])
    return DeclaredFile(path, file.flag, file.is_written, file.is_numbered)


def _frames(options, name):
    """Files of the frames of a sequence that are there, whose name has # for each digit of their numbers."""
    given = getattr(options, name, None)
    if name != "input" or not given or "#" not in Path(given).name:
        return []
    path, frames = Path(check_path(given, READ[name])), getattr(options, "frames", None)
    pattern = re.compile(re.sub(r"(?:\\#)+", r"(\\d+)", re.escape(path.name)))
    try:
        found = [(pattern.fullmatch(each.name), str(each)) for each in path.parent.iterdir()]
    except OSError:
        return []
    first, last = frames or (0, math.inf)
    return sorted(file for match, file in found if match and first <= int(match[1][-_DIGITS:]) <= last)


def _guides(options):
    """Files that the guidance names; a text that cannot be read is refused by the command itself."""
    text = getattr(options, "guidance", None)
    if not text:
        return []
    try:
        if options.command == "layers":
            guide = LayerGuide.of_text(text)
            return [guide.names[0]] if guide.kind in ("file", "lines") else []
        return [source.name for source in parse_guidance(text) if source.kind == "file"]
    except SettingError:
        return []


def _in_folder(options):
    """Files that go to a command's folder."""
    if options.command == "demo":
        return [Path(options.folder) / name for name in DEMO.values()]
    if options.command == "batch":
        return [Path(options.folder) / name for name in SUMMARY]
    if options.command == "bake" and options.folder:
        return _maps(options)
    return []


def _maps(options):
    """Images of a bake. The name of a file's only object is known once it is open: the file stands for it here."""
    name = options.object or f"object of {os.path.realpath(options.input or bpy.data.filepath)}"
    try:
        settings = settings_of(options, BakeSettings)
    except SettingError:  # the command itself says what is wrong
        return []
    return [Path(options.folder) / file_name(settings, name, each) for each in settings.maps]
