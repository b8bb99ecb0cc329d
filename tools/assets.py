# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the library of assets from the code of the add-on; prints the path of its .blend.

    python tools/assets.py [--folder synch_addon/looks/library]

`tools/extension.py` does this for the zip; in a checkout the library is only there once this was run. Needs Blender as
a module (bpy).
"""

import argparse
from pathlib import Path

import bpy

from synch_fields.synch_addon.looks import assets


def main() -> None:
    parser = argparse.ArgumentParser(description="Make the library of assets.")
    parser.add_argument("--folder", type=Path, default=assets.FOLDER, metavar="DIR")
    options = parser.parse_args()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    print(assets.write_library(options.folder))


if __name__ == "__main__":
    main()
