# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the vortices of a flow."""

import math
from dataclasses import dataclass
from functools import partial
from numbers import Integral, Real

from ..errors import SettingError, quote_value
from ..validation import FRAMES_END, MOST_ROUNDS, are_frames
from .setting import SHARE, SMALLEST, Choice, of_type, setting
from .solver import SolverSettings

VORTICES = ("clebsch",)
_flow_setting = partial(setting, commands=VORTICES)
# What a flow is called where no name is given.
VELOCITY = "velocity"
# Radius of the cores of curves in cells, and where tubes are shown.
_CORE, _CORE_OF_TUBES = 0.5, 2.0
_SHOWN = (
    Choice("filaments", "Filaments", "Curves, each of the same circulation"),
    Choice("tubes", "Tubes", "Surfaces around the vorticity, coloured by the map; they need the method Semidefinite"),
    Choice("both", "Both", "Filaments and tubes from one solve"),
)


def automatic_core(show: str) -> float:
    """Radius of the cores of curves in cells where none is given."""
    return _CORE if show == "filaments" else _CORE_OF_TUBES


@dataclass(frozen=True, kw_only=True)
class FlowSettings(SolverSettings):
    """Settings of the vortices of a flow, besides those of the solver."""

    show: str = _flow_setting("filaments", "Show", "How vortices are shown", choices=_SHOWN, group="flow")
    resolution: int = _flow_setting(
        48,
        "Resolution",
        "Nodes of the grid along its longest side; a NumPy file has its own grid",
        least=8,
        most=10_000,
        usual=(None, 128),
        group="flow",
    )
    share: float = _flow_setting(
        0.8,
        "Vorticity Carried",
        "Share of the vorticity that filaments carry: the circulation of each is the largest with which they do",
        unit=SHARE,
        least=0.1,
        most=0.99,
    )
    count: float | None = _flow_setting(
        None,
        "Filaments",
        "Number of filaments through the plane with the most vorticity",
        least=SMALLEST,
        start=4.0,
        usual=(0.1, 32),
        unset="the share of the vorticity decides",
        placeholder="N",
    )
    quantum: float | None = _flow_setting(
        None,
        "Circulation",
        "Circulation of one filament, in units of velocity times length",
        least=SMALLEST,
        start=1.0,
        usual=(1e-6, 100),
        unset="the number of filaments or the share of the vorticity decides",
        placeholder="H",
    )
    core: float | None = _flow_setting(
        None,
        "Core",
        "Radius over which the vorticity of curves is spread, in cells; "
        "0 for half a cell, and two where tubes are shown",
        least=SMALLEST,
        usual=(None, 6),
        unset="0.5, and 2 where tubes are shown",
        zero="Auto",
        placeholder="CELLS",
    )
    attribute: str = _flow_setting(
        VELOCITY,
        "Attribute",
        "Velocity: an attribute of the chosen mesh's vertices, which then shows the map itself, or a grid of a volume",
        group="flow",
    )
    point: tuple[float, float, float] | None = _flow_setting(
        None,
        "Point",
        "Point of the sphere: filaments are where the map takes its antipode, and tubes surround them",
        unset="the filaments of least energy",
    )
    opening: float = _flow_setting(
        60.0,
        "Width",
        "Size of tubes: radius of their inside on the sphere, degrees around the chosen point's antipode",
        least=SMALLEST,
        most=179.9,
        usual=(1, 179),
        placeholder="DEG",
    )
    smoothing: int = _flow_setting(
        5,
        "Smoothing",
        "Number of smoothing steps, in which points of filaments and tubes move to the middle of their neighbours",
        least=0,
        most=MOST_ROUNDS,
        usual=(None, 20),
    )
    unwrapped: bool = _flow_setting(
        False,
        "Unwrapped",
        "Draw filaments that leave a periodic box in one piece, instead of in parts inside it",
        group="flow",
    )
    frames: tuple[int, int] | None = _flow_setting(
        None,
        "Frames",
        "First and last frame of a sequence: files with # for each digit of the number, smoke_####.vdb, or a volume's",
        unset="what the source shows now",
    )
    strict: bool = _flow_setting(
        False, "Strict", "Refuse meshes that are not manifold, instead of solving on a repaired copy"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.frames is not None:
            if not of_type(self.frames, Integral, 2):
                raise SettingError(
                    f"the frames are {quote_value(self.frames)}: give the first and the last one, whole numbers"
                )
            first, last = self.frames
            if not are_frames(first, last):
                raise SettingError(
                    f"the frames are {quote_value(first)} to {quote_value(last)}: give the first and the last, in "
                    f"order, below {FRAMES_END:,}"
                )
        if self.point is not None:
            if not (of_type(self.point, Real, 3) and all(map(math.isfinite, self.point)) and any(self.point)):
                raise SettingError(
                    f"the point of the sphere is {quote_value(self.point)}: give three numbers that are not all 0"
                )
            object.__setattr__(self, "point", tuple(map(float, self.point)))
        if (self.show != "filaments" or self.point is not None) and self.method != "sdp":
            raise SettingError("tubes and points of the sphere come from the relaxation: use the method sdp")

    @property
    def core_cells(self) -> float:
        """Radius of the cores of curves in cells."""
        return self.core or automatic_core(self.show)
