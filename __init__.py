# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Synch Fields: stripes and direction fields from one synchronization problem with a proved lower bound.

Blender loads this package as an extension and calls `register`. Plain Python imports `synch_fields.core`,
which needs NumPy and SciPy only; importing the package never imports bpy.
"""

__version__ = "0.1.0"


def register() -> None:
    """Add the operators, panels and commands to Blender."""
    from . import synch_addon

    synch_addon.register()


def unregister() -> None:
    """Take everything that `register` added out of Blender again."""
    from . import synch_addon

    synch_addon.unregister()
