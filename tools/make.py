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
import shutil
import subprocess
import sys
import tempfile

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
# Processes that run the tests at once, at most: each has a Blender of its own, of about a gigabyte.
MOST_AT_ONCE = 4


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
    if status == 0 and options.target == "test" and further in ([], ["--share", "1/1"]):
        return run_at_once(options.venv, programs[0], min(os.cpu_count() or 1, MOST_AT_ONCE))
    for program in programs:
        if status == 0:
            status = run(options.venv, [*program, *(further if program is programs[-1] else [])])
    return status


def run(venv, arguments: list[str]) -> int:
    """The status of the environment's Python with these arguments; the code that it runs is this checkout's."""
    return start(venv, arguments).wait()


def run_at_once(venv, arguments: list[str], count: int) -> int:
    """The status of all tests, whose files processes share out; what the others print follows that of the first."""
    logs = [None, *(tempfile.TemporaryFile() for _ in range(count - 1))]
    # A core for each: more threads, of solves and of BLAS, would only wait for one another.
    threads = {"SYNCH_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    parts = [start(venv, [*arguments, "--part", f"{k}/{count}"], log, **threads) for k, log in enumerate(logs, 1)]
    status = max(part.wait() for part in parts)
    for log in logs[1:]:
        log.seek(0)
        shutil.copyfileobj(log, sys.stdout.buffer)
    return status


def start(venv, arguments: list[str], log=None, **variables: str) -> subprocess.Popen:
    """The environment's Python with these arguments; ``variables`` are for those that the user has not set.

    Code is compiled once, and not by every process that a test starts."""
    settings = {**variables, **os.environ, "PYTHONPATH": str(ROOT / "out" / "tree"), "PYTHONDONTWRITEBYTECODE": ""}
    return subprocess.Popen([str(environment.python_of(venv)), *arguments], cwd=ROOT, env=settings, stdout=log)


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
