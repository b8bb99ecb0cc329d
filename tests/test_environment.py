# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An environment that works is left as it is, and what is missing in one is installed alone."""

import importlib.util
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
EXTRAS = "blender", "test", "lint"


@pytest.fixture
def tool(tmp_path, monkeypatch):
    """tools/environment.py as a module, for a checkout elsewhere, with what it would have pip do."""
    spec = importlib.util.spec_from_file_location("environment", ROOT / "tools" / "environment.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    (tmp_path / "pyproject.toml").write_bytes((ROOT / "pyproject.toml").read_bytes())
    monkeypatch.setattr(module, "ROOT", tmp_path)
    module.asked = []
    monkeypatch.setattr(module, "pip", lambda *arguments: module.asked.append(arguments) or 0)
    return module


def has(monkeypatch, **versions):
    """The environment has these versions, None for none; of others, its own."""
    own = metadata.version

    def version(name):
        found = versions.get(name, "") or (own(name) if name not in versions else None)
        if found is None:
            raise metadata.PackageNotFoundError(name)
        return found

    monkeypatch.setattr(metadata, "version", version)


def test_an_environment_that_works_is_left_as_it_is(tool, monkeypatch):
    has(monkeypatch, synch_fields="0.0.1", bpy="5.0.1", ruff="0.17.9", mypy="2.4.7")  # of another checkout
    assert tool.main(EXTRAS) == 0 and not tool.asked


@pytest.mark.parametrize("there, asked", [(None, "scipy>=1.17"), ("1.16.0", "scipy>=1.17")])
def test_what_is_missing_or_too_old_is_installed_alone(tool, monkeypatch, there, asked):
    has(monkeypatch, synch_fields="0.0.1", scipy=there)
    assert tool.main(("test",)) == 0 and tool.asked == [("install", asked)]


def test_the_program_is_installed_where_there_is_none(tool, monkeypatch):
    has(monkeypatch, synch_fields=None, scipy="1.16.0")
    assert tool.main(EXTRAS) == 0
    assert tool.asked == [("install", "scipy>=1.17", "--editable", str(tool.ROOT))]


def test_the_manual_needs_nothing_else(tool, monkeypatch):
    has(monkeypatch, synch_fields=None, scipy=None, mkdocs=None, **{"mkdocs-material": "9.8.1"})
    assert tool.main(["--only", "docs"]) == 0 and tool.asked == [("install", "mkdocs==1.6.1")]


def test_another_blender_than_the_pinned_one_is_chosen_by_its_version(tool, monkeypatch):
    has(monkeypatch, synch_fields="0.0.1", bpy="4.5.15")
    for _ in range(2):
        assert tool.main((*EXTRAS, "bpy==5.0.1")) == 0 and tool.asked == [("install", "bpy==5.0.1")]
        has(monkeypatch, synch_fields="0.0.1", bpy="5.0.1")


def test_the_code_that_runs_is_that_of_the_checkout(tool, tmp_path):
    (tmp_path / "__init__.py").write_text("")
    for _ in range(2):
        tool.link()
    command = [sys.executable, "-c", "import synch_fields; print(synch_fields.__file__)"]
    path = {"PYTHONPATH": str(tmp_path / "out" / "tree")}
    printed = subprocess.run(command, env=path, capture_output=True, text=True, check=True).stdout
    assert Path(printed.strip()).resolve() == tmp_path.resolve() / "__init__.py"


def test_a_checkout_that_was_moved_is_found_again(tool, tmp_path):
    place = tmp_path / "out" / "tree" / "synch_fields"
    place.parent.mkdir(parents=True)
    place.symlink_to(tmp_path / "gone")
    tool.link()
    assert place.resolve() == tmp_path.resolve()
