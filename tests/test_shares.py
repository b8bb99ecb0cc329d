# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shares and parts of the tests: every file is in one of them, and they take about as long as one another."""

from types import SimpleNamespace

import pytest

from . import conftest

FILES = {path for path in conftest.TESTS.rglob("test_*.py")}


def ours(share="1/1", part="1/1"):
    """The files that a run with these options makes."""
    options = {"share": share, "part": part, "measure": False}
    config = SimpleNamespace(stash=pytest.Stash(), getoption=options.get)
    conftest.pytest_configure(config)
    assert not any(conftest.pytest_ignore_collect(path.parent, config) for path in FILES)
    return {path for path in FILES if not conftest.pytest_ignore_collect(path, config)}


def seconds(paths):
    table = conftest.read_table()
    return sum(table.get(path.relative_to(conftest.TESTS).as_posix(), 0) for path in paths)


def test_every_file_is_in_one_part():
    assert ours() == FILES
    parts = [ours(part=f"{k}/3") for k in (1, 2, 3)]
    assert set.union(*parts) == FILES and sum(map(len, parts)) == len(FILES)


def test_every_file_is_in_one_share_and_those_about_blender_in_each():
    shares = [ours(share=f"{k}/2") for k in (1, 2)]
    assert set.union(*shares) == FILES
    assert set.intersection(*shares) == {path for path in FILES if conftest.is_each(path)}
    inside = [ours("1/2", f"{k}/2") for k in (1, 2)]
    assert set.union(*inside) == shares[0] and not set.intersection(*inside)


@pytest.mark.parametrize("option", ["share", "part"])
def test_shares_and_parts_take_about_the_same_time(option):
    first, second = (seconds(ours(**{option: f"{k}/2"})) for k in (1, 2))
    assert abs(first - second) < 0.03 * (first + second)


def test_the_table_is_of_files_that_are_here():
    assert all((conftest.TESTS / name).is_file() for name in conftest.read_table())


def test_what_was_measured_goes_into_the_table_and_the_rest_of_it_stays(tmp_path, monkeypatch):
    short, long, other = "core/test_gauge.py", "core/test_memory.py", "test_package.py"
    (tmp_path / "seconds.txt").write_text(f"9 {other}\n3 {short}\n2 core/test_gone.py\n")
    monkeypatch.setattr(conftest, "TABLE", tmp_path / "seconds.txt")
    stash = pytest.Stash()
    stash[conftest.SPENT] = {conftest.TESTS / short: 0.4, conftest.TESTS / long: 9.2}
    conftest.pytest_sessionfinish(SimpleNamespace(config=SimpleNamespace(stash=stash, getoption=lambda name: True)))
    assert conftest.TABLE.read_text() == f"9 {long}\n9 {other}\n"
