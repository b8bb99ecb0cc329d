# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands by the Python API, the operator and the command line."""

import bpy
import numpy as np

from synch_fields.synch_addon import api, cli

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
    assert cli.main([command, "--object", obj.name, "--quiet", *flags], loaded=True) == 0
    return None


def add_weights(obj, name, weights):
    """A vertex group with a weight for each vertex."""
    group = obj.vertex_groups.new(name=name)
    for vertex, weight in enumerate(weights):
        group.add([vertex], weight, "REPLACE")
