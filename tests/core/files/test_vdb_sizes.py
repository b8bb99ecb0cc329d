# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts of OpenVDB files: what the bytes hold passes, what they cannot hold is refused at once."""

import struct

import pytest

from synch_fields.core.files.openvdb import check_vdb_sizes


def text(word):
    return struct.pack("<I", len(word)) + word.encode()


def vdb(path, metadata=0, grids=1, tiles=0, children=1, end=None, version=224):
    """An OpenVDB file of one grid of vectors up to its root's child."""
    head = b" BDV\0\0\0\0" + struct.pack("<3Ib", version, 10, 0, 1) + bytes(36) + struct.pack("<2I", metadata, grids)
    names = text("velocity") + text("Tree_vec3s_5_4_3") + text("")
    begin = len(head) + len(names) + 24
    grid = struct.pack("<2I", 0, 0) + text("UniformScaleMap") + bytes(120)
    grid += struct.pack("<I", 1) + bytes(12) + struct.pack("<2I", tiles, children) + bytes(25)
    places = struct.pack("<3q", begin, begin, begin + len(grid) if end is None else end)
    path.write_bytes(head + names + places + grid)
    return path


def test_sizes_that_the_bytes_hold_pass(tmp_path):
    check_vdb_sizes(vdb(tmp_path / "one.vdb"))
    check_vdb_sizes(vdb(tmp_path / "tile.vdb", tiles=1, children=0))
    check_vdb_sizes(vdb(tmp_path / "old.vdb", metadata=2**32 - 1, version=213))
    (tmp_path / "other.vdb").write_bytes(b"another kind")
    check_vdb_sizes(tmp_path / "other.vdb")


@pytest.mark.parametrize(
    "promised",
    [{"metadata": 2**32 - 1}, {"grids": 2**32 - 1}, {"tiles": 2}, {"children": 2**32 - 1}, {"end": -1}, {"end": 10**9}],
    ids=str,
)
def test_what_is_only_promised_is_refused(tmp_path, promised):
    with pytest.raises(ValueError, match=r"it promises|it has something at byte"):
        check_vdb_sizes(vdb(tmp_path / "bomb.vdb", **promised))


def test_a_file_that_is_cut_off_is_refused(tmp_path):
    path = vdb(tmp_path / "cut.vdb")
    content = path.read_bytes()
    for length in range(12, len(content) - 25, 7):
        path.write_bytes(content[:length])
        with pytest.raises(ValueError):
            check_vdb_sizes(path)
