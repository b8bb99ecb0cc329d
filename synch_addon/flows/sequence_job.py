# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of a sequence: each frame solved from the one before, one object a frame, seen at its frame alone."""

import time
from dataclasses import asdict

import bpy

from ...core.errors import SettingError, name_elements
from ...core.fields.clebsch import circulations, clebsch_map, quantum_for, spherical_map
from ...core.fields.clebsch_frames import following_map, following_sphere
from ...core.monitor import Monitor
from ..blender.transaction import whole_or_nothing
from ..jobs.jobs import portion
from ..jobs.report import peak_memory, versions
from .frames import common_grid, flow_frames
from .objects import make_filaments, make_tubes, missing, seen, showing
from .report import vorticity_share
from .sources import check_grid, check_resolution

# Shares of the work: finding the grid of all frames, and the quantum.
_GRID, _QUANTUM = 0.03, 0.07


class SequenceJob:
    """A run over frames, in three steps as :class:`ClebschJob`."""

    def __init__(self, source, settings):
        self._start = time.perf_counter()
        self.settings = settings
        check_resolution(settings.resolution)
        if settings.method != "sdp":
            raise SettingError("a frame starts from the relaxation of the one before: use the method sdp")
        self._files, self._name = flow_frames(source, *settings.frames, settings.attribute)

    def solve(self, callback=None):
        """Solve all frames, the circulation of a filament being the same in all.

        Raises
        ------
        Cancelled
            when the callback returns False
        SettingError
            with one line that says what is wrong with a file
        """
        settings, files = self.settings, self._files
        monitor = Monitor(callback)
        count = len(files)

        def reading(part, share):
            return lambda number: monitor.at(f"reading frame {files[number].frame}", part + share * number / count)

        grid = monitor.during(lambda: common_grid(files, settings.resolution, reading(0.0, _GRID)))
        check_grid(grid, files[0].path)
        quantum = settings.quantum
        if quantum is None:
            quantum = monitor.during(lambda: self._quantum(grid, reading(_GRID, _QUANTUM)))
        self._frames, self._warnings, found, sphere = [], {}, None, None
        begin = _GRID + _QUANTUM
        for number, file in enumerate(files):
            start, share = begin + (1 - begin) * number / count, (1 - begin) / count
            progress = _named(portion(callback, start, share), f"frame {file.frame}")
            flow = file.source()
            integrals = monitor.during(lambda flow=flow: flow.integrals(grid))
            of_map, of_sphere = portion(progress, 0.0, 0.8), portion(progress, 0.8, 0.15)
            if found is None:
                found = clebsch_map(grid, integrals, quantum, settings.options, of_map)
                sphere = spherical_map(found, of_sphere)
            else:
                found = following_map(found, integrals, settings.options, of_map)
                sphere = following_sphere(sphere, found, of_sphere)
            mapped = seen(found, sphere, settings.point)
            shown = monitor.during(lambda mapped=mapped, sphere=sphere: showing(mapped, sphere, settings))
            self._frames.append((file.frame, shown, _facts(file, mapped, shown)))
            for line in (*flow.warnings, *missing(shown)):
                self._warnings.setdefault(line, []).append(file.frame)
        self._grid, self._quantum_of_one = grid, quantum

    def _quantum(self, grid, step):
        """That of the frame with most vorticity."""
        largest = 0.0
        for number, file in enumerate(self._files):
            step(number)
            integrals = file.source().integrals(grid)
            if abs(circulations(grid, integrals)).max() > 0:
                largest = max(largest, quantum_for(grid, integrals, self.settings.count))
        if largest == 0:
            raise SettingError("no frame has vorticity: there are no vortices to show")
        return largest

    def write(self):
        """Make a collection with an object for each frame, and for both two; returns the report."""
        settings = self.settings
        with whole_or_nothing():
            collection = bpy.data.collections.new(f"{self._name} Vortices")
            for frame, shown, _ in self._frames:
                for wanted, make, kind in (
                    (shown.tubes, make_tubes, "Tubes"),
                    (shown.lines, make_filaments, "Filaments"),
                ):
                    if wanted is not None:
                        made = make(f"{self._name} {kind} {frame:04d}", shown)
                        collection.objects.link(made)
                        _show_at(made, frame)
        bpy.context.scene.collection.children.link(collection)
        return {
            "status": "solved",
            "command": "clebsch",
            "source": self._name,
            "object": collection.name,
            "nodes": self._grid.node_count,
            "edges": len(self._grid.edges),
            "shape": list(self._grid.shape),
            "quantum": self._quantum_of_one,
            "frames": [facts for _, _, facts in self._frames],
            "times": {"total": time.perf_counter() - self._start},
            "peak_memory_mb": peak_memory(),
            "settings": asdict(settings),
            "warnings": [f"{name_elements('frame', frames)}: {line}" for line, frames in self._warnings.items()],
            "versions": versions(),
        }


def _facts(file, found, shown):
    solution = found.solution
    return {
        "frame": file.frame,
        "file": file.path.name,
        "energy": found.energy,
        "lower_bound": solution.lower_bound,
        "certificate": solution.certificate,
        "status": solution.status.value,
        "products": solution.products,
        "filaments": None if shown.lines is None else len(shown.lines),
        "length": None if shown.lines is None else sum(line.length for line in shown.lines),
        "tubes": None if shown.tubes is None else shown.tubes.pieces,
        "vorticity_share": vorticity_share(found, found.vorticity),
        "seconds": sum(solution.times.values()),
    }


def _named(callback, name):
    if callback is None:
        return None
    return lambda stage, fraction: callback(f"{name}, {stage}", fraction)


def _show_at(obj, frame):
    """Keys that show an object at one frame alone, in views and renders."""
    for name in ("hide_viewport", "hide_render"):
        for when, hidden in ((frame - 1, True), (frame, False), (frame + 1, True)):
            setattr(obj, name, hidden)
            obj.keyframe_insert(name, frame=when)
        setattr(obj, name, bpy.context.scene.frame_current != frame)
