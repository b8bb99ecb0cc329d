# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The core serves plain Python: it works where there is no bpy, and loads nothing of the add-on."""

import os
import subprocess
import sys
from pathlib import Path

import synch_fields

WITHOUT_BPY = """
import sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("bpy", "bmesh", "mathutils", "gpu") or ".synch_addon" in name:
            raise AssertionError(f"core imports {name}")

sys.meta_path.insert(0, Refuse())
import pkgutil
from importlib import import_module
from synch_fields import core

names = [m.name for m in pkgutil.walk_packages(core.__path__, core.__name__ + ".")]
for name in names:
    import_module(name)

import numpy as np
from synch_fields.core.fields import direction_field, stripe_pattern
from synch_fields.core.geometry import TriangleMesh

x, y = (a.ravel() for a in np.mgrid[:4, :4])
corner = np.array([4 * i + j for i in range(3) for j in range(3)])
lower, upper = (corner, corner + 4, corner + 5), (corner, corner + 5, corner + 1)
triangles = np.vstack([np.column_stack(lower), np.column_stack(upper)])
mesh = TriangleMesh(np.column_stack([x, y, 0 * x]), triangles)
pattern = stripe_pattern(mesh, direction_field(mesh, 1), 1.5)
assert pattern.solution.energy < 1e-12
print(len(names), *sorted({m.split(".")[0] for m in sys.modules} & {"numpy", "scipy", "bpy"}))
"""


def test_core_works_where_there_is_no_bpy():
    folder = str(Path(synch_fields.__path__[0]).absolute().parent)
    paths = [folder, os.environ.get("PYTHONPATH", "")]
    result = subprocess.run(
        [sys.executable, "-c", WITHOUT_BPY],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(p for p in paths if p)},
    )
    assert result.returncode == 0, result.stderr
    count, *loaded = result.stdout.split()
    assert int(count) >= 20 and loaded == ["numpy", "scipy"]
