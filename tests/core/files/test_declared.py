# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Declared files clash where they are one file, whatever it is called; their folders come and go with the work."""

import os
import sys

import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.files import declared
from synch_fields.core.files.declared import DeclaredFile, check_clashes, check_inputs, make_folders


def read(path):
    return DeclaredFile(str(path), "the input")


def written(path, **more):
    return DeclaredFile(str(path), "--output", is_written=True, **more)


def clashes(*files):
    try:
        check_clashes(files)
    except SettingError as error:
        assert "\n" not in str(error) and "are the same file, name another one" in str(error)
        return True
    return False


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.obj").write_text("a")
    (tmp_path / "folder").mkdir()
    return tmp_path


@pytest.mark.parametrize("name", ["a.obj", "./a.obj", "folder/../a.obj", "folder/link.obj", "other/a.obj", "hard.obj"])
def test_an_output_that_is_an_input_by_any_name_clashes(here, name):
    if sys.platform != "win32":
        (here / "folder" / "link.obj").symlink_to(here / "a.obj")
        (here / "other").symlink_to(here)
    os.link("a.obj", "hard.obj")
    if os.path.exists(name):
        assert clashes(read("a.obj"), written(name)) and clashes(written(here / "a.obj"), read(name))
    assert not clashes(read("a.obj"), read(name))
    assert not clashes(read("a.obj"), written("b.obj"))


@pytest.mark.parametrize("name", ["new/out.json", "new/../new/out.json", "folder/../new/./out.json"])
def test_outputs_that_are_not_there_yet_clash_by_their_places(here, name):
    assert clashes(written("new/out.json"), written(name))
    assert not clashes(written("new/out.json"), written("new/out2.json"), written("out.json"))


def test_a_numbered_set_clashes_with_its_members_and_itself(here):
    parts = written("part.stl", is_numbered=True)
    assert clashes(read("part_000.stl"), parts) and clashes(parts, written("./part_0123.stl"))
    assert clashes(parts, written("folder/../part.stl", is_numbered=True))
    others = "part.stl", "part_00.stl", "part_000.ply", "part_x_000.stl", "folder/part_000.stl"
    assert not clashes(parts, *map(read, others)) and not clashes(parts, *map(written, others))
    assert not clashes(written("part_000.stl"), written("part_001.stl"))
    assert not clashes(parts, written("part_000.stl", is_numbered=True))


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_a_member_of_a_numbered_set_may_be_a_link_to_an_input(here):
    (here / "part_004.stl").symlink_to("a.obj")
    assert clashes(read("a.obj"), written("part.stl", is_numbered=True))


def test_case_counts_where_the_file_system_says_so(here, monkeypatch):
    monkeypatch.setattr(declared, "_ignores_case", lambda folder: False)
    assert not clashes(written("x.json"), written("X.json"))
    monkeypatch.setattr(declared, "_ignores_case", lambda folder: True)
    assert clashes(written("x.json"), written("X.json")) and clashes(
        read("PART_000.stl"), written("part.stl", is_numbered=True)
    )


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_pipes_and_devices_are_refused_as_inputs_and_nothing_else(here):
    os.mkfifo("pipe")
    for path in ("pipe", "/dev/null"):
        with pytest.raises(SettingError, match="the input is a device or a pipe"):
            check_inputs([read(path)])
    check_inputs([read("a.obj"), read("absent.obj"), read("folder"), written("/dev/null")])


def test_folders_are_made_for_the_work_and_go_where_it_fails_without_a_file(here):
    files = [read("in/a.obj"), written("x/y/a.json"), written("x/z/b.json")]
    with pytest.raises(ValueError), make_folders(files):
        assert sorted(os.listdir("x")) == ["y", "z"]
        raise ValueError
    assert sorted(os.listdir()) == ["a.obj", "folder"]
    with pytest.raises(ValueError), make_folders(files):
        (here / "x" / "y" / "a.json").write_text("failed")
        raise ValueError
    assert os.listdir("x") == ["y"]
    with make_folders(files):
        pass
    assert sorted(os.listdir("x")) == ["y", "z"]


def test_a_folder_that_cannot_be_made_is_told_and_nothing_is_left(here):
    with (
        pytest.raises(SettingError, match=r"a\.obj/b\.json: cannot be written \(no folder can be made"),
        make_folders([written("new/b.json"), written("a.obj/b.json")]),
    ):
        raise AssertionError("nothing is to be written")
    assert sorted(os.listdir()) == ["a.obj", "folder"]
