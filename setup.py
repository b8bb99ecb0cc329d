# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What pyproject.toml cannot say: the root is the package `synch_fields`, and its version is the extension's.

A wheel has `core` alone, for plain Python. The rest is for Blender, which takes it as an extension; where Blender is a
module, or the command line is wanted, the checkout itself is installed (pip install --editable), with all of it.
"""

import tomllib
from pathlib import Path

from setuptools import find_packages, setup
from setuptools.command.build_py import build_py

NAME = "synch_fields"
manifest = tomllib.loads(Path(__file__).with_name("blender_manifest.toml").read_text(encoding="utf-8"))


class CoreAlone(build_py):
    """Leaves out the command line, which lies in the root package."""

    def find_package_modules(self, package, package_dir):
        found = super().find_package_modules(package, package_dir)
        return [module for module in found if module[:2] != (NAME, "__main__")]


setup(
    version=manifest["version"],
    packages=[NAME, *(f"{NAME}.{package}" for package in find_packages(include=["core", "core.*"]))],
    cmdclass={"build_py": CoreAlone},
    script_name="setup.py",  # by which setuptools knows that this file is no module of the root package
)
