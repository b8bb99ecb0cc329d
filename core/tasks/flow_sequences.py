# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of the frames of a sequence of flows, each solved from the frame before."""

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..errors import SettingError, name_elements
from ..fields.clebsch import ClebschMap, SphericalMap, circulations, clebsch_map, quantum_for, spherical_map
from ..fields.clebsch_frames import solve_next_map, solve_next_sphere
from ..fields.quantum import find_quantum
from ..files.flow_grids import SampledFlow
from ..files.flows import ArrayFile
from ..files.regular_flows import GridFlow
from ..files.volumes import VolumeFile
from ..geometry.grid import Grid, box_grid
from ..monitor import Callback, Monitor, expect, portion
from ..settings.flow import FlowSettings
from ..solve import Options
from .flow_costs import solve_seconds
from .flows import LEAST_SHARE, FlowResult, Shown, about_noise, check_grid, extract_vortices

# Bytes of the maps of a frame for each node, and the most for the maps of all frames.
_KEPT, _MOST_KEPT = 200, 2**30
# Shares of the work: finding the grid of all frames, and the quantum.
_GRID, _QUANTUM = 0.03, 0.07


@dataclass(frozen=True)
class FrameFile:
    """A frame of the scene, and what its flow is read from, each time anew so that memory holds one frame."""

    frame: int
    source: ArrayFile | VolumeFile


@dataclass(frozen=True)
class FlowFrame:
    """What a frame shows, the facts of its solve for the report, and its result, None where frames are too many."""

    frame: int
    shown: Shown
    facts: dict[str, Any]
    result: FlowResult | None


@dataclass(frozen=True)
class SequenceResult:
    """A solved sequence.

    Attributes
    ----------
    grid, quantum : of all frames: the grid, and the circulation of one filament
    warnings : lines that the user should read, with their frames
    seconds : empty; those of the frames are in their facts
    """

    grid: Grid
    quantum: float
    frames: tuple[FlowFrame, ...]
    warnings: tuple[str, ...]
    seconds: dict[str, float] = dataclasses.field(default_factory=dict)


@dataclass(frozen=True)
class SequenceRequest:
    """Vortices of each frame of a sequence; SettingError for a method but "sdp"."""

    files: tuple[FrameFile, ...]
    settings: FlowSettings

    def __post_init__(self) -> None:
        if self.settings.method != "sdp":
            raise SettingError("a frame starts from the relaxation of the one before: use the method sdp")

    def solve(self, progress: Callback | None = None) -> SequenceResult:
        """Solve all frames with the same circulation of a filament; errors as :meth:`FlowRequest.solve`."""
        monitor, count = Monitor(progress), len(self.files)

        def reading(part: float, share: float) -> Callable[[int], None]:
            return lambda number: monitor.at(f"reading frame {self.files[number].frame}", part + share * number / count)

        grid = monitor.during(lambda: self._find_grid(reading(0.0, _GRID)))
        check_grid(grid, self.files[0].source.path)
        expect(progress, solve_seconds(grid.node_count, self.settings, count))
        quantum = self.settings.quantum
        if quantum is None:
            quantum = monitor.during(lambda: self._find_quantum(grid, reading(_GRID, _QUANTUM)))
        frames: list[FlowFrame] = []
        warned: dict[str, list[int]] = {}
        found = sphere = None
        begin = _GRID + _QUANTUM
        for number, file in enumerate(self.files):
            part = portion(progress, begin + (1 - begin) * number / count, (1 - begin) / count)
            found, sphere, warnings = self._solve_frame(
                file, grid, quantum, found, sphere, _name_frames(part, file.frame)
            )
            result = FlowResult(found, sphere, found, None).seen_from_point(self.settings)
            monitor.at(f"frame {file.frame}, vortices", begin + (1 - begin) * (number + 0.95) / count)
            shown = monitor.during(partial(extract_vortices, result.seen, sphere, self.settings))
            is_kept = (number + 1) * grid.node_count * _KEPT <= _MOST_KEPT
            kept = replace(result.lean, shown=shown) if is_kept else None
            frames.append(FlowFrame(file.frame, shown, _facts(file, result.seen, shown), kept))
            if shown.lines and (shown.share or 0) < LEAST_SHARE:
                carried = f"the filaments carry less than {LEAST_SHARE:.0%} of the vorticity"
                warnings += (f"{carried}: give a smaller circulation or a finer grid",)
            for line in (*warnings, *shown.missing):
                warned.setdefault(line, []).append(file.frame)
        lines = tuple(f"{name_elements('frame', named)}: {line}" for line, named in warned.items())
        return SequenceResult(grid, quantum, tuple(frames), lines)

    def _solve_frame(
        self,
        file: FrameFile,
        grid: Grid,
        quantum: float,
        found: ClebschMap | None,
        sphere: SphericalMap | None,
        progress: Callback | None,
    ) -> tuple[ClebschMap, SphericalMap, tuple[str, ...]]:
        """The maps of a frame, from those of the frame before if there is one, and warnings of its flow."""
        flow, options = file.source.read(), Options.of(self.settings)
        warnings = (*flow.warnings, *about_noise(flow.noise))
        integrals = Monitor(progress).during(lambda: flow.integrals(grid))
        of_map, of_sphere = portion(progress, 0.0, 0.8), portion(progress, 0.8, 0.15)
        if found is None or sphere is None:
            found = clebsch_map(grid, integrals, quantum, options, of_map)
            return found, spherical_map(found, of_sphere), warnings
        found = solve_next_map(found, integrals, options, of_map)
        return found, solve_next_sphere(sphere, found, of_sphere), warnings

    def _find_grid(self, step: Callable[[int], None]) -> Grid:
        """A grid that holds the flow of every frame; SettingError where files have grids that differ.

        ``step`` is called with the number of each file before it is read.
        """
        low, high, fixed = np.full(3, np.inf), np.full(3, -np.inf), None
        for number, file in enumerate(self.files):
            step(number)
            flow = file.source.read()
            if isinstance(flow, SampledFlow):
                raise SettingError(f"{file.source.path}: frames on a mesh are not read: resample them on one grid")
            if isinstance(flow, GridFlow):
                fixed = fixed or flow.own
                if not _is_same(flow.own, fixed):
                    raise SettingError(
                        f"{file.source.path}: its grid is not that of {self.files[0].source.path.name}: "
                        "all frames need the same"
                    )
            else:
                lowest, highest = flow.box
                low, high = np.minimum(low, lowest), np.maximum(high, highest)
        return fixed or box_grid(low, high, self.settings.resolution)

    def _find_quantum(self, grid: Grid, step: Callable[[int], None]) -> float:
        """The circulation of a filament, from the frame with most vorticity."""
        largest, most = 0.0, None
        for number, file in enumerate(self.files):
            step(number)
            integrals = file.source.read().integrals(grid)
            if abs(circulations(grid, integrals)).max() > 0 and quantum_for(grid, integrals, 1) > largest:
                largest, most = quantum_for(grid, integrals, 1), integrals
        if most is None:
            raise SettingError("no frame has vorticity: there are no vortices to show")
        return find_quantum(grid, most, self.settings.share, self.settings.count, None, self.settings.seed)


def _is_same(grid: Grid, other: Grid) -> bool:
    places = [(one.shape, one.periodic, *one.spacing, *one.origin) for one in (grid, other)]
    return places[0] == places[1] and bool((grid.solid == other.solid).all())


def _name_frames(progress: Callback | None, frame: int) -> Callback | None:
    if progress is None:
        return None
    return lambda stage, fraction: progress(f"frame {frame}, {stage}", fraction)


def _facts(file: FrameFile, found: ClebschMap, shown: Shown) -> dict[str, Any]:
    solution = replace(found.solution, energy=found.energy)
    return {
        "frame": file.frame,
        "file": file.source.path.name,
        "energy": solution.energy,
        "lower_bound": solution.lower_bound,
        "certificate": solution.certificate,
        "status": solution.status.value,
        "products": solution.products,
        "filaments": None if shown.lines is None else len(shown.lines),
        "length": None if shown.lines is None else sum(line.length for line in shown.lines),
        "tubes": None if shown.tubes is None else shown.tubes.pieces,
        "vorticity_share": found.vorticity_share if shown.share is None else shown.share,
        "seconds": sum(solution.times.values()),
    }
