# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How random cases are tried and counted, and what each of them must end with: a result, or one line.

`tools/fuzz.py` asks for more cases by the variables of the environment below; the tests take a few that are always the
same.
"""

import contextlib
import faulthandler
import io
import json
import os
import sys
import tempfile
import warnings
from collections import Counter
from functools import wraps
from pathlib import Path

import bpy
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon.command.main import main

from .scenes import snapshot

hypothesis = pytest.importorskip("hypothesis")
st = hypothesis.strategies

# How many cases each test tries, where what fails is kept, and the file that gets the counts of what came out.
CASES = int(os.environ.get("SYNCH_FUZZ_CASES", "6"))
KEPT = os.environ.get("SYNCH_FUZZ_KEPT")
COUNTED = os.environ.get("SYNCH_FUZZ_COUNTED")
COUNTS: Counter = Counter()
# Seconds after which a case hangs: the process ends then, and shows where it is.
LONGEST = 60
# Cases that take a thousandth of a second or so are tried that much more often.
_OFTEN = 5
_settings = hypothesis.settings(
    max_examples=CASES,
    deadline=None,
    derandomize=KEPT is None,
    database=KEPT and hypothesis.database.DirectoryBasedExampleDatabase(KEPT),
    suppress_health_check=list(hypothesis.HealthCheck),
)
_often = hypothesis.settings(_settings, max_examples=CASES if KEPT is None else _OFTEN * CASES)
# The case that runs, for those that end the process.
_case = Path(KEPT, "case.txt") if KEPT else None
_hangs = Path(KEPT, "hang.txt").open("w") if KEPT else sys.__stderr__


def tried(*strategies, often=False):
    """Try a test with cases of these strategies; one that hangs ends the process."""

    def decorate(test):
        @wraps(test)
        def timed(**case):
            if _case is not None:
                _case.write_text(f"{test.__name__} {case!r}\n", errors="backslashreplace")
            faulthandler.dump_traceback_later(LONGEST, exit=True, file=_hangs)
            try:
                test(**case)
            finally:
                faulthandler.cancel_dump_traceback_later()
                if COUNTED:
                    Path(COUNTED).write_text(json.dumps(COUNTS))

        return (_often if often else _settings)(hypothesis.given(*strategies)(timed))

    return decorate


def mostly(usual, odd):
    """Values that can be taken, and now and then others."""
    return st.integers(0, 15).flatmap(lambda number: odd if number == 15 else usual)


def solved_or_refused(kind, work):
    """The result of some work on a case of some kind, or None where it has said in one line why not, and left the scene
    as it was."""
    bpy.context.view_layer.update()
    before = snapshot()
    found = read_or_refused(kind, work)
    assert found is not None or snapshot() == before
    return found


def read_or_refused(kind, work):
    """The same of work that need not leave the scene as it was."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            found = work()
        except SynchError as error:
            check_line(str(error))
            COUNTS[f"{kind} refused"] += 1
            return None
    has_warnings = isinstance(found, dict) and found["warnings"]
    COUNTS[f"{kind} solved with warnings" if has_warnings else f"{kind} solved"] += 1
    return found


def check_line(text):
    """Fail unless a text is one line that every stream takes."""
    assert text.strip() and len(text.splitlines()) == 1, text
    assert text.encode() and text.isprintable(), text


@contextlib.contextmanager
def captured():
    """Collect what Python and Blender write to stderr inside; yields a list that gets it at the end."""
    told: list[str] = []
    kept = os.dup(2)
    try:
        with tempfile.TemporaryFile() as file:
            os.dup2(file.fileno(), 2)
            with contextlib.redirect_stderr(io.StringIO()) as text:
                yield told
            sys.__stderr__.flush()
            file.seek(0)
            told.append(file.read().decode(errors="replace") + text.getvalue())
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def command_line(kind, *arguments):
    """Run a command line quietly: its status; one that is not 0 has told in one line why."""
    quiet = [] if arguments[0] == "info" else ["--quiet"]
    with captured() as told, contextlib.redirect_stdout(io.StringIO()):
        status = main([*arguments, *quiet])
    (text,) = told
    COUNTS[f"{kind} {'refused' if status else 'done'}"] += 1
    if status:
        check_line(text.rstrip("\n"))
    else:
        assert "Traceback" not in text, text
    return status


def empty_scene():
    bpy.ops.wm.read_homefile(use_empty=True)
