# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What pyproject.toml cannot say: the root is the package `synch_fields`, and its version is the extension's."""

import tomllib
from pathlib import Path

from setuptools import find_packages, setup

NAME = "synch_fields"
manifest = tomllib.loads(Path(__file__).with_name("blender_manifest.toml").read_text(encoding="utf-8"))
found = find_packages(include=["core", "core.*", "synch_addon", "synch_addon.*"])

setup(
    version=manifest["version"],
    packages=[NAME, *(f"{NAME}.{package}" for package in found)],
    script_name="setup.py",  # by which setuptools knows that this file is no module of the root package
)
