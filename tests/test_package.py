# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The wheel as a user of plain Python gets it: all of the program, nothing else, and it works where nothing else is."""

import importlib.util
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
NOT_SHIPPED = shutil.ignore_patterns(".*", "build", "out", "wheels", "library", "*.egg-info", "__pycache__")

SOLVE = """
import sys
from pathlib import Path
import numpy as np
from scipy.spatial import ConvexHull
import synch_fields
from synch_fields.core.fields import direction_field, stripe_pattern
from synch_fields.core.geometry import TriangleMesh

assert Path(synch_fields.__file__).is_relative_to(sys.prefix), synch_fields.__file__
along, height = np.arange(400) * np.pi * (3 - 5**0.5), np.linspace(-1, 1, 402)[1:-1]
points = np.column_stack([np.cos(along), np.sin(along), height])
points[:, :2] *= np.sqrt(1 - height**2)[:, None]
triangles = ConvexHull(points).simplices
inwards = np.linalg.det(points[triangles]) < 0
triangles[inwards] = triangles[inwards, ::-1]
mesh = TriangleMesh(points, triangles)
field = direction_field(mesh, symmetry=2)
assert sum(defect.index for defect in field.disclinations) == 2, field.disclinations
solution = stripe_pattern(mesh, field, spacing=0.5).solution
assert 0 < solution.lower_bound <= solution.energy
assert "bpy" not in sys.modules
"""

IMPORT_ALL = """
import importlib, pkgutil
import bpy
import synch_fields

for module in pkgutil.walk_packages(synch_fields.__path__, "synch_fields."):
    if not module.name.endswith("__main__"):
        importlib.import_module(module.name)
synch_fields.register()
bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4)
assert bpy.ops.synch.stripes() == {"FINISHED"}
assert bpy.utils.preset_paths("synch_fields"), "the shipped settings are missing"
from synch_fields.synch_addon.jobs.report import VERSION
from synch_fields.synch_addon.looks import assets
assert (assets.THUMBNAILS / "zebra.png").exists()
synch_fields.unregister()
print(VERSION)
"""


def run(*command, **settings):
    """Standard output of a process that must succeed."""
    result = subprocess.run(list(map(str, command)), capture_output=True, text=True, **settings)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def pip(*arguments):
    return run(sys.executable, "-m", "pip", "--disable-pip-version-check", *arguments)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """What `pip wheel .` makes of the files of the project, without those of earlier builds."""
    folder = tmp_path_factory.mktemp("wheel")
    shutil.copytree(ROOT, folder / "source", ignore=NOT_SHIPPED)
    pip("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", folder, folder / "source")
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def python(wheel, tmp_path_factory):
    """A fresh environment's Python, in isolated mode: the wheel, and what is installed here for it to depend on."""
    folder = tmp_path_factory.mktemp("environment")
    environment = venv.EnvBuilder()
    environment.create(folder)
    executable = environment.ensure_directories(folder).env_exe
    pip("--python", executable, "install", "--no-deps", "--no-index", wheel)
    # A folder that a .pth file names is searched last, and its own .pth files, that of this checkout too, are not read.
    installed = run(executable, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip()
    Path(installed, "dependencies.pth").write_text(sysconfig.get_path("purelib"))
    return executable, "-I"


def test_wheel_holds_the_program_and_nothing_else(wheel):
    with zipfile.ZipFile(wheel) as content:
        packed = {name for name in content.namelist() if ".dist-info/" not in name}
    shipped = ["__init__.py", "__main__.py", "blender_manifest.toml", "core/**/*", "synch_addon/**/*"]
    expected = {path.relative_to(ROOT) for pattern in shipped for path in ROOT.glob(pattern) if path.is_file()}
    unwanted = {"__pycache__", "library"}
    assert packed == {f"synch_fields/{path.as_posix()}" for path in expected if not unwanted & set(path.parts)}


def test_core_of_the_wheel_solves_without_blender(python, tmp_path):
    run(*python, "-c", SOLVE, cwd=tmp_path)


@pytest.mark.skipif(importlib.util.find_spec("bpy") is None, reason="bpy is not installed")
def test_every_module_of_the_wheel_loads_in_blender(python, tmp_path):
    version = run(*python, "-c", IMPORT_ALL, cwd=tmp_path).splitlines()[-1]
    installed = "import importlib.metadata; print(importlib.metadata.version('synch_fields'))"
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert version == run(*python, "-c", installed).strip() == manifest["version"]
