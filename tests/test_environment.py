# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bare machine gets an environment, or one line that says what it lacks; one that works is left as it is."""

import ast
import importlib.util
import re
import subprocess
import sys
import tomllib
from importlib import metadata
from itertools import chain
from pathlib import Path
from types import SimpleNamespace

import pytest

ROOT = Path(__file__).resolve().parents[1]
EXTRAS = "blender", "test", "lint"
LOCKED = "--constraint", str(ROOT / "requirements" / "python{}.{}.txt".format(*sys.version_info))


def loaded(name):
    """A script of tools/ as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def tool(tmp_path, monkeypatch):
    """tools/requirements.py as a module, for a checkout elsewhere, with what it would have pip do."""
    module = loaded("requirements")
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
    assert tool.main(("test",)) == 0 and tool.asked == [("install", *LOCKED, asked)]


def test_the_program_is_installed_where_there_is_none(tool, monkeypatch):
    has(monkeypatch, synch_fields=None, scipy="1.16.0")
    assert tool.main(EXTRAS) == 0
    assert tool.asked == [("install", *LOCKED, "scipy>=1.17", "--editable", str(tool.ROOT))]


def test_the_manual_needs_nothing_else(tool, monkeypatch):
    has(monkeypatch, synch_fields=None, scipy=None, mkdocs=None, **{"mkdocs-material": "9.8.1"})
    assert tool.main(["--only", "docs"]) == 0 and tool.asked == [("install", *LOCKED, "mkdocs==1.6.1")]


def test_another_blender_than_the_pinned_one_is_chosen_by_its_version(tool, monkeypatch):
    has(monkeypatch, synch_fields="0.0.1", bpy="4.5.15")
    for _ in range(2):
        assert tool.main((*EXTRAS, "bpy==5.0.1")) == 0 and tool.asked == [("install", *LOCKED, "bpy==5.0.1")]
        has(monkeypatch, synch_fields="0.0.1", bpy="5.0.1")


def test_the_newest_versions_are_installed_where_they_are_asked_for(tool, monkeypatch):
    has(monkeypatch, synch_fields="0.0.1", bpy="5.0.1")
    assert tool.main(("--latest", "lint")) == 0
    (asked,) = tool.asked
    assert asked[:4] == ("install", "--upgrade", "--upgrade-strategy", "eager")
    assert asked[4:] == ("numpy>=1.26.4", "scipy>=1.17", "threadpoolctl>=3.5", "ruff==0.17.*", "mypy==2.4.*")


def test_the_versions_in_the_lock_are_those_that_the_project_accepts(tool):
    """On both Pythons, for whatever an environment of the project or of its manual gets."""
    read = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    groups = [*read["dependency-groups"].values(), read["project"]["dependencies"]]
    for version in loaded("environment").VERSIONS:
        text = (ROOT / "requirements" / f"python{version}.txt").read_text(encoding="utf-8")
        locked = dict(re.findall(r"^([\w.-]+)==(.+)$", text, re.MULTILINE))
        locked = {name.lower().replace("_", "-"): found for name, found in locked.items()}
        assert "bpy" not in locked
        for requirement in map(tool.Requirement, chain.from_iterable(groups)):
            assert requirement.specifier.contains(locked[requirement.name.lower()]), requirement


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


# Of Debian 12 and 13.
ALL_PACKAGES = "libx11-6 libxext6 libxrender1 libxfixes3 libxi6 libxkbcommon0 libsm6 libice6 libgl1 libegl1"


@pytest.fixture
def bare(monkeypatch, tmp_path):
    """tools/environment.py on a machine without apt-get, Pythons and libraries; ``calls`` are what it would run."""
    module = loaded("environment")
    module.calls = []
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(module, "loads", lambda library: False)
    monkeypatch.setattr(module, "answer", lambda command, program: "")
    monkeypatch.setattr(module.sys, "platform", "linux")
    monkeypatch.setattr(module.subprocess, "call", lambda command, **_settings: module.calls.append(command) or 0)
    return module


def provide_apt_get(folder):
    (folder / "apt-get").write_text("#!/bin/sh\n")
    (folder / "apt-get").chmod(0o755)


def line_of(capsys):
    """The one line that an error prints."""
    (line,) = capsys.readouterr().err.splitlines()
    return line


def test_missing_libraries_are_named_before_anything_is_made(bare, capsys, tmp_path, monkeypatch):
    assert bare.main(["--venv", str(tmp_path / "venv"), "blender"]) == 1
    assert "install the packages of libX11.so.6, libXext.so.6" in line_of(capsys)
    provide_apt_get(tmp_path)
    monkeypatch.setattr(bare.os, "geteuid", lambda: 1000, raising=False)
    assert bare.main(["--venv", str(tmp_path / "venv"), "bpy==4.5.15"]) == 1
    assert line_of(capsys).endswith(f"run: sudo apt-get install -y {ALL_PACKAGES}")
    assert not bare.calls and not (tmp_path / "venv").exists()


def test_root_installs_what_is_missing_and_nothing_else(bare, tmp_path, monkeypatch):
    provide_apt_get(tmp_path)
    there = {"libX11.so.6", "libXext.so.6", "libXi.so.6", "libSM.so.6", "libICE.so.6", "libGL.so.1", "libEGL.so.1"}
    monkeypatch.setattr(bare, "loads", lambda library: library in there)
    monkeypatch.setattr(bare.os, "geteuid", lambda: 0, raising=False)
    with pytest.raises(bare.SetupError, match="could not install libxrender1 libxfixes3 libxkbcommon0"):
        bare.provide_libraries()
    assert [command[2] for command in bare.calls] == ["update", "install"]
    assert bare.calls[1][-3:] == ["libxrender1", "libxfixes3", "libxkbcommon0"]
    monkeypatch.setattr(bare, "apt_get", lambda *_arguments: there.update(bare.LIBRARIES) or 0)
    bare.provide_libraries()
    assert not bare.missing_libraries()


def test_an_environment_without_blender_needs_no_libraries(bare, capsys, tmp_path):
    assert bare.main(["--venv", str(tmp_path / "venv"), "--only", "docs"]) == 1
    assert "no Python runs" in line_of(capsys)


def answers(tool, pythons):
    """What Pythons of these names answer, "VERSION without venv" being one that makes no environments."""

    def answer(command, program):
        version, _, lacks = pythons.get(" ".join(command), "").partition(" ")
        return "" if lacks and program == tool.WITH_VENV else version

    return answer


@pytest.mark.parametrize(
    "pythons, named, said",
    [
        ({}, None, "Python 3.13 or 3.11 is needed.*no Python runs: install one, or name it"),
        ({"python3": "3.12"}, None, "Python 3.13 or 3.11 is needed.*only 3.12 runs"),
        ({"python3": "3.13"}, "python3.99", "python3.99 does not run"),
        ({"python3.13": "3.13 without venv"}, None, "Python 3.13 lacks its modules venv.*python3.13-venv"),
    ],
)
def test_a_line_says_which_python_is_missing(bare, pythons, named, said, monkeypatch):
    monkeypatch.setattr(bare, "answer", answers(bare, pythons))
    with pytest.raises(bare.SetupError, match=said):
        bare.find_python(["3.13", "3.11"], named)


def test_the_best_python_that_can_make_environments_is_found(bare, monkeypatch):
    pythons = {"python3.13": "3.13 without venv", "python3.11": "3.11", "python3": "3.11"}
    monkeypatch.setattr(bare, "answer", answers(bare, pythons))
    assert bare.find_python(["3.13", "3.11"]) == ["python3.11"]
    monkeypatch.setattr(bare, "answer", answers(bare, pythons | {"python3": "3.13"}))
    assert bare.find_python(["3.13", "3.11"]) == ["python3"]
    assert bare.find_python(["3.11"], "python3.11") == ["python3.11"]


def test_an_environment_of_another_python_is_kept_and_named(bare, capsys, tmp_path, monkeypatch):
    python = str(bare.python_of(tmp_path))
    monkeypatch.setattr(bare, "answer", answers(bare, {python: "3.11"}))
    assert bare.main(["--venv", str(tmp_path), "--versions", "3.13"]) == 1
    assert line_of(capsys).endswith("has Python 3.11 instead of 3.13: remove it or name another")
    assert bare.main(["--venv", str(tmp_path), "test"]) == 0
    assert bare.calls == [[python, str(ROOT / "tools" / "requirements.py"), "test"]]


# Part of every Linux that runs Python.
EVERYWHERE = re.compile(r"ld-linux|linux-vdso|lib(c|m|dl|rt|util|pthread|gcc_s|stdc\+\+)\.so")


def libraries_of(path):
    """Paths by names of the system's libraries that a file links to, and these to others."""
    output = subprocess.run(["ldd", path], capture_output=True, text=True, check=True).stdout
    found = re.findall(r"^\s*(\S+) => (\S+)", output, re.MULTILINE)
    return {name: place for name, place in found if "/bpy/" not in place and not EVERYWHERE.match(name)}


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere Blender's module needs no libraries of the system")
def test_the_libraries_are_those_that_blender_links_to():
    """Each in the list is needed, and what else is needed comes with one in the list."""
    needed = libraries_of(importlib.util.find_spec("bpy").origin)
    opened_later = {"libEGL.so.1"}  # by name, once something is drawn without a window
    listed = loaded("environment").LIBRARIES.keys() - opened_later
    assert listed <= needed.keys()
    assert needed.keys() == set(listed).union(*(libraries_of(needed[name]) for name in listed))


def test_a_target_runs_its_programs_until_one_fails(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "tools")
    make = loaded("make")
    statuses, ran = [0, 0, 3], []
    monkeypatch.setattr(make.environment, "complete", lambda options, names: ran.append(names) or 0)

    def start(command, **_settings):
        ran.append(command[1:])
        return SimpleNamespace(wait=lambda: statuses.pop(0))

    monkeypatch.setattr(make.subprocess, "Popen", start)
    assert make.main(["test", "tests/core", "-x", "--blender", "5.0.1"]) == 0
    assert make.main(["lint"]) == 3
    assert ran[0] == ["blender", "test", "lint", "package", "bpy==5.0.1"]
    assert ran[1] == ["-m", "pytest", "-m", "not slow", "tests/core", "-x"]
    assert [command[1] for command in ran[3:]] == ["ruff", "ruff"]
    statuses.append(1)
    assert make.main(["demo"]) == 1 and not statuses
    # All tests are shared out to as many processes as there are cores.
    monkeypatch.setattr(make.os, "cpu_count", lambda: 2)
    for given in ([], ["--share", "1/1"]):
        statuses += [1, 0]
        assert make.main(["test", *given]) == 1 and not statuses
        assert ran[-2:] == [["-m", "pytest", "-m", "not slow", "--part", f"{k}/2"] for k in (1, 2)]
    statuses.append(0)
    assert make.main(["test", "--share", "1/2"]) == 0 and ran[-1][-2:] == ["--share", "1/2"]


def test_make_calls_the_script_for_each_of_its_targets(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "tools")
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    called = re.findall(r"^([\w -]+):\n\t@\$\(make\) \$@", makefile, re.MULTILINE)
    assert set(" ".join(called).split()) == loaded("make").TARGETS.keys()


@pytest.mark.parametrize("name", ["environment", "make"])
def test_scripts_that_any_python_starts_have_its_syntax(name):
    ast.parse((ROOT / "tools" / f"{name}.py").read_text(encoding="utf-8"), feature_version=(3, 8))
