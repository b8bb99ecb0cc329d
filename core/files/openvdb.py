# SPDX-License-Identifier: GPL-3.0-or-later
"""The OpenVDB module, which only Blender has."""

import importlib
import importlib.util
from functools import cache
from pathlib import Path
from types import ModuleType

from ..errors import SettingError


@cache
def openvdb_module(file: str | None = None) -> ModuleType:
    """The module, loaded once.

    Parameters
    ----------
    file : path of the compiled module; None where it is found by its name

    Raises
    ------
    SettingError
        where there is none
    """
    try:
        if file is None:
            return importlib.import_module("openvdb")
        spec = importlib.util.spec_from_file_location(Path(file).name.split(".")[0], file)
        if spec is None or spec.loader is None:
            raise ImportError(file)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    except ImportError:
        raise SettingError("this Blender has no OpenVDB module: use another one, or flows as .npz") from None
    return module
