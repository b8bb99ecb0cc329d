# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A timer runs once at a time, however often it is begun, and one that is stopped makes no call."""

import ast
from pathlib import Path
from types import SimpleNamespace

from synch_fields.synch_addon.blender import timers
from synch_fields.synch_addon.blender.timers import Timer
from synch_fields.synch_addon.panels.thumbnails import galleries


class Steps:
    def make(self):
        return 1.0


def registered(monkeypatch):
    """Steps as they are registered from now on."""
    steps = []
    monkeypatch.setattr(timers, "bpy", SimpleNamespace(app=SimpleNamespace(timers=Timers(steps))))
    return steps


class Timers:
    """Blender's timers, which are told apart by the very object."""

    def __init__(self, steps):
        self.steps = steps

    def is_registered(self, step):
        return any(other is step for other in self.steps)

    def register(self, step, **_):
        self.steps.append(step)

    def unregister(self, step):
        self.steps[:] = [other for other in self.steps if other is not step]


def test_a_method_is_registered_once_and_can_be_stopped():
    timer = Timer(Steps().make, first=10.0)
    assert not timer.runs
    timer.start()
    timer.start()
    assert timer.runs
    timer.stop()
    assert not timer.runs
    timer.stop()


def test_thumbnails_have_one_timer(monkeypatch):
    steps = registered(monkeypatch)
    for _ in range(20):
        galleries._timer.start()
    assert len(steps) == 1
    galleries._timer.stop()
    assert not steps


def test_timers_are_begun_in_one_place():
    folder = Path(timers.__file__).parents[1]
    using = {
        path.name
        for path in folder.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute) and node.attr == "timers"
    }
    assert using == {"timers.py"}
