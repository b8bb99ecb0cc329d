# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows in damaged files of arrays, each refused in one line."""

from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.files.flows import flow_file


@pytest.fixture
def sound(tmp_path):
    path = tmp_path / "flow.npz"
    np.savez_compressed(path, velocity=np.random.default_rng(0).standard_normal((4, 5, 6, 3)), spacing=0.5)
    return path


def refusal(path):
    """The one line that refuses a file, or None."""
    source = flow_file(path)
    assert source.is_plane in (True, False)
    try:
        source.read()
    except SettingError as error:
        assert str(error).startswith(str(path)) and "\n" not in str(error)
        return str(error)
    return None


def test_a_member_that_is_no_array_is_named(tmp_path):
    path = tmp_path / "flow.npz"
    with ZipFile(path, "w") as archive:
        archive.writestr("velocity.npy", b"not an array at all")
    assert "its member velocity is not an array" in refusal(path)


def test_damaged_files_are_refused_wherever_the_damage_is(sound):
    whole = sound.read_bytes()
    assert refusal(sound) is None
    random = np.random.default_rng(1)
    refused = 0
    for place in range(0, len(whole), 7):
        broken = bytearray(whole)
        broken[place] ^= random.integers(1, 256)
        sound.write_bytes(broken)
        refused += refusal(sound) is not None
        sound.write_bytes(whole[:place])
        assert refusal(sound) is not None
    assert refused > 100


def test_members_that_are_encrypted_or_packed_in_an_unknown_way_are_refused(sound):
    with ZipFile(sound, "w", ZIP_DEFLATED) as archive:
        archive.writestr("velocity.npy", bytes(100))
    whole = bytearray(sound.read_bytes())
    central = whole.index(b"PK\x01\x02")
    for place, value in ((8, 1), (10, 97)):
        broken = bytearray(whole)
        broken[central + place] = value
        broken[place - 2] = value
        sound.write_bytes(broken)
        assert refusal(sound)


def test_obstacles_come_from_the_file(tmp_path):
    velocity = np.random.default_rng(0).standard_normal((4, 5, 6, 3))
    solid = np.zeros((4, 5, 6), np.uint8)
    solid[1, 2, 3:] = 1
    velocity[solid > 0] = np.nan
    path = tmp_path / "flow.npz"
    np.savez(path, velocity=velocity, solid=solid)
    flow = flow_file(path).read()
    np.testing.assert_array_equal(flow.own.solid, solid > 0)
    assert np.isfinite(flow.integrals(flow.own)).all()
    np.savez(path, velocity=velocity, solid=solid[:3])
    assert "solid has uint8 values of the shape (3, 5, 6): give true or false" in refusal(path)
    np.savez(path, velocity=velocity, solid=0.5 * solid)
    assert "float64" in refusal(path)
