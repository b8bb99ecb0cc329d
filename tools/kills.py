# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kill commands and batches at random moments: `python tools/kills.py COUNT [SEED]`, on Linux.

After each kill every output is as it was or complete, and no process is left. Every few kills a run that ends by itself
follows: it leaves all outputs and nothing else, neither beside them nor in the folder for temporary files.
"""

import json
import os
import random
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from math import cos, pi, sin
from pathlib import Path

ROOT = Path(__file__).parents[1]
# Kills after which a run ends by itself, seconds in which processes end, and a variable that tells whose they are.
KILLS, LONGEST, MARK = 5, 60, "SYNCH_KILLED_IN"
COMMANDS = {
    "stripes": "stripes ball.obj --spacing 0.5 --method spectral --output o.blend --report r.json "
    "--export-field f.rosy --quiet",
    "quad_mesh": "quad_mesh ball.obj --spacing 0.4 --export-mesh q.obj --report r.json --quiet",
    "layers": "layers cube.obj --spacing 0.6 --size 0.3 --export-layers part.stl --export-paths p.csv "
    "--export-volume v.vdb --report r.json --quiet",
    "batch": "batch rows.jsonl --jobs 2 --folder rows --quiet",
}
ROWS = [
    {"command": "stripes", "input": "ball.obj", "spacing": 0.5, "method": "spectral", "report": "a.json"},
    {"command": "quad_mesh", "input": "ball.obj", "spacing": 0.5, "export_mesh": "a.obj", "report": "b.json"},
    {"command": "directions", "input": "ball.obj", "export_field": "a.rosy", "report": "c.json"},
]


def main(count, seed):
    chance, counts = random.Random(seed), Counter()
    with tempfile.TemporaryDirectory() as place:
        places = {name: Place(Path(place, name), line) for name, line in COMMANDS.items()}
        for name, each in places.items():
            if faults := each.finish():
                sys.exit(f"{name} does not run undisturbed: {faults[0]}")
        for number in range(count):
            name = chance.choice(sorted(places))
            sent = chance.choice([signal.SIGKILL, signal.SIGTERM])
            faults = places[name].kill(sent, chance.random())
            counts[f"{name} {sent.name}"] += 1
            if places[name].kills % KILLS == 0:
                faults += places[name].finish()
            for fault in faults:
                print(f"seed {seed}, kill {number}, {name} {sent.name}: {fault}", flush=True)
            counts["faults"] += len(faults)
            if number % KILLS == KILLS - 1:
                print(f"{number + 1} kills, {counts['faults']} faults", flush=True)
        for name, each in places.items():
            for fault in each.finish():
                print(f"seed {seed}, at the end, {name}: {fault}", flush=True)
                counts["faults"] += 1
    print(*(f"{number:6d} {name}" for name, number in sorted(counts.items())), sep="\n")
    return 1 if counts["faults"] else 0


class Place:
    """A folder where one command runs again and again."""

    def __init__(self, folder, line):
        self.folder, self.kills, self._line = folder, 0, shlex.split(line)
        self._temporary, self._seconds, self._finished = folder / "temporary", 1.0, {}
        self._temporary.mkdir(parents=True)
        (folder / "ball.obj").write_text(ball(16))
        (folder / "cube.obj").write_text(CUBE)
        (folder / "rows.jsonl").write_text("".join(json.dumps(row) + "\n" for row in ROWS))

    def finish(self):
        """Let the command end by itself; what is wrong then."""
        begin = time.monotonic()
        for record in self.folder.glob("rows/done/*/*.json"):  # so that a batch has something to do
            record.unlink()
        process = self._started()
        status, faults = self._ended(process), []
        self._seconds = time.monotonic() - begin
        if status:
            faults.append(f"the run that follows ends with {status}: {self._errors()}")
        left = [path for path in self.folder.rglob(".synch*") if self._temporary not in path.parents]
        # An empty folder is of a process that was killed before Blender's own import was over: nothing tells whose.
        left += [path for path in self._temporary.iterdir() if not path.is_dir() or any(path.iterdir())]
        faults += [f"left behind: {path}" for path in left]
        found = self._outputs()
        if self._finished:
            faults += [f"lost: {path}" for path in self._finished.keys() - found.keys()]
        self._finished = self._finished or found
        return faults + self._torn({})

    def kill(self, sent, share):
        """Kill the command after a share of the time that it takes; what is wrong then."""
        self.kills += 1
        before = self._outputs()
        for record in self.folder.glob("rows/done/*/*.json"):
            record.unlink()
        process = self._started()
        try:
            process.wait(share * self._seconds)
        except subprocess.TimeoutExpired:
            process.send_signal(sent)
        self._ended(process)
        faults = [f"process {number} is left" for number in self._processes()]
        if "Traceback" in self._errors():
            faults.append(self._errors())
        lost = [path for path in before.keys() - self._outputs().keys() if "done" not in path.parts]
        faults += [f"lost: {path}" for path in lost]
        return faults + self._torn(before)

    def _started(self):
        variables = {"PYTHONPATH": str(ROOT / "out" / "tree"), "TMPDIR": str(self._temporary), MARK: str(self.folder)}
        with (self.folder / "errors.log").open("w") as errors:
            return subprocess.Popen(
                [sys.executable, "-m", "synch_fields", *self._line],
                cwd=self.folder,
                env=os.environ | variables,
                stdout=subprocess.DEVNULL,
                stderr=errors,
            )

    def _ended(self, process):
        """The status of a process, once it and its children have ended or have been given time to."""
        try:
            status = process.wait(LONGEST)
        except subprocess.TimeoutExpired:
            process.kill()
            return f"a hang of {LONGEST} s"
        end = time.monotonic() + LONGEST / 2
        while self._processes() and time.monotonic() < end:
            time.sleep(0.2)
        return status

    def _processes(self):
        """Numbers of the processes that the command has started and that run."""
        found, mark = [], f"{MARK}={self.folder}\0".encode()
        for entry in Path("/proc").iterdir():
            try:
                if entry.name.isdigit() and mark in (entry / "environ").read_bytes():
                    found.append(int(entry.name))
            except OSError:  # it has ended
                continue
        return found

    def _errors(self):
        return (self.folder / "errors.log").read_text(errors="replace").strip()

    def _outputs(self):
        """Contents of all files that the command has written, but its temporary ones."""
        given = ("ball.obj", "cube.obj", "rows.jsonl", "errors.log")
        paths = [path for path in self.folder.rglob("*") if path.is_file() and self._temporary not in path.parents]
        return {path: path.read_bytes() for path in paths if path.name not in given and not path.name.startswith(".")}

    def _torn(self, before):
        """Files that are neither as they were nor complete."""
        return [
            f"torn: {path}"
            for path, content in self._outputs().items()
            if content != before.get(path) and not self._is_complete(path, content)
        ]

    def _is_complete(self, path, content):
        """Whether a file is what a run that ends by itself writes; times and sizes in reports differ."""
        match path.suffix:
            case ".json":
                try:
                    return bool(json.loads(content))
                except ValueError:
                    return False
            case ".blend":
                is_packed = content.startswith(b"\x28\xb5\x2f\xfd")
                return is_packed or (content.startswith(b"BLENDER") and b"ENDB" in content[-64:])
            case ".csv" | ".html" | ".vdb" if "rows" in path.parts or path.suffix == ".vdb":
                return len(content) > 100
        return not self._finished or content == self._finished.get(path)


def ball(count):
    """A sphere of triangles as the text of an .obj file."""
    rows = ["v 0 0 1", "v 0 0 -1"]
    for ring in range(1, count // 2):
        tilt = 2 * pi * ring / count
        for place in range(count):
            turn = 2 * pi * place / count
            rows.append(f"v {sin(tilt) * cos(turn):.9g} {sin(tilt) * sin(turn):.9g} {cos(tilt):.9g}")
    rings = count // 2 - 1
    for place in range(count):
        after = (place + 1) % count
        rows.append(f"f 1 {3 + place} {3 + after}")
        rows.append(f"f 2 {3 + (rings - 1) * count + after} {3 + (rings - 1) * count + place}")
        for ring in range(rings - 1):
            first = 3 + ring * count
            rows.append(f"f {first + place} {first + count + place} {first + count + after}")
            rows.append(f"f {first + place} {first + count + after} {first + after}")
    return "\n".join(rows) + "\n"


CUBE = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
CUBE += "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"

if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0))
