# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests that do not depend on the version of Blender may be shared by runs on several of them, and all tests by
processes that run at once. Fields are searched with few tries, save where the search is what is tested."""

from pathlib import Path

import pytest

from synch_fields.core.solve.methods import rounding

TESTS = Path(__file__).parent
# Rooms whose tests every run makes: what is asked of Blender there is what changes from one version to the next.
EACH = {"blender", "looks", "nodes", "operators", "panels"}
# Rooms that are about the search for fields: there it is as long as for users. So it is in files and tests with one of
# these marks, and in child processes. Elsewhere it has this share of the usual number of tries.
SEARCHED, MARKS, FEW, USUAL = ("core/algebra", "core/solve", "bench"), ("full_search", "slow"), 0.2, rounding._effort


def pytest_addoption(parser):
    parser.addoption("--share", default="1/1", metavar="K/N", help="of the tests that need no certain Blender, a part")
    parser.addoption("--part", default="1/1", metavar="K/N", help="a part of all tests")


def pytest_collection_modifyitems(config, items):
    """A file is in one share and in one part: what its tests have in common is made once."""
    # Long files take long. Those on the disk are dealt out, since not every Blender has tests in all of them.
    paths = sorted(TESTS.rglob("test_*.py"), key=lambda path: (-path.stat().st_size, path))
    shared = deal([path for path in paths if not is_each(path)], config.getoption("share"))
    ours = deal([path for path in paths if path in shared or is_each(path)], config.getoption("part"))
    config.hook.pytest_deselected(items=[item for item in items if item.path not in ours])
    items[:] = [item for item in items if item.path in ours]


def is_each(path):
    room = path.relative_to(TESTS).parts
    return room[0] == "addon" and room[1] in EACH


def deal(paths, part):
    """Every n-th path for a part "k/n": first and last take turns, so that none has the longer one every time."""
    number, count = map(int, part.split("/"))
    return set(paths[number - 1 :: 2 * count] + paths[2 * count - number :: 2 * count])


def set_search(request):
    """Search for fields with few tries, or as users do."""
    is_full = request.path.relative_to(TESTS).as_posix().startswith(SEARCHED)
    is_full = is_full or any(request.node.get_closest_marker(mark) for mark in MARKS)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rounding, "_effort", USUAL if is_full else lambda size: FEW)
        yield


search_of_the_file = pytest.fixture(set_search, scope="module", autouse=True)
search_of_the_test = pytest.fixture(set_search, autouse=True)
