# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings are declared once: every number has one range, and what is made from the records agrees with them."""

import importlib.util
import math
from dataclasses import dataclass
from pathlib import Path
from typing import get_origin

import numpy as np
import pytest

from synch_fields.core import settings as core_settings
from synch_fields.core.connection import Connection
from synch_fields.core.errors import SettingError
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.settings.setting import (
    LARGEST,
    SMALLEST,
    SettingsRecord,
    default_of,
    records,
    setting,
    value_type,
)
from synch_fields.core.solve import Options, solve

ROOT = Path(__file__).resolve().parents[3]
KINDS = [
    core_settings.SurfaceSettings,
    core_settings.LayerSettings,
    core_settings.FlowSettings,
    core_settings.BakeSettings,
    core_settings.LineSettings,
]
NUMBERS = [
    pytest.param(kind, name, record, id=f"{kind.__name__}.{name}")
    for kind in KINDS
    for name, record in records(kind)
    if value_type(kind, name) in (int, float)
]


@pytest.fixture(scope="module")
def tool():
    """tools/settings.py as a module."""
    spec = importlib.util.spec_from_file_location("settings_tool", ROOT / "tools" / "settings.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("path", ["core/settings/keywords.py", "docs/reference.md"])
def test_files_made_from_the_records_are_of_today(tool, path):
    make = tool.keywords if path.endswith(".py") else tool.reference
    assert (ROOT / path).read_text(encoding="utf-8") == make(), "run python tools/settings.py"


@pytest.mark.parametrize("kind, name, record", NUMBERS)
def test_numbers_out_of_range_are_refused_in_one_line(kind, name, record):
    values = [math.nan, math.inf, -math.inf, 1e300, -1e300, 10**400]
    if record.least > 0:  # where 0 is allowed, so little is 0 to all that uses it
        values.append(1e-300)
    for value in values:
        with pytest.raises(SettingError) as refused:
            kind(**{name: value})
        assert name.replace("_", " ") in str(refused.value)
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize("kind, name, record", NUMBERS)
def test_the_ends_of_the_range_are_taken_and_what_lies_beyond_is_not(kind, name, record):
    step = 1 if value_type(kind, name) is int else None
    for end, sign in ((record.least, -1), (record.most, 1)):
        if abs(end) >= LARGEST:
            continue
        record.check(name, end)
        with pytest.raises(SettingError):
            record.check(name, end + sign * (step or max(abs(end), 1) * 1e-9))


@pytest.mark.parametrize("kind", KINDS)
def test_defaults_are_allowed_and_of_their_type(kind):
    made = kind()
    for name, record in records(kind):
        value, of_type = getattr(made, name), value_type(kind, name)
        assert value is None or isinstance(value, get_origin(of_type) or of_type)
        record.check(name, value)
        for variant in record.variants:
            record.check(name, default_of(kind, name, variant))


@pytest.mark.parametrize("kind", KINDS)
def test_every_record_says_what_it_is(kind):
    for name, record in records(kind):
        assert record.label and record.tip, name
        assert not record.tip.endswith("."), name
        assert record.start is not None or default_of(kind, name) is not None or not record.group or record.unset, name
        assert not record.part_of or record.part_of in dict(records(kind)), name


def test_unknown_choices_are_refused_with_those_that_exist():
    for kind in KINDS:
        for name, record in records(kind):
            if record.choices and value_type(kind, name) is str:
                with pytest.raises(SettingError, match="is unknown: use one of " + record.choices[0].name):
                    kind(**{name: "no such choice"})


@pytest.mark.parametrize("name, value", [("target_gap", 0.6), ("target_gap", 1e-9), ("time_limit", 0.0)])
def test_the_solver_has_the_range_of_the_record(name, value):
    problem = SynchronizationProblem(Connection(2, np.array([[0, 1]]), np.ones(1), np.ones(1, complex)))
    with pytest.raises(SettingError) as by_settings:
        core_settings.SolverSettings(**{name: value})
    with pytest.raises(SettingError) as by_solver:
        solve(problem, Options(**{name: value}))
    assert str(by_settings.value) == str(by_solver.value)


def test_a_new_group_of_settings_is_checked_by_its_records_alone():
    @dataclass(frozen=True, kw_only=True)
    class Knobs(SettingsRecord):
        """Three knobs."""

        count: int = setting(3, "Count", "How many", least=1, most=9)
        width: float | None = setting(None, "Width", "How wide", least=SMALLEST, unset="as wide as it comes")

    assert Knobs(count=np.int64(4), width=1) == Knobs(count=4, width=1.0)
    for wrong in ({"count": 0}, {"count": 2.5}, {"width": 0}, {"width": "x"}, {"width": True}):
        with pytest.raises(SettingError):
            Knobs(**wrong)


@pytest.mark.parametrize("heights", [(0.2, 0.1), (0.1, 0.1)])
def test_heights_that_no_layer_is_between_are_refused(heights):
    with pytest.raises(SettingError, match="no layer is between"):
        core_settings.LayerSettings(smallest_height=heights[0], largest_height=heights[1])
