# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the environment of a checkout, or complete it, on a machine that has a Python and nothing else.

    python3 tools/environment.py [--venv .venv] [--versions "3.13 3.11"] [--python PATH] [--latest] [--only] NAME ...

A NAME is an extra or a dependency group of pyproject.toml, or a requirement such as bpy==5.2.3. With --only, neither
the program nor its own dependencies are installed; with --latest, the newest versions instead of those that
requirements/ lists. This script runs on any Python 3.8 or later. It looks for one that Blender has a module for, and
for the libraries which that links to, before anything is downloaded.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import shutil
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# The Pythons that Blender has a module for, in order of preference.
VERSIONS = ("3.13", "3.11")
# What Blender's module links to and a bare Linux lacks, with the Debian package of each.
LIBRARIES = {
    "libX11.so.6": "libx11-6",
    "libXext.so.6": "libxext6",
    "libXrender.so.1": "libxrender1",
    "libXfixes.so.3": "libxfixes3",
    "libXi.so.6": "libxi6",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libSM.so.6": "libsm6",
    "libICE.so.6": "libice6",
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",  # opened when something is drawn without a window
}
# Each prints the version of its Python: the second only with pip, the third only where Python can make environments.
VERSION = "import sys; print('%d.%d' % sys.version_info[:2])"
WITH_PIP = f"import pip; {VERSION}"
WITH_VENV = f"import ensurepip, venv; {VERSION}"


class SetupError(Exception):
    """The environment cannot be made; the message is one line that says why and what helps."""


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Make or complete the environment of this checkout.")
    add_options(parser)
    parser.add_argument("--only", action="store_true", help="without the program and its own dependencies")
    parser.add_argument("names", nargs="*", metavar="NAME")
    options = parser.parse_args(arguments)
    return complete(options, [*(["--only"] if options.only else []), *options.names])


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say which environment is meant and which Python it gets."""
    parser.add_argument("--venv", type=lambda text: Path(text).absolute(), default=ROOT / ".venv", metavar="DIR")
    parser.add_argument("--versions", default=" ".join(VERSIONS), help="accepted Pythons, the best first")
    parser.add_argument("--python", metavar="PATH", help="the Python to use, instead of the first that is found")
    parser.add_argument("--latest", action="store_true", help="the newest versions, instead of those in requirements/")


def complete(options: argparse.Namespace, names: list[str]) -> int:
    """Make the environment where it is missing, and install what of the names is missing in it: the exit status."""
    try:
        if any(name.startswith(("blender", "bpy")) for name in names):
            provide_libraries()
        executable = provide_python(options.venv, options.versions.split(), options.python)
    except SetupError as error:
        print(f"environment: {error}", file=sys.stderr)
        return 1
    latest = ["--latest"] if options.latest else []
    return subprocess.call([str(executable), str(ROOT / "tools" / "requirements.py"), *latest, *names])


def provide_python(folder: Path, versions: list[str], named: str | None) -> Path:
    """The Python of the environment in a folder, which is made where it is missing or lacks pip."""
    executable = python_of(folder)
    version = answer([str(executable)], WITH_PIP)
    if version and version not in versions:
        raise SetupError(f"{folder} has Python {version} instead of {' or '.join(versions)}: remove it or name another")
    if not version:
        command = find_python(versions, named)
        print(f"environment: {' '.join(command)} makes {folder}", file=sys.stderr)
        if subprocess.call([*command, "-m", "venv", str(folder)]) or not answer([str(executable)], WITH_PIP):
            raise SetupError(f"no environment could be made in {folder}: remove the folder and try again")
    return executable


def python_of(folder: Path) -> Path:
    """The Python of an environment."""
    return folder / "Scripts" / "python.exe" if os.name == "nt" else folder / "bin" / "python"


def provide_libraries() -> None:
    """See that Blender's module can be loaded: apt-get, run as root, installs the libraries that are missing."""
    missing = missing_libraries()
    if not missing:
        return
    packages = [LIBRARIES[name] for name in missing]
    if shutil.which("apt-get") is None:
        raise SetupError(f"Blender needs libraries that are missing; install the packages of {', '.join(missing)}")
    if os.geteuid() != 0:
        raise SetupError(f"Blender needs libraries that are missing; run: sudo apt-get install -y {' '.join(packages)}")
    print(f"environment: installing {' '.join(packages)}", file=sys.stderr)
    with one_at_a_time():
        if not missing_libraries():
            return  # another environment, made side by side with this one, has installed them
        apt_get("update")  # where that fails, the lists that are there may do
        if apt_get("install", "-y", "--no-install-recommends", *packages) or missing_libraries():
            raise SetupError(f"apt-get could not install {' '.join(packages)}: its message is above")


@contextmanager
def one_at_a_time():
    """Wait until no other environment of this checkout installs libraries."""
    import fcntl  # not on Windows, where there is nothing to install

    folder = ROOT / "out"
    folder.mkdir(exist_ok=True)
    with open(folder / "libraries.lock", "w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def apt_get(*arguments: str) -> int:
    """The status of apt-get, which asks nothing and prints errors alone."""
    settings = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    return subprocess.call(["apt-get", "-qq", *arguments], stdout=subprocess.DEVNULL, env=settings)


def missing_libraries() -> list[str]:
    """Names of the libraries that cannot be loaded on this Linux; on other systems Blender's module brings them."""
    return [name for name in LIBRARIES if not loads(name)] if sys.platform == "linux" else []


def loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def find_python(versions: list[str], named: str | None = None) -> list[str]:
    """The command of the best Python that runs, has one of the versions and can make environments."""
    others, lacking = set(), ""
    for version in versions:
        for command in [[named]] if named else candidates(version):
            found = answer(command, VERSION)
            if found == version and answer(command, WITH_VENV):
                return command
            lacking = version if found == version else lacking
            others |= {found} - {"", version}
    if lacking:
        command = f"on Debian, apt-get install python{lacking}-venv"
        raise SetupError(f"Python {lacking} lacks its modules venv and ensurepip: install them ({command})")
    nothing = f"{named} does not run" if named else "no Python runs"
    there = f"only {' and '.join(sorted(others))} runs" if others else nothing
    raise SetupError(
        f"Python {' or '.join(versions)} is needed, since Blender's module exists for these, and {there}: "
        "install one, or name it (make PYTHON=path, or tools/make.py --python path)"
    )


def candidates(version: str) -> list[list[str]]:
    """Commands that may start this version of Python: its own name, Windows' launcher, pyenv's, the default ones."""
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv", "versions")
    kept = [[str(path)] for path in sorted(pyenv.glob(f"{version}.*/bin/python"), reverse=True)]
    launcher = [["py", f"-{version}"]] if os.name == "nt" else []
    return [[f"python{version}"], *launcher, *kept, [sys.executable], ["python3"], ["python"]]


def answer(command: list[str], program: str) -> str:
    """What a program of one line prints on the Python that a command starts, "" where either does not work."""
    try:
        result = subprocess.run([*command, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    except OSError:
        return ""
    return result.stdout.strip() if result.returncode == 0 else ""


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
