# SPDX-License-Identifier: GPL-3.0-or-later
"""A pattern on each frame of a moving surface, each frame solved from the previous one."""

from dataclasses import dataclass, replace

import numpy as np

from ..errors import Cancelled, SynchError
from ..fields import Pattern
from ..fields.animation import has_same_triangles
from ..geometry import TriangleMesh
from ..geometry.polygons import Polygons
from ..interpolate import EdgePhases
from ..monitor import Callback, expect, portion
from .surface_result import PatternResult
from .surface_source import FIRST_FRAME, solve_seconds
from .surfaces import SurfaceRequest


@dataclass(frozen=True)
class FramesRequest:
    """Asks for a pattern in several frames.

    Attributes
    ----------
    frames : their numbers
    requests : one for each frame
    hold : how strongly the phases are held near those of the previous frame; 0 for not at all
    """

    frames: tuple[int, ...]
    requests: tuple[SurfaceRequest, ...]
    hold: float

    @property
    def shared(self) -> tuple[TriangleMesh, TriangleMesh]:
        """The meshes of the first frame."""
        return self.requests[0].shared

    def solve(self, progress: Callback | None = None) -> "FramesResult":
        """All frames; errors as :meth:`SurfaceRequest.solve`, with the number of the frame."""
        work, first = len(self.requests) + FIRST_FRAME - 1, self.requests[0]
        mesh = first.given.mesh
        expect(progress, solve_seconds(first.command, first.settings, mesh.vertex_count, len(self.requests)))
        found = whole = self._solve_frame(self.frames[0], first, None, portion(progress, 0.0, FIRST_FRAME / work))
        kept = [_make_frame(self.frames[0], first, found, None, mesh)]
        for place in range(1, len(self.requests)):
            number, request, before = self.frames[place], fresh(self.requests[place]), found
            part = portion(progress, (FIRST_FRAME + place - 1) / work, 1 / work)
            found = self._solve_frame(number, request, before, part)
            kept.append(_make_frame(number, request, found, before, mesh))
        return FramesResult(tuple(kept), whole)

    def _solve_frame(
        self, number: int, request: SurfaceRequest, before: PatternResult | None, progress: Callback | None
    ) -> PatternResult:
        """Directions and pattern of a frame, from those of the previous frame if that has the same triangles."""
        ask = None if progress is None else _name_frames(progress, number)
        if before is not None and not has_same_triangles(before.field.mesh, request.given.mesh):  # other edges were cut
            before = None
        of_field, of_pattern = portion(ask, 0.0, 0.4), portion(ask, 0.4, 0.6)
        try:
            if before is None:
                return request.along(request.directed(of_field), of_pattern)
            directions = request.directed(of_field, before.field)
            return request.next_along(directions, before.pattern.phases, of_pattern, self.hold)
        except SynchError as error:
            raise in_frame(number, error) from None


@dataclass(frozen=True)
class Frame:
    """The part of a solved frame that is kept.

    Attributes
    ----------
    number : of the frame
    edge_phases : on the first frame's mesh, whose vertex coordinates are not used
    polygons : that are drawn
    directions : (n, 3) float32 unit vectors in the object's space
    figures : for the report
    """

    number: int
    edge_phases: EdgePhases
    polygons: Polygons
    directions: np.ndarray
    figures: dict[str, float | None]


@dataclass(frozen=True)
class FramesResult:
    """All frames, and the whole result of the first one."""

    frames: tuple[Frame, ...]
    first: PatternResult


def in_frame(number: int, error: SynchError) -> SynchError:
    """The error with the frame's number in its message."""
    return error if isinstance(error, Cancelled) else SynchError(f"frame {number}: {error}", error.vertices)


def _name_frames(callback: Callback, number: int) -> Callback:
    """A callback whose stages begin with the frame's number."""
    return lambda stage, fraction: callback(f"frame {number}: {stage}", fraction)


def fresh(request: SurfaceRequest) -> SurfaceRequest:
    """The request on new meshes, so that values cached on the given ones can be freed."""
    given = request.given
    uncut = TriangleMesh(given.uncut.vertices, given.uncut.triangles)
    mesh = uncut if given.mesh is given.uncut else TriangleMesh(given.mesh.vertices, given.mesh.triangles)
    return request.on_mesh(replace(given, mesh=mesh, uncut=uncut))


def _make_frame(
    number: int, request: SurfaceRequest, found: PatternResult, before: PatternResult | None, shared: TriangleMesh
) -> Frame:
    """The :class:`Frame` of a result; its phases refer to the first frame's mesh if that has the same triangles."""
    phases = found.pattern.edge_phases
    if has_same_triangles(shared, phases.mesh):
        phases = replace(phases, mesh=shared)
    figures = {
        "frame": number,
        "energy": found.pattern.energy,
        "direction_energy": found.field.energy,
        "disclinations": len(found.field.disclinations),
        "dislocations": len(found.pattern.dislocations),
        "change": None if before is None else _change(before.pattern, found.pattern),
    }
    directions = request.given.to_object(found.field.vectors).astype(np.float32)
    return Frame(number, phases, request.given.polygons, directions, figures)


def _change(before: Pattern, pattern: Pattern) -> float | None:
    """Mean difference of the visible pattern at the vertices; None after a change of their number."""
    if len(before.vertex_phases) != len(pattern.vertex_phases):
        return None
    seen = [np.cos(shown.vertex_phases).prod(axis=1) for shown in (before, pattern)]
    return float(np.abs(seen[1] - seen[0]).mean())
