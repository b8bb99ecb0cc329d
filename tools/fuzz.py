# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Try meshes, settings, texts, files and faults at random for some minutes: `python tools/fuzz.py MINUTES [SEED]`.

Each round has a seed of its own, which is printed with the number of cases so far and what came out of them; what
fails is made as small as it can be, shown, and kept in out/fuzz, from where the next run tries it first. The exit
status is that of the first round that fails.
"""

import json
import os
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[1]
# Cases of each test in a round.
CASES = 200
# Files that a round leaves: the number of cases of each kind, the case that ran last, and where it did not end.
COUNTED, SHOWN = "counts.json", ("case.txt", "hang.txt")


def main(minutes, seed):
    begin, counts, kept, status = time.monotonic(), Counter(), ROOT / "out" / "fuzz", 0
    kept.mkdir(parents=True, exist_ok=True)
    settings = {"SYNCH_FUZZ_CASES": str(CASES), "SYNCH_FUZZ_KEPT": str(kept), "SYNCH_FUZZ_COUNTED": str(kept / COUNTED)}
    while not status and time.monotonic() < begin + 60 * minutes:
        for tests in sorted(
            (ROOT / "tests" / "addon").glob("test_fuzz*.py")
        ):  # a process that ends loses its own cases
            print(f"seed {seed}, {tests.name}", flush=True)
            status = max(status, abs(_tried(tests, seed, settings, kept, counts)))
            print(f"{counts.total()} cases in {(time.monotonic() - begin) / 60:.0f} minutes", flush=True)
        print(*(f"  {number:6d} {name}" for name, number in sorted(counts.items())), sep="\n", flush=True)
        seed += 1
    return status


def _tried(tests, seed, settings, kept, counts):
    """The exit status of the tests of a file with a seed; their cases are added to the counts."""
    for name in (COUNTED, *SHOWN):
        (kept / name).unlink(missing_ok=True)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--tb=short", "--show-capture=no"]
    command += [str(tests), f"--hypothesis-seed={seed}"]
    status = subprocess.run(command, cwd=ROOT, env=os.environ | settings, check=False).returncode
    if (kept / COUNTED).exists():
        counts.update(json.loads((kept / COUNTED).read_text()))
    if status not in (0, 1) or (kept / "hang.txt").read_text():  # the process has ended in the middle of a case
        print(*((kept / name).read_text() for name in SHOWN if (kept / name).exists()), sep="\n", flush=True)
    return status


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0))
