# SPDX-License-Identifier: GPL-3.0-or-later
"""All settings, declared once: each group of settings is a frozen dataclass whose fields have records."""

from .bake import BakeSettings
from .flow import FlowSettings
from .layers import LayerSettings
from .lines import LineSettings
from .setting import Choice, Setting, SettingsRecord, records, setting
from .solver import SolverSettings
from .surface import SurfaceSettings

__all__ = [
    "BakeSettings",
    "Choice",
    "FlowSettings",
    "LayerSettings",
    "LineSettings",
    "Setting",
    "SettingsRecord",
    "SolverSettings",
    "SurfaceSettings",
    "records",
    "setting",
]
