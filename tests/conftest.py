# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests that do not depend on the version of Blender may be shared by runs on several of them, and all tests by
processes that run at once. Fields are searched with few tries, save where the search is what is tested."""

import os
from collections import Counter
from pathlib import Path

import pytest

from synch_fields.core.solve.methods import rounding

TESTS = Path(__file__).parent
# Rooms whose tests every run makes: what is asked of Blender there is what changes from one version to the next.
EACH = {"blender", "looks", "nodes", "operators", "panels"}
# Rooms that are about the search for fields: there it is as long as for users. So it is in files and tests with one of
# these marks, and in child processes. Elsewhere it has this share of the usual number of tries.
SEARCHED, MARKS, FEW, USUAL = ("core/algebra", "core/solve", "bench"), ("full_search", "slow"), 0.2, rounding._effort
# CPU seconds of the files that take SHORT or more without slow tests, as `--measure` writes them; of the others, bytes
# of a file for each second.
TABLE, SHORT, BYTES_PER_SECOND = TESTS / "seconds.txt", 2.0, 8_000
OURS, SPENT = pytest.StashKey[set[Path] | None](), pytest.StashKey[Counter[Path]]()


def pytest_addoption(parser):
    parser.addoption("--share", default="1/1", metavar="K/N", help="of the tests that need no certain Blender, a part")
    parser.addoption("--part", default="1/1", metavar="K/N", help="a part of all tests")
    parser.addoption("--measure", action="store_true", help=f"write the seconds that files take into {TABLE.name}")


def pytest_configure(config):
    config.stash[OURS], config.stash[SPENT] = None, Counter()
    share, part = config.getoption("share"), config.getoption("part")
    if (share, part) != ("1/1", "1/1"):
        # Files on the disk are dealt out, since not every Blender has tests in all of them.
        paths = sorted(TESTS.rglob("test_*.py"))
        shared = deal([path for path in paths if not is_each(path)], share)
        config.stash[OURS] = deal([path for path in paths if path in shared or is_each(path)], part)


def pytest_ignore_collect(collection_path, config):
    """A file is in one share and in one part: what its tests have in common is made once."""
    ours = config.stash[OURS]
    return True if ours is not None and collection_path.suffix == ".py" and collection_path not in ours else None


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item):
    before = sum(os.times()[:4])
    yield
    if item.get_closest_marker("slow") is None:
        item.config.stash[SPENT][item.path] += sum(os.times()[:4]) - before


def pytest_sessionfinish(session):
    if session.config.getoption("measure"):
        spent = {path.relative_to(TESTS).as_posix(): seconds for path, seconds in session.config.stash[SPENT].items()}
        long = {name: seconds for name, seconds in (read_table() | spent).items() if seconds >= SHORT}
        rows = sorted((-round(seconds), name) for name, seconds in long.items() if (TESTS / name).exists())
        TABLE.write_text("".join(f"{-seconds} {name}\n" for seconds, name in rows), encoding="utf-8")


def read_table():
    rows = (line.split() for line in TABLE.read_text(encoding="utf-8").splitlines())
    return {name: float(seconds) for seconds, name in rows}


def is_each(path):
    room = path.relative_to(TESTS).parts
    return room[0] == "addon" and room[1] in EACH


def deal(paths, part):
    """The k-th of n parts, for a part "k/n", that take about the same time: each path, the longest first, goes to the
    part that takes least so far."""
    number, count = map(int, part.split("/"))
    table, parts, totals = read_table(), [set() for _ in range(count)], [0.0] * count
    seconds = {
        path: table.get(path.relative_to(TESTS).as_posix(), min(path.stat().st_size / BYTES_PER_SECOND, SHORT))
        for path in paths
    }
    for path in sorted(paths, key=lambda path: (-seconds[path], path)):
        least = totals.index(min(totals))
        parts[least].add(path)
        totals[least] += seconds[path]
    return parts[number - 1]


def set_search(request):
    """Search for fields with few tries, or as users do."""
    is_full = request.path.relative_to(TESTS).as_posix().startswith(SEARCHED)
    is_full = is_full or any(request.node.get_closest_marker(mark) for mark in MARKS)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rounding, "_effort", USUAL if is_full else lambda size: FEW)
        yield


search_of_the_file = pytest.fixture(set_search, scope="module", autouse=True)
search_of_the_test = pytest.fixture(set_search, autouse=True)
