# SPDX-License-Identifier: GPL-3.0-or-later
"""What a printer is, from one small file."""

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path

from ..errors import SettingError, quote_value
from ..files.border import SETTINGS_BYTES, border, read_text
from ..validation import check_choice, check_path, check_positive, convert_values, from_names

AXES = ("xyz", "ac", "bc")
SUFFIX = ".toml"


@dataclass(frozen=True)
class Machine:
    """A printer; lengths in millimetres, angles in degrees, feeds in millimetres a minute.

    Attributes
    ----------
    axes : "xyz", with the tool upright and varying height; "ac" or "bc", with a table that turns around X or Y on one
        that turns around Z, so that the tool stands along the layer's normal
    scale : millimetres of a scene unit
    bed_x, bed_y : where the middle of the part stands, its lowest place at Z = 0
    pivot_z : height at which the axes of a turning table meet, above X = Y = 0
    nozzle_radius, nozzle_angle, nozzle_length : of the tip, between its axis and its side, and up to what is wide
    largest_tilt : of the tool from upright, on five axes; of layers that a tool that stands upright may follow
    smallest_height, largest_height : of layers that the nozzle can lay
    feed, travel_feed, retraction_feed : while it extrudes, moves, and draws back
    filament : diameter
    flow : of extrusion, 1 for the volume of the bead
    tolerance : distance of points from straight moves at which they are left out, as a share of a bead's width
    retraction, lift : length of filament that is drawn back between beads, and how far the tool leaves the bead
    start, end : text before and after the moves
    """

    axes: str = "xyz"
    scale: float = 1.0
    bed_x: float = 0.0
    bed_y: float = 0.0
    pivot_z: float = 0.0
    nozzle_radius: float = 0.2
    nozzle_angle: float = 30.0
    nozzle_length: float = 10.0
    largest_tilt: float = 45.0
    smallest_height: float = 0.0
    largest_height: float = math.inf
    feed: float = 1200.0
    travel_feed: float = 6000.0
    retraction_feed: float = 1800.0
    filament: float = 1.75
    flow: float = 1.0
    tolerance: float = 0.02
    retraction: float = 1.0
    lift: float = 0.5
    start: str = "G21\nG90\nM83\nG28"
    end: str = "M104 S0\nM84"

    def __post_init__(self):
        convert_values(self)
        check_choice(self, "axes", AXES)
        positive = ("scale", "nozzle_radius", "nozzle_length", "feed", "travel_feed", "retraction_feed", "filament")
        check_positive(self, *positive, "flow")
        for name in ("bed_x", "bed_y", "pivot_z"):
            if not math.isfinite(getattr(self, name)):
                raise SettingError(f"the {name} is {quote_value(getattr(self, name))}: give a finite number")
        for name in ("smallest_height", "tolerance", "retraction", "lift"):
            if not 0 <= getattr(self, name) < math.inf:
                raise SettingError(f"the {name} is {quote_value(getattr(self, name))}: give a number from 0 on")
        if not self.largest_height > self.smallest_height:
            raise SettingError(f"the largest_height is {self.largest_height:g}: give more than the smallest_height")
        for name in ("nozzle_angle", "largest_tilt"):
            if not 0 <= getattr(self, name) < 90:
                raise SettingError(f"the {name} is {quote_value(getattr(self, name))}: give degrees from 0 to below 90")

    @property
    def turns(self):
        """Whether the tool follows the layers' normals."""
        return self.axes != "xyz"


def read_machine(path):
    """The :class:`Machine` of a .toml file with some of its attributes, the others as they are by default.

    Raises
    ------
    SettingError
        with one line that names the file, what is wrong in it, and the remedy
    """
    path = Path(check_path(path, "the machine's file"))
    if path.suffix.lower() != SUFFIX:
        raise SettingError(f"{path}: a machine's file must end in {SUFFIX}")
    with border(path, "write lines such as feed = 1200"):
        return from_names(Machine, tomllib.loads(read_text(path, SETTINGS_BYTES)))
