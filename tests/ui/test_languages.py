# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of the extension in a real Blender in the background that names new data in another language.

A Blender as a module has English alone. German runs the rooms that make nodes, materials and objects; the languages
that translate other names run every main operator.
"""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from .conftest import ROOT, blender_command

ADDON = ROOT / "tests" / "addon"
ROOMS = ("nodes", "looks", "bakes", "patterns", "flows", "solids", "frames")
RUNS = [("de_DE", ADDON / room) for room in ROOMS]
RUNS += [(language, ADDON / "test_language.py") for language in ("de_DE", "ja_JP", "fr_FR")]


@pytest.mark.parametrize(("language", "tests"), RUNS, ids=lambda value: getattr(value, "stem", value))
def test_nothing_is_found_by_a_name_in_english(language, tests, tmp_path):
    paths = [ROOT / "out" / "tree", Path(pytest.__file__).parents[1]]
    environment = {
        **os.environ,
        "PYTHONPATH": str(paths[0]),  # for the processes that tests start
        "SYNCH_LANGUAGE": language,
        "SYNCH_TEST_PATHS": os.pathsep.join(map(str, paths)),
        "BLENDER_USER_RESOURCES": str(tmp_path),
    }
    script = Path(__file__).with_name("run_pytest.py")
    command = [*shlex.split(blender_command()), "--background", "--factory-startup", "--python", str(script), "--"]
    command += ["-q", "-p", "no:cacheprovider", "-m", "not slow", f"--basetemp={tmp_path / 'tests'}", str(tests)]
    run = subprocess.run(
        command, env=environment, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    sys.stdout.write(run.stdout)
    assert run.returncode == 0
