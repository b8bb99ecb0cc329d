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
        "Width of a stripe as part of a period; its edges are drawn. 0 draws the middles of stripes and the grid "
        "lines of quads, 1 the middles of gaps",
        least=0,
        most=1,
    )
    distance: float = _line_setting(
        0.1,
        "Distance",
        "Distance between the points of a line, in spacings; 0 puts them where it crosses the mesh's edges",
        least=0,
        usual=(None, 1),
        zero="At edges",
    )
    smoothing: int = _line_setting(
        6,
        "Smoothing",
        "Number of smoothing steps, in which points move to the middle of their neighbours and back to the surface",
        least=0,
        most=MOST_ROUNDS,
        usual=(None, 50),
    )
    radius: float = _line_setting(
        0.1,
        "Radius",
        "Radius of tubes around the lines, in spacings; 0 for none",
        least=0,
        usual=(None, 0.5),
        zero="No tubes",
    )
    spline: str = _line_setting("poly", "Spline", "Kind of spline", choices=_SPLINES)
