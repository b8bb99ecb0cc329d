# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests in a real Blender window on a virtual display.

SYNCH_BLENDER is the command that starts a Blender whose Python has SciPy: `blender`, or a wrapper around one in a
container that sees the folder of temporary files (TMPDIR) under the same path, and the display. Xvfb has to be on the
PATH. Where one of them is missing, the tests are skipped. SYNCH_LANGUAGE names the language of the window, such as
de_DE, in which new data gets translated names too. The pictures that the tests take are left in out/ui, in a folder of
the language if it is another one than English.
"""

import importlib.util
import os
import shutil
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from .blender import Blender
from .screen import Screen, write_png

ROOT = Path(__file__).resolve().parents[2]
SIZE = 1400, 1000
ENGLISH = "en_US"
LANGUAGE = os.environ.get("SYNCH_LANGUAGE", ENGLISH)
SPEAK = f"view_of_user = bpy.context.preferences.view; view_of_user.language = {LANGUAGE!r}; "
SPEAK += "view_of_user.use_translate_new_dataname = True"


@pytest.fixture(scope="session")
def window(tmp_path_factory):
    """A Blender with the extension, for all tests."""
    with _installed(tmp_path_factory.mktemp("window")) as blender:
        yield blender


@pytest.fixture
def window_of_its_own(tmp_path):
    """A Blender with the extension that a test may end, Blender's own first scene in it and the default cube gone."""
    with _installed(tmp_path) as blender:
        blender.run("bpy.data.objects.remove(bpy.data.objects['Cube'])")
        yield blender


@pytest.fixture
def small_window(tmp_path):
    """A window of half as many pixels, its tab "Synch" opened.

    Without a graphics card, drawing anything takes a time that grows with the pixels of the whole window: some 50 ms
    for those of the others.
    """
    with _installed(tmp_path, (1000, 700)) as blender:
        blender.run("bpy.data.objects.remove(bpy.data.objects['Cube'])")
        blender.open_panel()
        yield blender


def blender_command():
    """What starts a real Blender; without it, the test is skipped."""
    command = os.environ.get("SYNCH_BLENDER")
    if not command:
        pytest.skip("no Blender with a window: name the command that starts one in SYNCH_BLENDER")
    return command


@contextmanager
def _installed(folder, size=SIZE):
    """A Blender with the extension, as `tools/extension.py` builds it, installed into a folder of its own."""
    command = blender_command()
    if shutil.which("Xvfb") is None:
        pytest.skip("no virtual display: install Xvfb")
    if importlib.util.find_spec("bpy") is None:
        pytest.skip("the extension cannot be built: bpy is not installed")
    screen = Screen(folder, size)
    try:
        blender = Blender(command, screen, folder)
        try:
            install = "bpy.ops.extensions.package_install_files"
            blender.run(f"{install}(filepath={build_extension(folder)!r}, repo='user_default', enable_on_install=True)")
            blender.run("part('settings.preferences').preferences().panel = 'ADVANCED'")
            blender.run(SPEAK)
            yield blender
        finally:
            blender.close()
    finally:
        screen.close()


@pytest.fixture
def blender(window):
    """The window with Blender's own first scene, the default cube gone."""
    window.run("bpy.ops.wm.read_homefile()")
    window.until("region('WINDOW')[2] > 1")
    window.run("bpy.data.objects.remove(bpy.data.objects['Cube'])")
    return window


@pytest.fixture
def panel(blender):
    """The window with the tab "Synch" opened, as a user does it."""
    blender.open_panel()
    return blender


@pytest.fixture
def as_delivered(blender):
    """The window with the panel that a new user has, the simple one, its tab not opened yet."""
    choice = "part('settings.preferences').preferences().panel = {!r}"
    blender.run(choice.format("SIMPLE"))
    yield blender
    blender.run(choice.format("ADVANCED"))
    blender.run(SPEAK)


@pytest.fixture
def keep():
    """Keeps a picture: keep(name, picture)."""
    folder = ROOT / "out" / "ui" / ("" if LANGUAGE == ENGLISH else LANGUAGE)
    folder.mkdir(parents=True, exist_ok=True)
    return lambda name, picture: write_png(folder / f"{name}.png", picture)


def build_extension(folder):
    """The path of the extension's zip, built into a folder."""
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        from extension import build
    finally:
        sys.path.pop(0)
    (archive,) = build(folder, with_wheels=False)
    return str(archive)
