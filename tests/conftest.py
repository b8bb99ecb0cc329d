# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests that do not depend on the version of Blender may be shared by runs on several of them, and all tests by
processes that run at once."""

from pathlib import Path
from zlib import crc32

# Rooms whose tests every run makes: what is asked of Blender there is what changes from one version to the next.
EACH = {"blender", "looks", "nodes", "operators", "panels"}


def pytest_addoption(parser):
    parser.addoption("--share", default="1/1", metavar="K/N", help="of the tests that need no certain Blender, a part")
    parser.addoption("--part", default="1/1", metavar="K/N", help="a part of all tests")


def pytest_collection_modifyitems(config, items):
    """A file is in one share and in one part: what its tests have in common is made once."""
    share, shares = map(int, config.getoption("share").split("/"))
    part, parts = map(int, config.getoption("part").split("/"))

    def is_ours(item):
        path = Path(item.path).relative_to(Path(__file__).parent)
        number = crc32(path.as_posix().encode())
        is_each = path.parts[0] == "addon" and path.parts[1] in EACH
        return (is_each or number % shares == share - 1) and number // shares % parts == part - 1

    config.hook.pytest_deselected(items=[item for item in items if not is_ours(item)])
    items[:] = filter(is_ours, items)
