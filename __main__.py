# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: python -m synch_fields."""

import sys

from . import register, unregister
from .synch_addon.command.main import main

register()  # a .blend keeps the object's constraints in properties of ours
try:
    status = main(sys.argv[1:])
finally:
    unregister()  # Blender 4.5 crashes at its exit where classes are left
sys.exit(status)
