# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The packages as a user of Python gets them: complete, typed, and they work where nothing of the checkout is."""

import hashlib
import re
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
PARTS = "core", "synch_addon", "examples"

BUILD = """
import sys
from pathlib import Path
from package import python_packages, recipe

python_packages(Path(sys.argv[1]))
recipe(Path(sys.argv[1]))
"""

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

for part in "core", "examples":
    for module in pkgutil.walk_packages([f"{synch_fields.__path__[0]}/{part}"], f"synch_fields.{part}."):
        importlib.import_module(module.name)
assert not {"bpy", "synch_fields.synch_addon", "synch_fields.__main__"} & sys.modules.keys()
needed = {line.split(">")[0] for line in requires("synch_fields") if "extra" not in line}
assert needed == {"numpy", "scipy", "threadpoolctl"}, needed
assert version("synch_fields") == synch_fields.__version__
"""

TYPED = """
from typing import Any

import numpy as np
from synch_fields.core.connection import Connection, circle_transports, levi_civita
from synch_fields.core.extract.lines.isolines import isolines
from synch_fields.core.extract.quads.trace.quad_mesh import quad_mesh
from synch_fields.core.fields import direction_field, given_directions, quad_pattern, stripe_pattern
from synch_fields.core.geometry import TriangleMesh, check_mesh
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solve import Options, solve
from synch_fields.synch_addon import api


def stop(stage: str, fraction: float) -> bool:
    return fraction < 0.5


def in_blender(obj: Any) -> float:
    reveal_type(api.stripes)
    reveal_type(api.number_stripes)
    report = api.stripes(obj, stop, spacing=0.1, method="sdp")
    return float(report["energy"])


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
reveal_type(pattern.solution.energy)
reveal_type(solution)
reveal_type(solution.gap)
reveal_type(check_mesh(mesh))
"""
REVEALED = [
    "SurfaceKeywords.*dict\\[str, Any",
    "int",
    "ndarray",
    "ndarray",
    "DirectionField",
    "Pattern",
    "QuadMesh",
    "Isolines",
    "Defect",
    "float",
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
def packages(tmp_path_factory):
    """The sdist and the wheel that a release has, the wheel built from the sdist."""
    folder = tmp_path_factory.mktemp("packages")
    run(sys.executable, "-c", BUILD, folder, cwd=ROOT / "tools")
    return folder


@pytest.fixture(scope="module")
def wheel(packages):
    (found,) = packages.glob("*.whl")
    return found


@pytest.fixture(scope="module")
def python(wheel, tmp_path_factory):
    """A fresh environment's Python, in isolated mode: the wheel, and what is installed here for it to depend on."""
    builder, folder = venv.EnvBuilder(), tmp_path_factory.mktemp("environment")
    builder.create(folder)
    executable = builder.ensure_directories(folder).env_exe
    pip("--python", executable, "install", "--no-deps", "--no-index", wheel)
    # A folder that a .pth file names is searched last, and its own .pth files, that of this checkout too, are not read.
    installed = run(executable, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip()
    Path(installed, "dependencies.pth").write_text(sysconfig.get_path("purelib"))
    return executable, "-I"


def test_wheel_holds_every_file_of_the_program(wheel):
    with zipfile.ZipFile(wheel) as content:
        packed = {name for name in content.namelist() if ".dist-info/" not in name}
    files = [path for part in PARTS for path in (ROOT / part).rglob("*") if path.is_file()]
    expected = {path.relative_to(ROOT).as_posix() for path in files if "__pycache__" not in path.parts}
    assert packed == {f"synch_fields/{name}" for name in expected | {"__init__.py", "__main__.py", "py.typed"}}


def test_one_version_and_one_address_everywhere(wheel):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    citation = dict(re.findall(r"^([\w-]+): (.*)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE))
    assert manifest["version"] == citation["version"] == wheel.name.split("-")[1]
    assert f"## {manifest['version']}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert project["urls"]["Repository"] == manifest["website"] == citation["repository-code"]
    assert {author["name"] for author in project["authors"]} == {manifest["maintainer"]}


def test_pictures_and_links_of_the_readme_are_absolute_in_the_package(wheel):
    with zipfile.ZipFile(wheel) as content:
        (metadata,) = [name for name in content.namelist() if name.endswith("/METADATA")]
        text = content.read(metadata).decode()
    repository = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["urls"]["Repository"]
    links = re.findall(r"(!?)\[[^\]\n]*\]\(([^)]*)\)", text)
    assert len(links) > 10
    for mark, target in links:
        assert target.startswith(("https://", "#")), target
        if target.startswith(repository) and target != f"{repository}/releases":
            kind, _, place = target.removeprefix(f"{repository}/").partition("/HEAD/")
            assert kind == ("raw" if mark else "blob") and (ROOT / place.partition("#")[0]).exists(), target


def test_the_package_is_the_same_to_the_last_byte_again(packages, tmp_path):
    run(sys.executable, "-c", BUILD, tmp_path, cwd=ROOT / "tools")
    for path in packages.glob("*.*"):
        assert path.read_bytes() == (tmp_path / path.name).read_bytes(), path.name


def test_conda_accepts_the_recipes(packages):
    """That of the checkout, and that of a release with its checksum; both say what pyproject.toml says."""
    recipes = pytest.importorskip("rattler_build")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    for path in (ROOT / "packaging" / "conda" / "recipe.yaml", packages / "conda" / "recipe.yaml"):
        (found,) = recipes.Stage0Recipe.from_file(path).render()
        said = found.recipe.to_dict()
        assert said["package"]["version"] == manifest["version"]
        assert said["about"]["license"] == project["license"]
        assert said["about"]["summary"] == project["description"]
        assert said["about"]["repository"].rstrip("/") == project["urls"]["Repository"]
        needed = {line.replace(" ", "") for line in said["requirements"]["run"]}
        assert needed == {*project["dependencies"], f"python{project['requires-python']}"}
    (source,) = said["source"]
    (sdist,) = packages.glob("*.tar.gz")
    assert source["url"].endswith(f"/v{manifest['version']}/{sdist.name}")
    assert source["sha256"] == hashlib.sha256(sdist.read_bytes()).hexdigest()


def test_without_blender_the_command_line_says_what_to_install(python):
    code = f"""
import runpy, sys
sys.path.remove({sysconfig.get_path("purelib")!r})
sys.argv[1:] = ["info", "x.obj"]
runpy.run_module("synch_fields", run_name="__main__", alter_sys=True)
"""
    result = subprocess.run([*python, "-c", code], capture_output=True, text=True)
    line = 'synch: Blender is missing: pip install "synch_fields[blender]", on Python 3.11 or 3.13\n'
    assert (result.returncode, result.stdout, result.stderr) == (1, "", line)


def test_with_blender_the_command_line_solves(python, tmp_path):
    pytest.importorskip("bpy")
    along = np.linspace(0, 1, 9)
    corners = [f"v {x} {y} {x * y}" for y in along for x in along]
    faces = [f"f {k + 1} {k + 2} {k + 11} {k + 10}" for k in range(72) if k % 9 < 8]
    (tmp_path / "saddle.obj").write_text("\n".join([*corners, *faces, ""]))
    command = "-m", "synch_fields", "stripes", "saddle.obj", "--spacing", "0.2", "--output", "out.blend", "--quiet"
    assert "stripes on" in run(*python, *command, cwd=tmp_path)
    assert (tmp_path / "out.blend").stat().st_size > 10_000


def test_core_of_the_wheel_solves_without_blender(python, tmp_path):
    run(*python, "-c", SOLVE, cwd=tmp_path)


def test_every_module_of_the_wheel_loads_without_blender(python, tmp_path):
    run(*python, "-c", IMPORT_ALL, cwd=tmp_path)


def test_public_names_of_the_wheel_are_typed_for_others(python, tmp_path):
    """With mypy as strict as it gets, in a project that has the wheel alone. What it knows of NumPy is kept."""
    pytest.importorskip("mypy")
    (tmp_path / "theirs.py").write_text(TYPED)
    settings = "--strict", "--cache-dir", ROOT / "out" / "mypy", "--python-executable", python[0]
    printed = run(sys.executable, "-m", "mypy", *settings, "theirs.py", cwd=tmp_path)
    revealed = re.findall(r'Revealed type is "(.*)"', printed)
    assert len(revealed) == len(REVEALED)
    for found, expected in zip(revealed, REVEALED, strict=True):
        assert re.search(rf"\b{expected}\b", found) and not found == "Any", (found, expected)
