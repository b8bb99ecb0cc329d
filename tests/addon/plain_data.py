# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether requests and results are plain data: what their pickles name, and a solve in a process without Blender."""

import io
import os
import pickle
import subprocess
import sys

# Whose classes may go through a pipe.
PLAIN = ("builtins", "collections", "copyreg", "functools", "numpy", "pathlib", "scipy", "synch_fields.core.")
_SOLVE = """
import pickle, sys
with open(sys.argv[1], "rb") as file:
    result = pickle.load(file).solve()
assert not [name for name in sys.modules if name.split(".")[0] in ("bpy", "mathutils")]
with open(sys.argv[2], "wb") as file:
    pickle.dump(result, file)
"""


class _Recorded(pickle.Unpickler):
    """Keeps the modules of all classes and functions that a pickle names."""

    def __init__(self, data):
        super().__init__(io.BytesIO(data))
        self.modules = set()

    def find_class(self, module, name):
        self.modules.add(module)
        return super().find_class(module, name)


def unpickled(thing):
    """A copy that has been bytes, of nothing that needs Blender."""
    reader = _Recorded(pickle.dumps(thing))
    copy = reader.load()
    assert all(f"{module}.".startswith(PLAIN) or module.split(".")[0] in PLAIN for module in reader.modules)
    return copy


def solved_apart(request, folder):
    """The result of a request from a process without Blender."""
    (folder / "request").write_bytes(pickle.dumps(request))
    paths = [folder / "request", folder / "result"]
    subprocess.run([sys.executable, "-c", _SOLVE, *paths], check=True, env=os.environ | {"PYTHONSAFEPATH": "1"})
    return pickle.loads((folder / "result").read_bytes())
