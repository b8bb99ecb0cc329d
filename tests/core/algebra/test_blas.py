# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""BLAS has one thread inside of a solve, whichever thread solves, and afterwards as many as before."""

import os
import subprocess
import sys
import textwrap
import threading
from contextlib import contextmanager, nullcontext

import pytest

from synch_fields.core.algebra import blas

# Limits are those of a process: each case has one of its own, in which BLAS has two threads.
SKIP = 77
SCRIPT = """
import os, sys, threading
import numpy, scipy.linalg
from threadpoolctl import threadpool_info
from synch_fields.core.algebra.blas import one_blas_thread

def counts():
    return [pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"]

def inside():
    with one_blas_thread():
        return counts()

def elsewhere(work):
    found = []
    thread = threading.Thread(target=lambda: found.append(work()))
    thread.start()
    thread.join()
    return found[0]

# Another thread stays inside until what this returns is called.
def stay_elsewhere():
    begun, end = threading.Event(), threading.Event()
    def stay():
        with one_blas_thread():
            begun.set()
            end.wait()
    thread = threading.Thread(target=stay)
    thread.start()
    begun.wait()
    def leave():
        end.set()
        thread.join()
    return leave

before = counts()
if set(before) != {2}:
    sys.exit(SKIP)
one = [1] * len(before)
""".replace("SKIP", str(SKIP))
CASES = {
    "by turns": """
        for _ in range(2):
            assert inside() == one and counts() == before
            assert elsewhere(inside) == one and counts() == before
    """,
    "inside of itself": """
        with one_blas_thread():
            assert inside() == one and counts() == one
    """,
    "beside another thread that begins first and ends first": """
        leave = stay_elsewhere()
        with one_blas_thread():
            leave()
            assert counts() == one
    """,
    "in a forked process": """
        if hasattr(os, "fork"):
            leave = stay_elsewhere()
            child = os.fork()
            if child == 0:
                os._exit(inside() != one)
            leave()
            assert os.waitpid(child, 0)[1] == 0
    """,
    "a keeper that does not come": """
        start = threading.Thread.start
        def fail(thread):
            raise RuntimeError("no more threads")
        threading.Thread.start = fail
        try:
            inside()
        except RuntimeError:
            pass
        threading.Thread.start = start
        assert inside() == one
    """,
    "an error": """
        try:
            with one_blas_thread():
                raise KeyError
        except KeyError:
            pass
        assert counts() == before and elsewhere(inside) == one
    """,
}


@pytest.mark.parametrize("case", CASES)
def test_blas_has_one_thread_inside_and_all_afterwards(case):
    pytest.importorskip("threadpoolctl")
    script = SCRIPT + textwrap.dedent(CASES[case]) + "\nassert counts() == before\n"
    limits = {f"{library}_NUM_THREADS": "2" for library in ("OMP", "OPENBLAS", "MKL", "BLIS", "VECLIB")}
    environment = os.environ | limits | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True)
    if done.returncode == SKIP:
        pytest.skip("BLAS has one thread anyway, or none that threadpoolctl knows")
    assert done.returncode == 0, done.stderr


def test_a_pool_of_the_calling_thread_is_limited_once_as_well(monkeypatch):
    """As in builds with OpenMP; and the pool of all by a thread of its own."""
    asked = []

    @contextmanager
    def limit():
        asked.append(threading.current_thread())
        yield

    monkeypatch.setattr(blas, "_limit", limit)
    with blas.one_blas_thread(), blas.one_blas_thread():
        assert len(asked) == 2 and asked[1] is threading.current_thread() is not asked[0]
        assert asked[0].is_alive()
    assert not asked[0].is_alive()


def test_libraries_are_looked_for_again_when_modules_have_been_loaded(monkeypatch):
    looks = []

    class Controller:
        def __init__(self):
            looks.append(len(sys.modules))

        def limit(self, limits, user_api):
            assert (limits, user_api) == (1, "blas")
            return nullcontext()

    monkeypatch.setattr(blas, "ThreadpoolController", Controller)
    blas._controller.cache_clear()
    try:
        for _ in range(2):
            with blas.one_blas_thread():
                pass
        monkeypatch.setitem(sys.modules, "loaded_since", sys)
        with blas.one_blas_thread():
            pass
    finally:
        blas._controller.cache_clear()
    assert len(looks) == 2
