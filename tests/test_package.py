# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The wheel as a user of plain Python gets it: core, nothing else, typed, and it works where nothing else is."""

import re
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
import importlib, pkgutil, sys
import synch_fields
from importlib.metadata import requires, version

for module in pkgutil.walk_packages(synch_fields.__path__, "synch_fields."):
    if ".spread." not in module.name:  # by MPI and PETSc, which are there or not
        importlib.import_module(module.name)
assert not {"bpy", "synch_fields.synch_addon", "synch_fields.__main__"} & sys.modules.keys()
needed = {line.split(">")[0] for line in requires("synch_fields") if "extra" not in line}
assert needed == {"numpy", "scipy", "threadpoolctl"}, needed
print(version("synch_fields"))
"""

TYPED = """
import numpy as np
from synch_fields.core.connection import Connection, circle_transports, levi_civita
from synch_fields.core.extract.isolines import isolines
from synch_fields.core.extract.quad_mesh import quad_mesh
from synch_fields.core.fields import direction_field, given_directions, quad_pattern, stripe_pattern
from synch_fields.core.geometry import TriangleMesh, check_mesh
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solve import Options, solve


def stop(stage: str, fraction: float) -> bool:
    return fraction < 0.5


mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
field = direction_field(mesh, 4, options=Options(seed=1), callback=stop)
pattern = quad_pattern(mesh, field, 0.1)
connection = Connection(3, mesh.edges, mesh.weights, circle_transports(levi_civita(mesh, 4)))
solution = solve(SynchronizationProblem(connection))
reveal_type(mesh.areas)
reveal_type(field.vectors)
reveal_type(given_directions(mesh, 4, field.vectors))
reveal_type(stripe_pattern(mesh, field, np.ones(3)))
reveal_type(quad_mesh(pattern.edge_phases))
reveal_type(isolines(pattern.edge_phases))
reveal_type(pattern.dislocations)
reveal_type(solution)
reveal_type(solution.gap)
reveal_type(check_mesh(mesh))
"""
REVEALED = [
    "ndarray",
    "ndarray",
    "DirectionField",
    "Pattern",
    "QuadMesh",
    "Isolines",
    "Defect",
    "Solution",
    "float",
    "None",
]


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


def test_wheel_holds_core_and_nothing_else(wheel):
    with zipfile.ZipFile(wheel) as content:
        packed = {name for name in content.namelist() if ".dist-info/" not in name}
    expected = {path.relative_to(ROOT).as_posix() for path in (ROOT / "core").rglob("*.py")}
    assert packed == {f"synch_fields/{name}" for name in expected | {"__init__.py", "py.typed"}}


def test_core_of_the_wheel_solves_without_blender(python, tmp_path):
    run(*python, "-c", SOLVE, cwd=tmp_path)


def test_every_module_of_the_wheel_loads_without_blender(python, tmp_path):
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert run(*python, "-c", IMPORT_ALL, cwd=tmp_path).strip() == manifest["version"]


def test_public_names_of_the_wheel_are_typed_for_others(python, tmp_path):
    """With mypy as strict as it gets, in a project that has the wheel alone."""
    pytest.importorskip("mypy")
    (tmp_path / "theirs.py").write_text(TYPED)
    settings = "--strict", "--cache-dir", tmp_path / "cache", "--python-executable", python[0]
    printed = run(sys.executable, "-m", "mypy", *settings, "theirs.py", cwd=tmp_path)
    revealed = re.findall(r'Revealed type is "(.*)"', printed)
    assert len(revealed) == len(REVEALED)
    for found, expected in zip(revealed, REVEALED, strict=True):
        assert re.search(rf"\b{expected}\b", found) and not found == "Any", (found, expected)
