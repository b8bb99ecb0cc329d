# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A signal that comes while Blender calls functions, and forgets what they raise, ends the command all the same."""

import os
import signal
import sys
from contextlib import contextmanager

import bpy
import pytest

from synch_fields.core.files.openvdb import openvdb_module
from synch_fields.core.files.whole import write_whole
from synch_fields.core.interrupts import Interrupted, catch_interrupts, hold_interrupts, raise_interrupts
from synch_fields.synch_addon.looks.render import render_picture

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="processes are ended at once there")


def send(*_):
    os.kill(os.getpid(), signal.SIGTERM)


@contextmanager
def called(handlers, function):
    handlers.append(function)
    try:
        yield
    finally:
        handlers.remove(function)


def test_a_signal_while_cycles_renders_leaves_the_older_picture_and_prints_no_traceback(tmp_path, capfd):
    bpy.ops.mesh.primitive_cube_add()
    older = tmp_path / "cube.png"
    older.write_text("older")
    with pytest.raises(Interrupted, match="15"), called(bpy.app.handlers.render_pre, send), catch_interrupts():
        render_picture(bpy.context.object, older, resolution=(16, 16), samples=1)
    assert older.read_text() == "older" and os.listdir(tmp_path) == ["cube.png"]
    assert "Traceback" not in "".join(capfd.readouterr())


def test_nothing_takes_its_place_after_a_signal_whose_exception_was_forgotten(tmp_path):
    with pytest.raises(Interrupted), catch_interrupts():
        try:
            send()
        except Interrupted:
            pass  # as Blender does
        with write_whole(tmp_path / "new.txt") as made:
            made.write_text("new")
    assert not os.listdir(tmp_path)


def test_a_signal_that_is_held_back_comes_before_an_error():
    with pytest.raises(Interrupted), catch_interrupts(), hold_interrupts():
        send()
        raise RuntimeError("an operator failed")


def test_a_signal_that_nobody_asks_for_is_raised_at_the_end_and_then_forgotten():
    with pytest.raises(Interrupted), catch_interrupts():
        try:
            send()
        except Interrupted:
            pass
    raise_interrupts()


def test_a_signal_while_a_compiled_module_is_initialized_waits_until_it_is(monkeypatch):
    """An exception that comes out of OpenVDB's initialization ends the process with std::terminate."""
    monkeypatch.setattr("importlib.util.module_from_spec", lambda spec: send() or spec.name)
    monkeypatch.setattr("importlib.machinery.ExtensionFileLoader.exec_module", lambda _, module: done.append(module))
    done = []
    with pytest.raises(Interrupted), catch_interrupts():
        openvdb_module.__wrapped__("/nowhere/openvdb.so")
    assert done == ["openvdb"]
