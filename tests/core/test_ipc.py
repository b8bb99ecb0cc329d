# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages between processes: whole again however they come, arrays uncopied and usable, nonsense told from them."""

import numpy as np
import pytest

from synch_fields.core.errors import AsymmetryError, ContradictionError, MeshError, SettingError, SynchError
from synch_fields.core.process.ipc import MARK, BrokenParcel, Unpacker, pack_parts

MESSAGE = {"numbers": np.arange(1000.0), "more": [np.eye(3)[:, ::2], "text"], "empty": np.empty((0, 3)), "none": None}


def sent(message, shared=()):
    return b"".join(bytes(part) for part in pack_parts(message, shared))


def same(found, expected):
    return (
        found.keys() == expected.keys()
        and np.array_equal(found["numbers"], expected["numbers"])
        and np.array_equal(found["more"][0], expected["more"][0])
        and found["more"][1] == "text"
        and found["empty"].shape == (0, 3)
    )


@pytest.mark.parametrize("seed", range(5))
def test_parcels_are_whole_again_in_whatever_pieces_they_come(seed):
    random = np.random.default_rng(seed)
    data, unpacker, found, place = 3 * sent(MESSAGE), Unpacker(), [], 0
    while place < len(data):
        size = int(random.choice([1, 2, 7, 31, 64, 1000, 100_000]))
        found += unpacker.feed(data[place : place + size])
        place += size
    assert len(found) == 3 and all(same(message, MESSAGE) for message in found)


def test_arrays_can_be_written_and_lie_where_processors_want_them():
    (message,) = Unpacker().feed(sent(MESSAGE))
    for array in (message["numbers"], message["more"][0]):
        assert array.flags.writeable and array.flags.aligned
    message["numbers"] += 1


def test_arrays_travel_beside_the_pickle_not_in_it():
    head, pickled, *_ = pack_parts({"a": np.zeros(100_000), "b": np.ones(100_000, complex)})
    assert len(pickled) < 1000 and head.startswith(MARK)


def test_what_the_other_end_has_travels_as_its_place():
    theirs, ours = np.arange(100_000.0), object()
    data = sent({"mesh": theirs, "again": theirs}, (None, theirs))
    assert len(data) < 1000
    (message,) = Unpacker((None, ours)).feed(data)
    assert message["mesh"] is ours and message["again"] is ours


@pytest.mark.parametrize(
    "data",
    [b"Blender 5.2.2", MARK[:7] + b"x", MARK + b"\xff" * 8, MARK + bytes(8), MARK + b"\1" + bytes(7) + b"\xff" * 8],
    ids=["text", "half a mark", "too many parts", "no part", "too many bytes"],
)
def test_nonsense_is_no_parcel(data):
    with pytest.raises(BrokenParcel):
        Unpacker().feed(data)


@pytest.mark.parametrize("seed", range(20))
def test_damaged_parcels_are_refused_or_read_but_nothing_else(seed):
    random = np.random.default_rng(seed)
    data = np.frombuffer(sent({"text": "abc", "numbers": np.arange(4)}), np.uint8).copy()
    for place in random.integers(len(MARK) + 24, 200, 3):
        data[place] = random.integers(256)
    try:
        Unpacker().feed(data.tobytes())
    except BrokenParcel:
        pass


@pytest.mark.parametrize(
    "error",
    [
        SynchError("a line"),
        MeshError("a line", [3, 1]),
        SettingError("a line"),
        ContradictionError("at {vertices} two wishes", [5, 2]),
        AsymmetryError("X", [7]),
    ],
)
def test_errors_come_through_as_they_are(error):
    (found,) = Unpacker().feed(sent(error))
    assert type(found) is type(error) and str(found) == str(error)
    np.testing.assert_array_equal(found.vertices, error.vertices)
