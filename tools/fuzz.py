# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Try meshes, settings, files and faults for some minutes: `python tools/fuzz.py MINUTES [SEED]`.

Each round has a seed of its own, which is printed; what fails is made as small as it can be, shown, and kept in
out/fuzz, from where the next run tries it first. The exit status is that of the first round that fails.
"""

import os
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
# Cases of each test in a round.
CASES = 200


def main(minutes, seed):
    end = time.monotonic() + 60 * minutes
    settings = {"SYNCH_FUZZ_CASES": str(CASES), "SYNCH_FUZZ_KEPT": str(ROOT / "out" / "fuzz")}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(ROOT / "tests/addon/test_fuzz.py")]
    while time.monotonic() < end:
        print(f"seed {seed}", flush=True)
        done = subprocess.run([*command, f"--hypothesis-seed={seed}"], cwd=ROOT, env=os.environ | settings, check=False)
        if done.returncode:
            return done.returncode
        seed += 1
    return 0


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0))
