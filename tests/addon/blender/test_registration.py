# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of the extension are registered all or none, as often as Blender or a script asks."""

import bpy
import pytest

from synch_fields import synch_addon
from synch_fields.synch_addon.blender.registration import Registration
from synch_fields.synch_addon.command.main import blender_command
from synch_fields.synch_addon.panels.strokes import SynchStrokesTool


def fail():
    raise RuntimeError("this step fails")


@pytest.fixture
def log():
    return []


def step(log, name, undo=None):
    return lambda: log.append(f"+{name}"), undo or (lambda: log.append(f"-{name}"))


def test_steps_are_taken_once_and_undone_once(log):
    registration = Registration(step(log, "a"), step(log, "b"))
    registration.unregister()
    for _ in range(2):
        registration.register()
        registration.register()
        registration.unregister()
        registration.unregister()
    assert log == 2 * ["+a", "+b", "-b", "-a"]


def test_where_a_step_fails_those_before_it_are_undone(log):
    registration = Registration(step(log, "a"), step(log, "b"), (fail, fail))
    with pytest.raises(RuntimeError, match="this step fails"):
        registration.register()
    assert log == ["+a", "+b", "-b", "-a"]
    registration.unregister()
    assert len(log) == 4


def test_where_a_step_cannot_be_undone_the_others_are(log):
    registration = Registration(step(log, "a"), step(log, "b", fail), step(log, "c"))
    registration.register()
    with pytest.raises(RuntimeError, match="this step fails"):
        registration.unregister()
    assert log == ["+a", "+b", "+c", "-c", "-a"]
    registration.unregister()
    assert len(log) == 5


@pytest.fixture
def taken_out():
    """The extension is not registered."""
    synch_addon.unregister()
    yield
    synch_addon.register()


def ours():
    """Names of what the extension has registered."""
    return [
        name for kind in (bpy.types, bpy.types.Scene, bpy.types.Object) for name in dir(kind) if "synch" in name.lower()
    ]


def test_the_extension_is_all_there_or_not_at_all(taken_out):
    """The tool of strokes is registered already, as another copy of the extension would have done."""
    assert ours() == []
    bpy.utils.register_tool(SynchStrokesTool)
    try:
        with pytest.raises(Exception, match="already exists"):
            synch_addon.register()
        assert ours() == []
    finally:
        bpy.utils.unregister_tool(SynchStrokesTool)
    synch_addon.register()
    registered = ours()
    synch_addon.register()
    assert ours() == registered and "SYNCH_OT_stripes" in registered


def test_a_command_that_blender_has_dropped_is_no_error(taken_out):
    synch_addon.register()
    bpy.utils.unregister_cli_command(blender_command._handle)
    synch_addon.unregister()
    assert ours() == []
