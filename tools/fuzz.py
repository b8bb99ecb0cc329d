# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Try meshes, settings, files and faults for some minutes: `python tools/fuzz.py MINUTES [SEED]`.

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


def main(minutes, seed):
    begin, counts, kept = time.monotonic(), Counter(), ROOT / "out" / "fuzz"
    kept.mkdir(parents=True, exist_ok=True)
    counted = kept / "counts.json"
    settings = {"SYNCH_FUZZ_CASES": str(CASES), "SYNCH_FUZZ_KEPT": str(kept), "SYNCH_FUZZ_COUNTED": str(counted)}
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        *map(str, sorted((ROOT / "tests" / "addon").glob("test_fuzz*.py"))),
    ]
    while time.monotonic() < begin + 60 * minutes:
        print(f"seed {seed}", flush=True)
        counted.unlink(missing_ok=True)
        done = subprocess.run([*command, f"--hypothesis-seed={seed}"], cwd=ROOT, env=os.environ | settings, check=False)
        if counted.exists():
            counts.update(json.loads(counted.read_text()))
        print(f"{counts.total()} cases in {(time.monotonic() - begin) / 60:.0f} minutes", flush=True)
        print(*(f"  {number:6d} {name}" for name, number in sorted(counts.items())), sep="\n", flush=True)
        if done.returncode:
            return done.returncode
        seed += 1
    return 0


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0))
