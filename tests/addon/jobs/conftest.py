# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""No job is left by a test of jobs, and the child serves the tests of a file: its start takes a second."""

import bpy
import pytest

from synch_fields.synch_addon.jobs.queue import queue


@pytest.fixture(autouse=True)
def blender(extension):
    """bpy with an empty scene, for which the child that an earlier test has left stays."""
    worker, queue._worker = queue._worker, None
    bpy.ops.wm.read_homefile(use_empty=True)
    queue._worker = worker
    yield bpy
    assert queue.running is None


@pytest.fixture(autouse=True, scope="module")
def child_of_the_file(extension):
    yield
    queue.stop()
