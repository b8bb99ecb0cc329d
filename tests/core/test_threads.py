# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""BLAS has one thread inside of a solve, whichever thread solves, and afterwards as many as before."""

import os
import subprocess
import sys
import textwrap

import pytest

# Limits are those of a process: each case has one of its own, in which BLAS has two threads.
SCRIPT = """
import threading
import numpy, scipy.linalg
from threadpoolctl import threadpool_info
from synch_fields.core.solve.threads import one_blas_thread

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

before = counts()
assert set(before) <= {2}, before
one = [1] * len(before)
"""
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
        begun, end = threading.Event(), threading.Event()
        def other():
            with one_blas_thread():
                begun.set()
                end.wait()
        thread = threading.Thread(target=other)
        thread.start()
        begun.wait()
        with one_blas_thread():
            end.set()
            thread.join()
            assert counts() == one
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


@pytest.mark.skipif(os.cpu_count() == 1, reason="BLAS has one thread anyway")
@pytest.mark.parametrize("case", CASES)
def test_blas_has_one_thread_inside_and_all_afterwards(case):
    pytest.importorskip("threadpoolctl")
    script = SCRIPT + textwrap.dedent(CASES[case]) + "\nassert counts() == before\n"
    limits = {f"{library}_NUM_THREADS": "2" for library in ("OMP", "OPENBLAS", "MKL", "BLIS", "VECLIB")}
    environment = os.environ | limits | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
