# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What pyproject.toml cannot say: the root is the package `synch_fields`, and the readme's links are absolute."""

import re
import tomllib
from pathlib import Path

from setuptools import find_packages, setup
from setuptools.command.build_py import build_py

NAME = "synch_fields"
PACKAGES = ("core", "synch_addon", "examples")
ROOT = Path(__file__).parent


class WithoutSetup(build_py):
    """Leaves out this file, which lies in the root package."""

    def find_package_modules(self, package, package_dir):
        found = super().find_package_modules(package, package_dir)
        return [module for module in found if module[:2] != (NAME, "setup")]


def readme():
    """README.md with links to the repository, where it has links to files beside it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    repository = project["urls"]["Repository"]
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    text = re.sub(r"(!\[[^\]]*\]\()(?!https?:|#)", rf"\1{repository}/raw/HEAD/", text)
    return re.sub(r"(\]\()(?!https?:|#)", rf"\1{repository}/blob/HEAD/", text)


setup(
    packages=[NAME, *(f"{NAME}.{name}" for name in find_packages(include=[f"{top}*" for top in PACKAGES]))],
    cmdclass={"build_py": WithoutSetup},
    long_description=readme(),
    long_description_content_type="text/markdown",
    script_name="setup.py",  # by which setuptools knows that this file is not a module of the root package
)
