# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the library of assets from the code of the add-on; prints the path of its .blend.

    python tools/assets.py [--folder synch_addon/looks/library]

Needs the oldest supported Blender as a module (bpy 4.5), so that all of them can read the file, which is kept with the
program: no two files that Blender writes are the same, and a zip has to be. A test compares it with the code.
"""

import argparse
import sys
from pathlib import Path

import bpy

from synch_fields.synch_addon.looks import assets

OLDEST = 4, 5


def main() -> int:
    parser = argparse.ArgumentParser(description="Make the library of assets.")
    parser.add_argument("--folder", type=Path, default=assets.FOLDER, metavar="DIR")
    options = parser.parse_args()
    if bpy.app.version[:2] != OLDEST:
        print(f"assets: older ones cannot read what Blender {bpy.app.version_string} writes: use 4.5", file=sys.stderr)
        return 1
    bpy.ops.wm.read_factory_settings(use_empty=True)
    print(assets.write_library(options.folder))
    return 0


if __name__ == "__main__":
    sys.exit(main())
