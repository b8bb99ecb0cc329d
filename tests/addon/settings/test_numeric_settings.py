# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every numeric setting of every command with numbers far out of range: a result, or one line."""

import json
import math
import warnings
from itertools import product
from types import UnionType
from typing import get_args, get_type_hints

import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.core.printing.machine import Machine
from synch_fields.core.settings import BakeSettings, FlowSettings, LayerSettings, LineSettings, SurfaceSettings
from synch_fields.core.settings.constraints import Constraint
from synch_fields.core.tasks.layer_outputs import PathSettings
from synch_fields.synch_addon import api

from ..scenes import grid, sphere

ODD = [1e-300, 1e300, math.nan, math.inf, 2**62, 10**400, -1]


def numeric_fields(settings):
    """Names of the fields of a dataclass that are numbers."""
    for name, hint in get_type_hints(settings).items():
        if {int, float} & set(get_args(hint) if isinstance(hint, UnionType) else (hint,)):
            yield name


def solved(command, **usual):
    def prepare(_):
        obj = sphere(1)
        return lambda **given: getattr(api, command)(obj, **{"time_limit": 5.0, **usual, **given})

    return prepare


def isolines(_):
    obj = sphere(1)
    api.stripes(obj, spacing=0.7, method="spectral")
    return lambda **given: api.isolines(obj, **given)


def toolpaths(folder):
    obj, machine = sphere(1), folder / "machine.toml"
    api.layers(obj, spacing=0.9, size=0.6, method="spectral")

    def call(step=None, **given):
        lines = [f"{name} = {value if isinstance(value, int) else float(value)}\n" for name, value in given.items()]
        machine.write_text("".join(lines))
        return api.layer_toolpaths(obj, step, path=folder / "part.gcode", machine=machine)

    return call


def clebsch(folder):
    x, y, _ = np.meshgrid(*3 * [np.linspace(-1, 1, 6)], indexing="ij")
    np.savez(folder / "flow.npz", velocity=np.stack([-y, x, 0 * x], axis=-1) * np.exp(-4 * (x**2 + y**2))[..., None])
    return lambda **given: api.clebsch(folder / "flow.npz", **{"time_limit": 5.0, "quantum": 0.05, **given})


def constrained(_):
    obj, row = grid(4), {"where": "boundary", "what": "angle"}
    return lambda **given: api.stripes(obj, spacing=0.5, method="spectral", constraints=[row | given])


# The settings of each command, and what makes a function that runs it from a folder.
WORK = {
    "directions": (SurfaceSettings, solved("directions")),
    "stripes": (SurfaceSettings, solved("stripes", spacing=0.7, method="spectral")),
    "quads": (SurfaceSettings, solved("quads", spacing=0.7, method="spectral")),
    "quad_mesh": (SurfaceSettings, solved("quad_mesh", spacing=0.7, method="spectral")),
    "layers": (LayerSettings, solved("layers", spacing=0.7, size=0.4, method="spectral")),
    "clebsch": (FlowSettings, clebsch),
    "isolines": (LineSettings, isolines),
    "bake": (BakeSettings, solved("bake", folder="/nowhere")),
    "machine": (Machine, toolpaths),
    "paths": (PathSettings, toolpaths),
    "constraint": (Constraint, constrained),
}


@pytest.mark.parametrize("command", WORK)
def test_numbers_out_of_range_are_refused_or_work(command, tmp_path):
    settings, prepare = WORK[command]
    run = prepare(tmp_path)
    for name, value in product(numeric_fields(settings), ODD):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                report = run(**{name: value})
            except SynchError as error:
                assert str(error) and "\n" not in str(error), (name, value)
                continue
        json.dumps(report, allow_nan=False)


@pytest.mark.parametrize("settings", [Machine, PathSettings, Constraint])
def test_what_is_not_a_number_is_refused(settings):
    """Of those that are not declared by records; tests/core/settings tries the others."""
    needed = {"where": "boundary", "what": "angle"} if settings is Constraint else {}
    for name, value in product(numeric_fields(settings), (math.nan, 1e300, 1e-300)):
        with pytest.raises(SynchError):
            settings(**needed, **{name: value})
            pytest.fail(f"{name} may be {value}")
