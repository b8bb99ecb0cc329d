# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The targets that most people want, for systems without `make`, which itself calls this.

    python3 tools/make.py TARGET [--venv DIR] [--python PATH] [--blender VERSION] [ARGUMENT ...]

The environment is made or completed first. Further arguments go to the program that the target runs, for instance
`python3 tools/make.py test tests/core -x`. This script needs Python 3.8 or later and nothing else; the environment gets
a Python that Blender has a module for.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys

import environment
from environment import ROOT

# The arguments of Python for each program that a target runs, one after the other.
TARGETS = {
    "environment": [],
    "demo": [["-m", "synch_fields", "demo"]],
    "test": [["-m", "pytest", "-m", "not slow"]],
    "test-slow": [["-m", "pytest", "-m", "slow"]],
    "lint": [["-m", "ruff", "check"], ["-m", "ruff", "format", "--check"], ["-m", "mypy", "core"]],
    "extension": [["tools/extension.py"]],
}
NAMES = ["blender", "test", "lint", "package"]


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Make the environment of this checkout and run a target in it.")
    parser.add_argument("target", choices=TARGETS)
    environment.add_options(parser)
    parser.add_argument("--blender", metavar="VERSION", help="another version of Blender's module than the pinned one")
    options, further = parser.parse_known_args(arguments)
    chosen = [f"bpy=={options.blender}"] if options.blender else []
    programs = TARGETS[options.target]
    if further and not programs:
        parser.error(f"{options.target} takes no further arguments: {' '.join(further)}")
    status = environment.complete(options, [*NAMES, *chosen])
    for program in programs:
        if status == 0:
            status = run(options.venv, [*program, *(further if program is programs[-1] else [])])
    return status


def run(venv, arguments: list[str]) -> int:
    """The status of the environment's Python with these arguments; the code that it runs is this checkout's."""
    settings = {**os.environ, "PYTHONPATH": str(ROOT / "out" / "tree")}
    return subprocess.call([str(environment.python_of(venv)), *arguments], cwd=ROOT, env=settings)


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
