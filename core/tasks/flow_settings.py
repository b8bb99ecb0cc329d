# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of vortices of flows."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from numbers import Integral, Real

from ..errors import SettingError, shown
from ..files.flows import VELOCITY
from ..keywords import MOST_ROUNDS, check_choice, check_positive, check_whole
from .settings import SolverSettings

SHOWN = ("filaments", "tubes", "both")
# Radius of the cores of curves in cells, and where tubes are shown.
_CORE, _CORE_OF_TUBES = 0.5, 2.0


@dataclass(frozen=True)
class ClebschSettings(SolverSettings):
    """Settings of the operator, the command line and the API alike, besides those of the solver.

    Attributes
    ----------
    show : "filaments", "tubes" or "both"
    resolution : nodes along the longest side that files and curves are resampled to
    count : filaments through the plane of the grid with most vorticity, unless a quantum is given
    quantum : circulation of one filament, None for one that makes ``count`` of them
    core : radius over which the vorticity of curves is spread, in cells; None for half a cell, and two where tubes are
        shown, which are nothing without an inside
    attribute : velocity on the vertices of a mesh, which then shows the map itself; or the grid of a volume, where
        "velocity" also stands for vel, v, or the only grid of vectors
    point : of the sphere, from which tubes are seen: they are around where the map shows its antipode; for filaments
        None shows the best map, a point the projection along it
    opening : degrees around the antipode that are inside a tube
    smoothing : how often points of filaments, and vertices of tubes, move to the middle of their neighbours
    unwrapped : draw filaments in one piece where they leave a periodic box, instead of in parts that lie in it
    frames : first and last frame of a sequence, None for what the source is now
    strict : refuse a mesh that is no surface as it is, instead of solving on the surface nearest to it
    """

    show: str = "filaments"
    resolution: int = 48
    count: float = 4.0
    quantum: float | None = None
    core: float | None = None
    attribute: str = VELOCITY
    point: tuple[float, float, float] | None = None
    opening: float = 60.0
    smoothing: int = 5
    unwrapped: bool = False
    frames: tuple[int, int] | None = None
    strict: bool = False

    def __post_init__(self):
        super().__post_init__()
        check_choice(self, "show", SHOWN)
        check_positive(self, "count", "opening", optional=("quantum", "core"))
        check_whole(self, "smoothing", most=MOST_ROUNDS)
        if self.frames is not None:
            if not _are(Integral, 2, self.frames):
                raise SettingError(
                    f"the frames are {shown(self.frames)}: give the first and the last one, whole numbers"
                )
            first, last = self.frames
            if first > last:
                raise SettingError(f"the frames {first} to {last} are none: give the first one first")
        if self.opening >= 180:
            raise SettingError(f"the opening is {self.opening:g} degrees: the whole sphere has 180, give less")
        if self.point is not None:
            if not (_are(Real, 3, self.point) and all(map(math.isfinite, self.point)) and any(self.point)):
                raise SettingError(
                    f"the point of the sphere is {shown(self.point)}: give three numbers that are not all 0"
                )
            object.__setattr__(self, "point", tuple(map(float, self.point)))
        if (self.show != "filaments" or self.point is not None) and self.method != "sdp":
            raise SettingError("tubes and points of the sphere come from the relaxation: use the method sdp")

    @property
    def core_cells(self):
        """Radius of the cores of curves in cells."""
        return self.core or (_CORE if self.show == "filaments" else _CORE_OF_TUBES)


def _are(kind, count, values):
    """Whether values are so many of a kind."""
    values = list(values) if isinstance(values, Iterable) else []
    return len(values) == count and all(isinstance(value, kind) for value in values)
