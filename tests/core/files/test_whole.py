# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files are written whole or not at all, and their checks see where one was cut off."""

import errno
import itertools
import os
import stat
import struct
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.files import meshes
from synch_fields.core.files.directions import FaceField, write_field
from synch_fields.core.files.whole import check_writable, is_whole_image, write_text, write_together, write_whole


@pytest.fixture
def place(tmp_path):
    """A file that exists."""
    path = tmp_path / "given.txt"
    path.write_text("old")
    return path


def test_a_file_takes_the_place_of_an_older_one_at_the_end(place):
    with write_whole(place) as made:
        assert made.parent == place.parent and made.suffix == ".txt"
        made.write_text("new")
        assert place.read_text() == "old"
    assert place.read_text() == "new" and os.listdir(place.parent) == ["given.txt"]


@pytest.mark.parametrize("fault", [ValueError("broken"), KeyboardInterrupt(), MemoryError()])
def test_whatever_goes_wrong_leaves_the_older_file_and_nothing_else(place, fault):
    with pytest.raises(type(fault)), write_whole(place) as made:
        made.write_text("half of i")
        raise fault
    assert place.read_text() == "old" and os.listdir(place.parent) == ["given.txt"]


@pytest.mark.parametrize(
    ("write", "words"),
    [
        (lambda made: None, "nothing arrived"),
        (lambda made: made.write_text(""), "nothing arrived"),
        (lambda made: made.write_text("half"), "only a part arrived"),
        (lambda made: os.open(made.parent / "no" / "such", os.O_RDONLY), "No such file or directory"),
    ],
)
def test_what_is_not_complete_is_refused_in_one_line(place, write, words):
    with pytest.raises(SettingError) as caught, write_whole(place, lambda made: made.read_text() == "whole") as made:
        write(made)
    assert str(caught.value) == f"{place}: cannot be written ({words}): make room, or choose another place"
    assert place.read_text() == "old" and os.listdir(place.parent) == ["given.txt"]


@pytest.mark.skipif(sys.platform == "win32", reason="permissions and links are other ones there")
def test_links_and_permissions_stay(place, tmp_path):
    place.chmod(0o640)
    link = tmp_path / "link.txt"
    link.symlink_to(place)
    write_text(link, "new")
    assert link.is_symlink() and place.read_text() == "new" and stat.S_IMODE(place.stat().st_mode) == 0o640


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no device without room")
def test_a_device_is_written_to_as_it_is(tmp_path):
    link = tmp_path / "full.txt"
    link.symlink_to("/dev/full")
    with pytest.raises(SettingError, match=r"full\.txt: cannot be written \(No space left on device\)"):
        write_text(link, "new")
    assert link.is_symlink()
    write_text("/dev/null", "new")
    with pytest.raises(SettingError, match="this is not a file"), write_whole("/dev/null", lambda made: True):
        raise AssertionError("nothing is to be written")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_a_pipe_gets_all_where_somebody_reads_and_is_refused_at_once_where_nobody_does(tmp_path):
    pipe = tmp_path / "pipe.txt"
    os.mkfifo(pipe)
    with pytest.raises(SettingError, match=r"pipe\.txt: cannot be written"):
        write_text(pipe, "lost")
    with open(os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)) as reader:
        write_text(pipe, "all of it")
        assert reader.read() == "all of it"
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_folders_that_are_none_or_not_there_are_refused_before(tmp_path, place):
    for path in (tmp_path / "none" / "file.txt", place / "file.txt"):
        with pytest.raises(SettingError, match="cannot be written"):
            check_writable(path)
    with pytest.raises(SettingError, match="this is a folder"):
        write_text(tmp_path, "new")
    check_writable(place)
    check_writable(tmp_path / ("long" * 60 + ".txt"))
    assert place.read_text() == "old" and os.listdir(tmp_path) == ["given.txt"]


def test_of_many_writers_at_once_one_leaves_a_whole_file(place):
    texts = [str(number) * 100_000 for number in range(8)]
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda text: write_text(place, text), texts))
    assert place.read_text() in texts and os.listdir(place.parent) == ["given.txt"]


def test_a_field_that_cannot_be_written_leaves_the_older_one(tmp_path):
    path = tmp_path / "field.rosy"
    path.write_text("old")
    with pytest.raises(SettingError, match="turn"):
        write_field(path, FaceField(4, np.ones((2, 4, 3))))
    assert path.read_text() == "old"


# Sets of files


def write_set(folder, *texts):
    """Write numbered files together; a text of None fails as a full disk does."""
    with write_together() as written:
        for number, text in enumerate(texts):
            with written(folder / f"part_{number:03d}.txt") as made:
                if text is None:
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(made))
                made.write_text(text)


def contents(folder):
    return {path.name: path.read_text() for path in folder.iterdir()}


def test_a_set_takes_its_places_together(tmp_path):
    write_set(tmp_path, "a", "b", "c")
    before = contents(tmp_path)
    assert before == {"part_000.txt": "a", "part_001.txt": "b", "part_002.txt": "c"}
    with pytest.raises(SettingError, match=r"part_002\.txt: cannot be written \(No space left on device\)"):
        write_set(tmp_path, "x", "y", None)
    with pytest.raises(SettingError, match="nothing arrived"):
        write_set(tmp_path, "x", "", "z", "u")
    assert contents(tmp_path) == before
    write_set(tmp_path, "x", "y")
    assert contents(tmp_path) == {"part_000.txt": "x", "part_001.txt": "y", "part_002.txt": "c"}


@pytest.mark.parametrize("links", [True, False])
@pytest.mark.parametrize("moment", range(3))
def test_a_set_whose_files_cannot_all_take_their_places_leaves_the_older_ones(tmp_path, monkeypatch, moment, links):
    write_set(tmp_path, "a", "b")
    replace, count = os.replace, itertools.count()

    def failing(made, target):
        if next(count) == moment:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        replace(made, target)

    def no_links(*_):
        raise OSError(errno.EPERM, os.strerror(errno.EPERM))

    if not links:
        monkeypatch.setattr(os, "link", no_links)
    monkeypatch.setattr(os, "replace", failing)
    with pytest.raises(SettingError, match=rf"part_00{moment}\.txt: cannot be written"):
        write_set(tmp_path, "x", "y", "new")
    assert contents(tmp_path) == {"part_000.txt": "a", "part_001.txt": "b"}


# Files that were cut off


def obj(tmp_path):
    path = tmp_path / "mesh.obj"
    path.write_text("# made\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 0 0 1\nf 1 2 3\nf 2 4 3\n")
    return path


def stl(tmp_path):
    path = tmp_path / "mesh.stl"
    path.write_bytes(b"solid".ljust(80) + struct.pack("<I", 2) + bytes(100))
    return path


def ply(tmp_path):
    path = tmp_path / "mesh.ply"
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment made\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property double z\nproperty uchar kind\nelement face 2\nproperty list uchar uint vertex_indices\nend_header\n"
    )
    faces = struct.pack("<B3I", 3, 0, 1, 2) + struct.pack("<B4I", 4, 0, 1, 3, 2)
    path.write_bytes(header.encode() + bytes(4 * 17) + faces)
    return path


@pytest.mark.parametrize("make", [obj, stl, ply])
def test_a_mesh_file_that_is_cut_off_anywhere_is_not_whole(make, tmp_path):
    path = make(tmp_path)
    whole = path.read_bytes()
    assert meshes.is_whole(path, 4, 2)
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        assert not meshes.is_whole(path, 4, 2), length
    path.write_bytes(whole + b"0")
    assert not meshes.is_whole(path, 4, 2)


HEADER = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ("", "does not begin with ply"),
        (HEADER.replace("ply", "plu"), "does not begin with ply"),
        (HEADER.replace("vertex 3", "vertex 99999999999999999999"), "it has the line 'element vertex 9999"),
        (HEADER.replace("vertex 3", "vertex -3"), "it has the line 'element vertex -3'"),
        (HEADER.replace("vertex 3", "vertex 2000000000"), "promises more than"),
        (HEADER.replace("vertex 3", "vertex"), "it has the line 'element vertex'"),
        (HEADER.replace("float y", "floaty y"), "it has the line 'property floaty y'"),
        (HEADER.replace("element vertex 3\n", ""), "it has the line 'property float x'"),
        (HEADER.replace("ascii", "utf"), "it has the line 'format utf 1.0'"),
        (HEADER.replace("format ascii 1.0\n", ""), "it has no format"),
        (HEADER + "element face 1\nproperty list float int vertex_indices\n", "it has the line 'property list float"),
    ],
)
def test_headers_that_are_none_are_refused_before_blender_sees_them(tmp_path, header, words):
    path = tmp_path / "mesh.ply"
    path.write_bytes((header + "end_header\n" if header else "").encode("latin-1") + b"0 0 0\n1 0 0\n0 1 0\n")
    with pytest.raises(SettingError, match=words) as caught:
        meshes.check_ply(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


def test_sound_headers_pass(tmp_path):
    meshes.check_ply(ply(tmp_path))
    path = tmp_path / "text.ply"
    for end, comment, encoding in (
        ("\n", "", "ascii"),
        ("\r\n", "", "ascii"),
        ("\n", "comment TextureFile \xc5\u2026.png\nobj_info \xe4\n", "utf-8"),  # bytes that end lines of text
        ("\r\n", "comment by M\xfcller \x85\n", "latin-1"),
    ):
        text = (
            HEADER
            + comment
            + "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
        )
        path.write_text(text.replace("\n", end), encoding, newline="")
        meshes.check_ply(path)


def test_a_picture_that_is_cut_off_is_not_whole(tmp_path):
    path = tmp_path / "picture.png"
    path.write_bytes(b"\x89PNG...\x00\x00\x00\x00IEND\xaeB`\x82")
    assert is_whole_image(path)
    path.write_bytes(path.read_bytes()[:-1])
    assert not is_whole_image(path)
