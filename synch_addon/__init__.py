# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything of Synch Fields that touches Blender; the mathematics is in ``core``."""

from . import cli, operators, panels, settings

_MODULES = (settings, operators, panels, cli)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    for module in reversed(_MODULES):
        module.unregister()
