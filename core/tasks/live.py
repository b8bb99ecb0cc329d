# SPDX-License-Identifier: GPL-3.0-or-later
"""A pattern after a change of its settings, from the one that is shown: quick enough to follow a slider."""

from dataclasses import dataclass

import numpy as np

from ..fields import DirectionField
from ..monitor import portion
from ..solve.warm_start import Follower
from .surfaces import SurfaceRequest


@dataclass(frozen=True)
class LiveRequest:
    """The pattern that descent reaches from the one that is shown.

    Attributes
    ----------
    asked : SurfaceRequest of stripes or quads, on the mesh of what is shown
    field : DirectionField that is shown, whose solution and problem do not count
    phases : (k n,) complex that are shown
    turns_only : whether nothing is asked of the directions but another angle
    followers : Follower of the directions and of the pattern, the same in each request that follows
    """

    asked: SurfaceRequest
    field: DirectionField
    phases: np.ndarray
    turns_only: bool
    followers: tuple[Follower, Follower]

    @property
    def shared(self):
        """The meshes of what is shown."""
        return self.asked.shared

    @property
    def kept(self):
        """What the next request is likely to hold as well: whoever solves this one keeps it until then."""
        return *self.shared, *self.followers

    def solve(self, progress=None):
        """The :class:`SurfaceResult`; errors as of :meth:`SurfaceRequest.solve`."""
        of_field, of_pattern = self.followers
        if self.turns_only:
            directions = self.field.turned(self.asked.turn - self.field.turn)
        else:
            directions = self.asked.directed(portion(progress, 0.0, 0.4), self.field, of_field)
        return self.asked.along(directions, portion(progress, 0.4, 0.6), self, follower=of_pattern)
