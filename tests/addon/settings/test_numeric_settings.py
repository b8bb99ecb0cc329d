# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every numeric setting of every command with numbers far out of range: a result, or one line."""

import json
import math
import warnings
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

ODD = [1e-300, 1e-20, 1e20, 1e300, -1e300, math.nan, math.inf, -math.inf, 2**62, 10**400, -1]


def numeric_fields(settings):
    """Names of the fields of a dataclass that are numbers."""
    for name, hint in get_type_hints(settings).items():
        if {int, float} & set(get_args(hint) if isinstance(hint, UnionType) else (hint,)):
            yield name


def solved_on(make, command, **usual):
    return lambda _, **given: getattr(api, command)(make(), **{"time_limit": 5.0, **usual, **given})


def isolines(_, **given):
    obj = sphere(1)
    api.stripes(obj, spacing=0.7, method="spectral")
    return api.isolines(obj, **given)


def toolpaths(folder, **given):
    obj = sphere(1)
    api.layers(obj, spacing=0.7, size=0.4, method="spectral")
    step, machine = given.pop("step", None), folder / "machine.toml"
    machine.write_text(
        "".join(f"{name} = {value if isinstance(value, int) else float(value)}\n" for name, value in given.items())
    )
    return api.layer_toolpaths(obj, step, path=folder / "part.gcode", machine=machine)


def clebsch(folder, **given):
    x, y, _ = np.meshgrid(*3 * [np.linspace(-1, 1, 6)], indexing="ij")
    np.savez(folder / "flow.npz", velocity=np.stack([-y, x, 0 * x], axis=-1) * np.exp(-4 * (x**2 + y**2))[..., None])
    return api.clebsch(folder / "flow.npz", **{"time_limit": 5.0, **given})


def constrained(_, **given):
    row = {"where": "boundary", "what": "angle", **given}
    return api.stripes(grid(4), spacing=0.5, method="spectral", constraints=[row])


WORK = {
    "directions": (SurfaceSettings, solved_on(lambda: sphere(1), "directions")),
    "stripes": (SurfaceSettings, solved_on(lambda: sphere(1), "stripes", spacing=0.7, method="spectral")),
    "quads": (SurfaceSettings, solved_on(lambda: sphere(1), "quads", spacing=0.7, method="spectral")),
    "quad_mesh": (SurfaceSettings, solved_on(lambda: sphere(1), "quad_mesh", spacing=0.7)),
    "layers": (LayerSettings, solved_on(lambda: sphere(1), "layers", spacing=0.7, size=0.4, method="spectral")),
    "clebsch": (FlowSettings, clebsch),
    "isolines": (LineSettings, isolines),
    "bake": (BakeSettings, solved_on(lambda: sphere(1), "bake", folder="/nowhere")),
    "machine": (Machine, toolpaths),
    "paths": (PathSettings, toolpaths),
    "constraint": (Constraint, constrained),
}
CASES = [(command, name) for command, (settings, _) in WORK.items() for name in numeric_fields(settings)]


@pytest.mark.parametrize(("command", "name"), CASES)
def test_numbers_out_of_range_are_refused_or_work(command, name, tmp_path):
    for value in ODD:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                report = WORK[command][1](tmp_path, **{name: value})
            except SynchError as error:
                assert str(error) and "\n" not in str(error), value
                continue
        json.dumps(report, allow_nan=False)


@pytest.mark.parametrize(("command", "name"), CASES)
def test_what_is_not_a_number_is_refused(command, name):
    settings = WORK[command][0]
    needed = {"where": "boundary", "what": "angle"} if settings is Constraint else {}
    for value in (math.nan, 1e300, 1e-300):
        with pytest.raises(SynchError):
            settings(**needed, **{name: value})
