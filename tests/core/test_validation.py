# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings from keyword arguments: what is taken, what is turned into Python's own kinds, and what is refused."""

from dataclasses import dataclass

import numpy as np
import pytest

from synch_fields.core.errors import SettingError, quote_value
from synch_fields.core.validation import convert_values, from_names


@dataclass(frozen=True)
class Kinds:
    number: float = 0.0
    count: int = 0
    name: str = ""
    is_on: bool = False
    maybe: float | None = None
    rows: tuple[int, ...] | None = None

    def __post_init__(self):
        convert_values(self)


@pytest.mark.parametrize(
    ("name", "given", "kept"),
    [
        ("number", np.float32(0.5), 0.5),
        ("number", 2, 2.0),
        ("count", np.int64(3), 3),
        ("is_on", np.True_, True),
        ("maybe", None, None),
        ("rows", [1, "two"], [1, "two"]),
    ],
)
def test_values_become_pythons_own_kinds(name, given, kept):
    found = getattr(from_names(Kinds, {name: given}), name)
    assert found == kept and type(found) is type(kept)


@pytest.mark.parametrize(
    ("name", "given", "line"),
    [
        ("number", None, "the number is None: give a number"),
        ("number", True, "the number is True: give a number"),
        ("number", "0.5", "the number is '0.5': give a number"),
        ("number", 10**400, "the number is 1000.* \\.\\.\\.: give a smaller number"),
        pytest.param(
            "number", 10**5000, "the number is a number of thousands of digits: give a smaller number", id="huge"
        ),
        ("count", 1.5, "the count is 1.5: give a whole number"),
        ("is_on", 1, "the is on is 1: give True or False"),
        ("name", 3, "the name is 3: give a text"),
        ("name", "a\ud800", "the name is 'a\\\\ud800', which is not text: write it as UTF-8"),
        ("other", 3, "the setting 'other' is unknown: use one of number, count"),
    ],
)
def test_other_values_are_refused_in_one_line(name, given, line):
    with pytest.raises(SettingError, match=line) as caught:
        from_names(Kinds, {name: given})
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 200
    if name in Kinds.__dataclass_fields__:
        with pytest.raises(SettingError, match=line):
            Kinds(**{name: given})


def test_long_values_are_cut_off():
    assert quote_value("short") == "'short'" and len(quote_value("long" * 100)) < 80
