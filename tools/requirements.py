# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Install what is missing in the environment whose Python runs this; what works in it is not changed.

    VENV/bin/python tools/requirements.py [--only] [NAME ...]

tools/environment.py calls it, once the environment is there, with the same arguments. The program itself is installed
only where it is missing, as an editable one: an environment that was made for another checkout stays with that one.
`make` runs this checkout's code in any of them, by the link out/tree/synch_fields, which this makes.
"""

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
# What works, where the project's own pin only says what is to be fetched.
ENOUGH = {"bpy": SpecifierSet(">=4.5")}


def main(arguments: list[str]) -> int:
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
    lacking = [*missing(wanted, ENOUGH), *missing(chosen.values(), {})]
    if not is_alone and not is_there(NAME):
        lacking += ["--editable", str(ROOT)]
    return pip("install", *lacking) if lacking else 0


def link() -> None:
    """The folder that PYTHONPATH names: in it, this checkout has the package's name."""
    place = ROOT / "out" / "tree" / NAME
    if place.resolve() != ROOT:
        place.parent.mkdir(parents=True, exist_ok=True)
        place.unlink(missing_ok=True)
        place.symlink_to(ROOT, target_is_directory=True)


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
    return subprocess.call([sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", *arguments])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
