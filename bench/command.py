# SPDX-License-Identifier: GPL-3.0-or-later
"""The command lines of benchmarks and pictures."""

import argparse
from pathlib import Path


def arguments(text, meshes="", folder=""):
    """A parser; ``meshes`` are what the first argument's folder holds, ``folder`` what goes to another one."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    if meshes:
        parser.add_argument("meshes", type=Path, help=f"folder with {meshes}")
    if folder:
        parser.add_argument("--folder", type=Path, default=Path("docs"), help=f"where {folder} (%(default)s)")
    return parser
