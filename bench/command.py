# SPDX-License-Identifier: GPL-3.0-or-later
"""The command lines of benchmarks and pictures."""

import argparse
import tempfile
from pathlib import Path

import synch_fields


def arguments(text, meshes="", folder=""):
    """A parser; ``meshes`` are what the first argument's folder holds, ``folder`` what goes to another one."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    if meshes:
        parser.add_argument("meshes", type=Path, help=f"folder with {meshes}")
    if folder:
        parser.add_argument("--folder", type=Path, default=Path("docs"), help=f"where {folder} (%(default)s)")
    return parser


def make_pictures(parser, pictures):
    """Make each picture, or the one that is asked for, by its function of the options, a folder and its path."""
    parser.add_argument("--only", choices=pictures, help="the name of one picture")
    options = parser.parse_args()
    synch_fields.register()
    for name, make in pictures.items():
        if options.only in (None, name):
            with tempfile.TemporaryDirectory() as folder:
                make(options, Path(folder), options.folder / f"{name}.png")
    synch_fields.unregister()
