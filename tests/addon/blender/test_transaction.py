# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is left of work that fails, and what comes at its end."""

import os
from contextlib import nullcontext

import bpy
import pytest

from synch_fields.synch_addon.blender.transaction import assign, at_the_end, keep_file, whole_or_nothing

from ..scenes import sphere


def test_work_that_fails_takes_what_is_new_and_gives_back_what_was_changed():
    obj = sphere()
    with pytest.raises(MemoryError), whole_or_nothing():
        bpy.data.materials.new("New")
        assign(obj, "show_wire", True)
        with whole_or_nothing():
            assign(obj, "show_name", True)
        raise MemoryError
    assert "New" not in bpy.data.materials and not obj.show_wire and not obj.show_name
    with whole_or_nothing():
        assign(obj, "show_wire", True)
    assert obj.show_wire


def test_one_end_that_fails_keeps_no_other_from_coming():
    came = []

    def fail():
        raise MemoryError

    with pytest.raises(MemoryError), whole_or_nothing():
        for step in (lambda: came.append(1), fail, lambda: came.append(2)):
            at_the_end(step)
    assert came == [1, 2]
    at_the_end(lambda: came.append(3))
    assert came == [1, 2, 3]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes among files there")
def test_files_come_back_and_what_is_no_file_stays(tmp_path):
    obj = bpy.data.objects.new("Owner", None)
    there, new, pipe = (tmp_path / name for name in ("there.txt", "new.txt", "pipe"))
    there.write_text("old")
    os.mkfifo(pipe)
    for fails in (True, False):
        with pytest.raises(MemoryError) if fails else nullcontext(), whole_or_nothing():
            for path in (there, new, pipe):
                keep_file(obj, path)
            for path in (there, new):
                path.write_text("changed")
            if fails:
                raise MemoryError
        expected = {"pipe", "there.txt"} if fails else {"pipe", "there.txt", "new.txt"}
        assert {path.name for path in tmp_path.iterdir()} == expected and pipe.is_fifo()
        assert there.read_text() == ("old" if fails else "changed")
