# SPDX-License-Identifier: GPL-3.0-or-later
"""Updates the shown pattern after a change of its settings, fast enough to follow a slider, and settles it after that.

Descent from one step to the next keeps the lines of before, so their energy grows: to 1.3 to 1.5 times that of a whole
solve after eight steps of 1 %. A first field takes a tenth of the time of a whole solve, and a few percent more energy.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..fields import DirectionField
from ..geometry import TriangleMesh
from ..monitor import Callback, portion
from ..solution import FIRST
from ..solve.warm_start import Follower
from .surface_result import PatternResult
from .surfaces import SurfaceRequest

# How a pattern settles when no setting changes any more: another one at first, then a whole solve near that.
ANEW, NEAR = "anew", "near"


@dataclass(frozen=True)
class LiveRequest:
    """Asks for the pattern that descent reaches from the one that is shown.

    Attributes
    ----------
    asked : stripes or quads, on the mesh of the shown pattern
    field : the shown directions, without problem and solution
    phases : (k n,) complex phases that are shown
    turns_only : whether only the angle of the directions has changed
    followers : of the directions and of the pattern, the same in all requests of a session
    settles : "" for a step, or :data:`ANEW` or :data:`NEAR`
    """

    asked: SurfaceRequest
    field: DirectionField
    phases: np.ndarray
    turns_only: bool
    followers: tuple[Follower, Follower]
    settles: str = ""

    @property
    def shared(self) -> tuple[TriangleMesh, TriangleMesh]:
        return self.asked.shared

    @property
    def kept(self) -> tuple[TriangleMesh | Follower, ...]:
        """Objects that the next request will probably contain too (:mod:`.`)."""
        return *self.shared, *self.followers

    def solve(self, progress: Callback | None = None) -> PatternResult:
        """The updated pattern; errors as :meth:`SurfaceRequest.solve`."""
        return (self._settled(progress) if self.settles else self._next(progress)).with_figures()

    def _next(self, progress: Callback | None) -> PatternResult:
        """The pattern of a step: descent from what is shown, for directions and pattern."""
        of_field, of_pattern = self.followers
        if self.turns_only:
            directions = self.field.turned(self.asked.turn - self.field.turn)
        else:
            directions = self.asked.directed(portion(progress, 0.0, 0.4), self.field, of_field)
        return self.asked.next_along(directions, self.phases, portion(progress, 0.4, 0.6), follower=of_pattern)

    def _settled(self, progress: Callback | None) -> PatternResult:
        """The pattern of a search: ANEW along the shown directions, NEAR from the shown directions and phases."""
        asked, options = self.asked, self.asked.options
        if self.settles == ANEW:
            if options.method == "sdp":
                asked = replace(asked, options=replace(options, method=FIRST))
            return asked.along(self.field, progress)
        asked = replace(asked, start=(self.field.angles - self.field.turn, self.phases))
        directions = self.field if self.turns_only else asked.directed(portion(progress, 0.0, 0.4))
        return asked.along(directions, portion(progress, 0.4, 0.6))

    def mixed(self, result: PatternResult, share: float) -> PatternResult:
        """A result whose phases are between the shown ones and those of ``result``, with a share of the latter."""
        phases = (1 - share) * self.phases + share * result.pattern.phases
        size = np.abs(phases)
        phases = np.where(size > 0, phases, result.pattern.phases) / np.where(size > 0, size, 1)
        return replace(result, pattern=result.pattern.with_phases(phases))
