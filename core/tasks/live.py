# SPDX-License-Identifier: GPL-3.0-or-later
"""Updates the shown pattern after a change of its settings, fast enough to follow a slider."""

from dataclasses import dataclass

import numpy as np

from ..fields import DirectionField
from ..geometry import TriangleMesh
from ..monitor import Callback, portion
from ..solve.warm_start import Follower
from .surfaces import PatternResult, SurfaceRequest


@dataclass(frozen=True)
class LiveRequest:
    """Asks for the pattern that descent reaches from the one that is shown.

    Attributes
    ----------
    asked : stripes or quads, on the mesh of the shown pattern
    field : the shown directions; their solution and problem are not used
    phases : (k n,) complex phases that are shown
    turns_only : whether only the angle of the directions has changed
    followers : of the directions and of the pattern, the same in all requests of a session
    """

    asked: SurfaceRequest
    field: DirectionField
    phases: np.ndarray
    turns_only: bool
    followers: tuple[Follower, Follower]

    @property
    def shared(self) -> tuple[TriangleMesh, TriangleMesh]:
        return self.asked.shared

    @property
    def kept(self) -> tuple[TriangleMesh | Follower, ...]:
        """Objects that the next request will probably contain too (:mod:`.`)."""
        return *self.shared, *self.followers

    def solve(self, progress: Callback | None = None) -> PatternResult:
        """The updated pattern; errors as :meth:`SurfaceRequest.solve`."""
        of_field, of_pattern = self.followers
        if self.turns_only:
            directions = self.field.turned(self.asked.turn - self.field.turn)
        else:
            directions = self.asked.directed(portion(progress, 0.0, 0.4), self.field, of_field)
        return self.asked.next_along(directions, self.phases, portion(progress, 0.4, 0.6), follower=of_pattern)
