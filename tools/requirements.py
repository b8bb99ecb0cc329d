# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Install what is missing in the environment whose Python runs this; what works in it is not changed.

    VENV/bin/python tools/requirements.py [--only] [--latest] [NAME ...]

tools/environment.py calls it, once the environment is there, with the same arguments. The program itself is installed
only where it is missing, as an editable one: an environment that was made for another checkout stays with that one.
`make` runs this checkout's code in any of them, by the link out/tree/synch_fields, which this makes.

The versions that are installed are those of requirements/python3.*.txt; with --latest, everything is brought to the
newest versions that pyproject.toml allows.

    VENV/bin/python tools/requirements.py --lock

writes the versions that are installed to the file of this Python, without Blender, whose version pyproject.toml says.
"""

import os
import subprocess
import sys
import tomllib
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

from pip._vendor.packaging.requirements import Requirement
from pip._vendor.packaging.specifiers import SpecifierSet

ROOT = Path(__file__).resolve().parent.parent
NAME = "synch_fields"
# The versions to install: one file for each minor version of Python.
LOCK = ROOT / "requirements" / "python{}.{}.txt".format(*sys.version_info)
# What works, where the project's own pin only says what is to be fetched.
ENOUGH = {"bpy": SpecifierSet(">=4.5")}


def main(arguments: list[str]) -> int:
    if arguments == ["--lock"]:
        return lock()
    read = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project = read["project"]
    lists = project["optional-dependencies"] | read["dependency-groups"]
    chosen = {Requirement(text).name: text for text in arguments if "=" in text}
    is_alone = "--only" in arguments
    wanted = [] if is_alone else [*project["dependencies"]]
    for name in arguments:
        wanted += lists.get(name, [])
    wanted = [text for text in wanted if Requirement(text).name not in chosen]
    link()
    if "--latest" in arguments:
        versions = ["--upgrade", "--upgrade-strategy", "eager"]
        lacking = [*wanted, *chosen.values()]
    else:
        versions = ["--constraint", str(LOCK)]
        lacking = [*missing(wanted, ENOUGH), *missing(chosen.values(), {})]
    if not is_alone and not is_there(NAME):
        lacking += ["--editable", str(ROOT)]
    return pip("install", *versions, *lacking) if lacking else 0


def lock() -> int:
    command = [
        sys.executable,
        "-m",
        "pip",
        "freeze",
        "--all",
        "--exclude-editable",
        "--exclude",
        "bpy",
        "--exclude",
        "pip",
    ]
    result = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if result.returncode == 0:
        LOCK.write_text(f"# Written by make lock.\n{result.stdout}", encoding="utf-8")
    return result.returncode


def link() -> None:
    """The folder that PYTHONPATH names: in it, this checkout has the package's name."""
    place = ROOT / "out" / "tree" / NAME
    if place.resolve() != ROOT:
        place.parent.mkdir(parents=True, exist_ok=True)
        made = place.with_name(f"{NAME}.{os.getpid()}")
        made.symlink_to(ROOT, target_is_directory=True)
        made.replace(place)  # at once: environments may be made side by side


def missing(wanted: Iterable[str], enough: dict[str, SpecifierSet]) -> list[str]:
    """Those requirements that are not met here, where for some names other versions are enough."""
    lacking = []
    for text in wanted:
        requirement = Requirement(text)
        if requirement.marker is not None and not requirement.marker.evaluate():
            continue
        works = enough.get(requirement.name, requirement.specifier)
        if not is_there(requirement.name) or not works.contains(metadata.version(requirement.name), prereleases=True):
            lacking.append(text)
    return lacking


def is_there(name: str) -> bool:
    try:
        metadata.version(name)
    except metadata.PackageNotFoundError:
        return False
    return True


def pip(*arguments: str) -> int:
    """Run pip. Modules are compiled when they are first imported: most of the 5,500 never are."""
    command = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", *arguments, "--no-compile"]
    return subprocess.call(command)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
