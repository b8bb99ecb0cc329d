# SPDX-License-Identifier: GPL-3.0-or-later
"""A quad mesh before it is finished: a pattern whose quads can be counted, corrected, traced and smoothed."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

from ..errors import SettingError
from ..extract.quads.repair.strips import NEAR, may_meet
from ..extract.quads.trace.quad_mesh import QuadMesh
from ..fields import DirectionField
from ..fields.patterns import untangle
from ..monitor import Callback, Monitor, portion
from ..solution import FIRST
from .close_loops import close_loops
from .surface_result import PatternResult, SurfaceResult

if TYPE_CHECKING:
    from .surfaces import SurfaceRequest

# Most corrections of a pattern with dislocations.
CORRECTIONS = 3
# Quads of patterns with fewer may be too large for a mesh, whatever the wanted number.
FEW = 300
# Shares of the work on a pattern after which its loops are closed, and its quads smoothed.
_CLOSING, _SMOOTHING = 0.3, 0.9


@dataclass(frozen=True)
class Draft:
    """A result without quads, and its request; ``is_settled`` if corrections would leave it as it is."""

    request: "SurfaceRequest"
    result: PatternResult
    is_settled: bool = False

    @cached_property
    def face_count(self) -> float:
        """Number of faces; without branching that of quads for which the phases have room, mostly within 1 % of it."""
        pattern = self.result.pattern
        if not self.request.has_only_quads:
            return self.traced_count
        return pattern.one_form.reaching(pattern.edge_phases.changes).quad_count

    def misses(self, wanted: float) -> float:
        """Relative error of the number of faces."""
        return abs(self.face_count / wanted - 1)

    @cached_property
    def traced(self) -> tuple[QuadMesh, dict[str, float]]:
        """The quad mesh before finishing, and the seconds; errors as :func:`sound_quads`."""
        return self.request.trace(self.result.pattern)

    @property
    def traced_count(self) -> int:
        """Number of faces before finishing, with their mirror images."""
        return len(self.traced[0].sizes) * self._images

    @property
    def _images(self) -> int:
        """How often the whole mesh has what is traced: mirrored meshes are made on a part."""
        side = self.request.mirror_side
        return 1 if side is None else 2 ** len(side.units)

    @property
    def finished_count(self) -> float:
        """Number of faces after finishing, known from the traced mesh, mostly within 1 %: triangles go in pairs with
        what is between them, and polygons with 2 k corners become k - 1 quads."""
        if not self.request.has_only_quads:
            return self.face_count
        sizes = self.traced[0].sizes
        return max(1.0, float((sizes[sizes > 3] / 2 - 1).sum()) * self._images)


def may_meet_count(draft: Draft) -> bool:
    """Whether the finished mesh may have about as many faces as wanted, after changes of strips of its quads."""
    wanted, count = draft.request.settings.faces, draft.finished_count
    if not draft.request.has_only_quads or draft.request.closes_tunnels:
        return abs(count / wanted - 1) <= NEAR
    images = draft._images
    return may_meet(draft.traced[0], (wanted - count) / images, wanted / images)


def draw(request: "SurfaceRequest", directions: DirectionField, progress: Callback | None) -> Draft:
    """The draft of the pattern along a field."""
    part = portion(progress, 0.0, _CLOSING if request.settings.loops else 1.0)
    return Draft(request, request.along(directions, part))


def settle(draft: Draft) -> Draft:
    """The draft of a first field, corrected a few times, as long as that leaves fewer dislocations."""
    if draft.is_settled or draft.request.options.method != FIRST or not draft.result.pattern.dislocations:
        return draft
    request, given = draft.request, draft.result.pattern
    pattern, is_settled = given, False
    for _ in range(CORRECTIONS):
        if not pattern.dislocations:
            is_settled = True
            break
        corrected = untangle(pattern, request.options)
        if len(corrected.dislocations) >= len(pattern.dislocations):
            is_settled = True
            break
        pattern = corrected
    if pattern is given:
        return replace(draft, is_settled=is_settled)
    solution = replace(pattern.solution, energy=given.problem.energy(pattern.phases))
    return Draft(request, replace(draft.result, pattern=replace(pattern, solution=solution)), is_settled)


def _close(draft: Draft, progress: Callback | None) -> Draft:
    """The draft with more of its quads in short loops, if that is asked for and lines do not branch."""
    request = draft.request
    if request.settings.loops == 0 or request.settings.branching != 0:
        return draft
    pattern, before = close_loops(request, draft.result.pattern, portion(progress, _CLOSING, _SMOOTHING - _CLOSING))
    return Draft(request, replace(draft.result, pattern=pattern, loops_before=before))


def may_close_tunnels(draft: Draft) -> bool:
    """Whether there are so many quads, and nothing else, that tunnels may be narrower than they are."""
    return draft.request.has_only_quads and draft.face_count >= FEW


def is_sound(draft: Draft) -> bool:
    """Whether the quads before finishing are a mesh of the surface."""
    try:
        return len(draft.traced[0].sizes) > 0
    except SettingError:
        return False


def with_tunnels_closed(draft: Draft) -> Draft:
    """The draft with handles closed that are too narrow for its quads."""
    return replace(draft, request=replace(draft.request, closes_tunnels=True))


def complete(
    draft: Draft, progress: Callback | None = None, later: list[Callable[[], QuadMesh]] | None = None
) -> SurfaceResult:
    """The result of a settled draft: with its loops closed, traced, near its wanted number of faces, and smoothed;
    ``later`` as of :meth:`SurfaceRequest.finish`."""
    return finish(_close(draft, progress), progress, draft.request.settings.faces, later)


def finish(
    draft: Draft,
    progress: Callback | None = None,
    wanted: int = 0,
    later: list[Callable[[], QuadMesh]] | None = None,
) -> SurfaceResult:
    """The result with its quads, and the settings with which they were made; ``wanted`` and ``later`` as of
    :meth:`SurfaceRequest.finish`."""
    Monitor(progress).at("smoothing", _SMOOTHING)
    request = draft.request
    settled = {"spacing": request.spacing, "singularities": request.settings.singularities}
    return replace(draft.result, **request.finish(*draft.traced, wanted, later), settled=settled)
