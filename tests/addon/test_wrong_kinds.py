# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every function of the Python API, given what is of the wrong kind: one line, or a result, and nothing else."""

import inspect
import math
from dataclasses import fields

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError, quote_value
from synch_fields.core.settings.bake import BakeSettings
from synch_fields.core.settings.flow import FlowSettings
from synch_fields.core.settings.layers import LayerSettings
from synch_fields.core.settings.lines import LineSettings
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api

from .scenes import snapshot, sphere

# Numbers of every size are tried in settings/test_numeric_settings.py.
WRONG = [None, True, 0.5, 2**70, math.nan, 1j, b"axis:Z", [], [None], [[0], 1]]
WRONG += ["", "x" * 5000, "a\ud800", "\0", {"a": 1}, object(), np.array([1.5, 2])]
# What each function takes as keywords besides those that it names.
SETTINGS = {
    "stripes": SurfaceSettings,
    "layers": LayerSettings,
    "isolines": LineSettings,
    "bake": BakeSettings,
    "clebsch": FlowSettings,
}
# Arguments without which a function cannot be called.
NEEDED = {
    "stripes": {"spacing": 1.5, "method": "spectral"},
    "layers": {"spacing": 0.7, "size": 0.6, "method": "spectral"},
    "vary": {"number": 1},
    "place_defects": {"vertices": [3]},
    "move_defect": {"face": 3, "to_face": 4},
    "preset": {"name": "zebra"},
    "import_field": {"path": "/nowhere/field.rosy"},
    "export_field": {"path": "/nowhere/field.rosy"},
    "layer_export": {"path": "/nowhere/part.stl"},
    "layer_volume": {"path": "/nowhere/part.vdb"},
    "filament_export": {"path": "/nowhere/lines.vtp"},
    "select": {"vertices": [0]},
    # Refused after everything that is given has been looked at, so that nothing is solved or baked.
    "bake": {"folder": "/nowhere"},
    "clebsch": {"quantum": 1.0},
    "animate": {"frames": (1, 1)},
}
RE_EXPORTED = (
    *("animate", "number_stripes", "refine", "layer_export", "layer_toolpaths", "layer_volume", "choose_point"),
    *("clebsch", "filament_export"),
)
NAMES = (
    *(
        "directions",
        "stripes",
        "quads",
        "quad_mesh",
        "layers",
        "vary",
        "place_defects",
        "move_defect",
        "trace_quads",
        "isolines",
        "carry",
    ),
    *("relief", "preset", "bake", "import_field", "export_field", "select", "animate", "number_stripes", "refine"),
    *("layer_export", "layer_toolpaths", "layer_volume", "choose_point", "clebsch", "filament_export"),
)


@pytest.fixture
def solved():
    """A small object with stripes, and what the file holds."""
    obj = sphere(1)
    bpy.context.scene.frame_end = 1
    api.stripes(obj, spacing=1.5, method="spectral")
    return obj


def refused_or_done(function, /, *arguments, **keywords):
    """Call a function of the API; whatever it says is one line, and the scene is as it was where it says something."""
    bpy.context.view_layer.update()
    before = snapshot()
    try:
        getattr(api, function)(*arguments, **keywords)
    except SynchError as error:
        assert str(error) and "\n" not in str(error)
        assert snapshot() == before
        return str(error)
    return None


def test_every_public_function_is_here():
    public = {name for name, found in vars(api).items() if inspect.isfunction(found) and not name.startswith("_")}
    own = {name for name in public if vars(api)[name].__module__ == api.__name__} | {*RE_EXPORTED}
    assert own - {"run", "run_bake", "layer_job", "show_again"} == set(NAMES)  # those take ready settings and states
    for name in own:
        function = vars(api)[name]
        assert {*inspect.signature(function).parameters, "return"} == {*function.__annotations__}, name


@pytest.mark.parametrize("name", NAMES)
def test_what_is_no_object_or_gone_is_refused(name):
    gone = sphere(1)
    bpy.data.objects.remove(gone)
    assert "gone" in refused_or_done(name, gone, **NEEDED.get(name, {}))
    for wrong in WRONG:
        assert refused_or_done(name, wrong, **NEEDED.get(name, {})) is not None, wrong


@pytest.mark.parametrize("name", NAMES)
def test_arguments_of_the_wrong_kind_are_refused_or_taken(name, solved):
    """Of settings, those that other functions share are tried once."""
    own = [p.name for p in list(inspect.signature(getattr(api, name)).parameters.values())[1:]]
    known = [field.name for field in fields(SETTINGS[name])] if name in SETTINGS else []
    for argument in [*(p for p in own if p != "settings"), *known]:
        for wrong in WRONG:
            if argument != "folder" or quote_value(wrong) != "''":  # which would bake
                refused_or_done(name, solved, **{**NEEDED.get(name, {}), argument: wrong})
