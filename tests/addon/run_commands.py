# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands by the Python API, the operator and the command line, and operators between undo steps."""

import bpy
import numpy as np

from synch_fields.synch_addon import api
from synch_fields.synch_addon.command import main

from .scenes import snapshot

WAYS = ["api", "operator", "command line"]


def solve(way, obj, command="directions", **settings):
    """Run a command by one of the three ways; the report where there is one."""
    if way == "api":
        return getattr(api, command)(obj, **settings)
    if way == "operator":
        upper = {k: v.upper() if k in ("symmetry", "boundary") else v for k, v in settings.items()}
        assert getattr(bpy.ops.synch, command)(**upper) == {"FINISHED"}
        return None
    degrees = {k: np.degrees(v) if k == "angle" else v for k, v in settings.items()}
    flags = [f"--{key.replace('_', '-')}={value}" for key, value in degrees.items()]
    assert main.main([command, "--object", obj.name, "--quiet", *flags], loaded=True) == 0
    return None


def run(capfd, *arguments, loaded=False):
    """Run a command line in this process: exit status, stdout and stderr."""
    capfd.readouterr()
    status = main.main([str(a) for a in arguments], loaded=loaded)
    printed = capfd.readouterr()
    return status, printed.out, printed.err


def step(work, see=snapshot):
    """Work as from the user interface, with an undo step before and after; what is seen before and after."""
    bpy.ops.ed.undo_push(message="before")
    before = see()
    assert work() == {"FINISHED"}
    bpy.ops.ed.undo_push(message="after")
    after = see()
    assert after != before
    return before, after


def undo_and_redo(work, see=snapshot):
    """Work, undo it and redo it: everything is as before, and as after, which is what comes back."""
    before, after = step(work, see)
    bpy.ops.ed.undo()
    assert see() == before
    bpy.ops.ed.redo()
    assert see() == after
    return after


def add_weights(obj, name, weights):
    """A vertex group with a weight for each vertex."""
    group = obj.vertex_groups.new(name=name)
    for vertex, weight in enumerate(weights):
        group.add([vertex], weight, "REPLACE")
