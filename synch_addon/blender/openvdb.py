# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own OpenVDB module."""

import importlib.util
import sys
from functools import cache
from pathlib import Path

import bpy

from ...core.errors import SettingError


@cache
def openvdb_module():
    """Blender's own OpenVDB module, which the bpy wheel keeps beside its scripts."""
    try:
        import openvdb
    except ImportError:
        folder = Path(bpy.utils.resource_path("LOCAL")) / "python" / "lib"
        name = f"python{sys.version_info.major}.{sys.version_info.minor}/site-packages"
        for found in sorted((folder / name).glob("*openvdb*.so")) + sorted((folder / name).glob("*openvdb*.pyd")):
            module_name = found.name.split(".")[0]
            spec = importlib.util.spec_from_file_location(module_name, found)
            openvdb = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(openvdb)
            return openvdb
        raise SettingError("this Blender has no OpenVDB module: use another one, or flows as .npz") from None
    return openvdb
