# SPDX-License-Identifier: GPL-3.0-or-later
"""What a solve takes of memory, seen from a thread beside it in a process of its own."""

import subprocess
import sys
import threading
import time
from pathlib import Path

import synch_fields
from synch_fields.core.memory import used_bytes


def bytes_taken(work):
    """What a function returns, and the most bytes that were taken meanwhile beyond those before."""
    before = used_bytes()
    peak = before

    def look():
        nonlocal peak
        while True:
            peak = max(peak, used_bytes())
            time.sleep(0.002)

    threading.Thread(target=look, daemon=True).start()
    return work(), peak - before


def numbers_of_child(code, *arguments):
    """The numbers that Python code prints in a process of its own."""
    root = str(Path(synch_fields.__path__[0]).absolute().parent)
    command = [sys.executable, "-c", code, *arguments]
    # One thread of BLAS, as in a solve: others would wait for it, and take the time of what runs beside.
    variables = {"PYTHONPATH": root, "OPENBLAS_NUM_THREADS": "1"}
    found = subprocess.run(command, capture_output=True, text=True, env=variables, check=True)
    return [float(word) for word in found.stdout.split()]
