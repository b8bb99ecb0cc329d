# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lists of things with names, as text."""

import itertools

import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.spec_parser import items, quote_name

FORMS = ("KIND:NAME=STRENGTH", "KIND:NAME:NAME", "NAME=layer")
# Names that hold everything which means something.
NAMES = ("a", " b ", "two words", ",", ":", "=", '"', '""', 'a"b', "a,b=c:d", '",', "x\ny", "ä", "C:\\x y.rosy")


@pytest.mark.parametrize("name", NAMES)
def test_what_is_written_is_read_whatever_the_names_are(name):
    for other in NAMES:
        text = f"uv-u:{quote_name(name)}=0.5, axis:{quote_name(other)}"
        assert items(text, "guidance", FORMS[0]) == [("uv-u", name, "0.5"), ("axis", other, None)]
        text = f"harmonic:{quote_name(name)}:{quote_name(other)}"
        assert items(text, "guidance", FORMS[1]) == [("harmonic", name, other)]
        text = f"{quote_name(name)}=layer,{quote_name(other)} = constant"
        assert items(text, "groups", FORMS[2]) == [(name, "layer"), (other, "constant")]


def test_the_last_name_may_have_colons_as_it_is():
    assert items("file:C:\\a b.rosy=2", "guidance", FORMS[0]) == [("file", "C:\\a b.rosy", "2")]
    assert items("harmonic:a:b:c", "guidance", FORMS[1]) == [("harmonic", "a", "b:c")]
    assert items("a:b=layer", "groups", FORMS[2]) == [("a:b", "layer")]


def test_plain_names_are_written_without_quotes():
    assert [quote_name(name) for name in ("a", "two words", "", "ä")] == ["a", "two words", "", "ä"]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("text", ['a:"b', 'a:"b"c', 'a"b', "a:b=c=d", 'a="b"', 'fine,a:"b'])
def test_what_cannot_be_read_is_named_with_the_form_that_can(text, form):
    with pytest.raises(SettingError) as refused:
        items(text, "thing", form)
    assert str(refused.value).startswith(f"the thing {text.removeprefix('fine,')!r} cannot be read: write {form}, and")


def test_reading_takes_a_time_that_grows_with_the_length_alone():
    """A pattern that gives back what it has read would take hours, one with choices inside choices for ever."""
    for parts in itertools.product((" ", ":", "a ", '""'), repeat=2):
        with pytest.raises(SettingError):
            items("a:" + "".join(parts) * 200_000 + '"', "thing", FORMS[1])
