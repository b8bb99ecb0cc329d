# SPDX-License-Identifier: GPL-3.0-or-later
"""Where Blender's own OpenVDB module is."""

import importlib.util
import sys
from functools import cache
from pathlib import Path

import bpy

from ...core.files import openvdb


@cache
def module_file():
    """Path of the module in the bpy wheel, which keeps it beside its scripts; None if it can be imported by name, or is
    missing."""
    if importlib.util.find_spec("openvdb") is not None:
        return None
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    folder = Path(bpy.utils.resource_path("LOCAL")) / "python" / "lib" / version / "site-packages"
    found = [path for suffix in ("so", "pyd") for path in sorted(folder.glob(f"*openvdb*.{suffix}"))]
    return str(found[0]) if found else None


def openvdb_module():
    """Blender's own OpenVDB module; raises SettingError in Blenders without it."""
    return openvdb.openvdb_module(module_file())
