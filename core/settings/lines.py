# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the lines of a pattern as a curve object; lengths are in spacings."""

from dataclasses import dataclass
from functools import partial

from ..validation import MOST_ROUNDS
from .setting import Choice, SettingsRecord, setting

LINES = ("isolines",)
_line_setting = partial(setting, commands=LINES, group="lines")
_SPLINES = (
    Choice("poly", "Poly", "Straight from point to point, with the tilt of the surface: ribbons lie on it"),
    Choice("bezier", "Bezier", "Smooth through the points"),
    Choice("nurbs", "NURBS", "Smooth along the points"),
)


@dataclass(frozen=True, kw_only=True)
class LineSettings(SettingsRecord):
    """How lines of a pattern are drawn."""

    width: float = _line_setting(
        0.0,
        "Width",
        "Part of a period that is stripe and whose edges are drawn; 0 for the middles of stripes, 1 for those of gaps. "
        "Quads have grid lines: 0",
        least=0,
        most=1,
    )
    distance: float = _line_setting(
        0.1,
        "Distance",
        "Between the points of a line, in spacings; 0 for where it crosses the mesh's edges",
        least=0,
        usual=(None, 1),
    )
    smoothing: int = _line_setting(
        6,
        "Smoothing",
        "How often points move to the middle of their neighbours, before they are put back on the surface",
        least=0,
        most=MOST_ROUNDS,
        usual=(None, 50),
    )
    radius: float = _line_setting(
        0.1, "Radius", "Of tubes around the lines, in spacings; 0 for none", least=0, usual=(None, 0.5)
    )
    spline: str = _line_setting("poly", "Spline", "What the lines are made of", choices=_SPLINES)
