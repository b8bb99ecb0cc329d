# SPDX-License-Identifier: GPL-3.0-or-later
"""Description of a printer, read from a small file of the user or of the extension."""

import math
import re
import tomllib
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from ..errors import SettingError, quote_value
from ..files.border import SETTINGS_BYTES, border, read_text
from ..validation import check_choice, check_path, check_positive, convert_values, from_names

AXES = ("xyz", "ac", "bc")
MOVES = ("inverse", "feed", "tcp")
EXTRUSIONS = ("relative", "absolute")
ORIGINS = ("corner", "centre")
SEAMS = ("nearest", "back")
SUFFIX = ".toml"
_SHIPPED = Path(__file__).parent / "machines"
# Names of the machines that are shipped, and the one of programs that name none.
MACHINES = tuple(sorted(path.stem for path in _SHIPPED.glob(f"*{SUFFIX}")))
USUAL = "marlin"
# Words of a start text that the lines after it put right, with what they set; and one that nothing can.
_OVERRIDDEN = {"G20": "inches", "G91": "relative places", "G93": "inverse time"}
_EXTRUSION = {"relative": ("M83", {"M82": "absolute extrusion"}), "absolute": ("M82", {"M83": "relative extrusion"})}
_VOLUMETRIC = "M200"
# Diameter of a filament of which a millimetre is a cubic millimetre.
_CUBIC = 1.128379


@dataclass(frozen=True)
class Machine:
    """A printer; lengths in millimetres, angles in degrees, feeds in millimetres a minute.

    Attributes
    ----------
    axes : "xyz", with the tool upright and varying height; "ac" or "bc", with a table that turns around X or Y on one
        that turns around Z, so that the tool stands along the layer's normal
    moves : of five axes: "inverse" time (G93); "feed", of the linear axes together, or of the table where it alone
        turns; "tcp", places of the tip on the part (G43.4), which the machine follows by itself
    extrusion : "relative" (M83) or "absolute" (M82)
    scale : millimetres of a scene unit
    bed_width, bed_depth, bed_height : what the tip can reach along X, Y and Z, 0 where it is not known
    bed_origin : where X = Y = 0 is: the "corner" or the "centre" of the bed
    bed_x, bed_y : where the middle of the part stands, its lowest place at Z = 0; None for the middle of the bed
    pivot_z : height at which the axes of a turning table meet, above X = Y = 0
    nozzle_radius, nozzle_angle, nozzle_length : of the tip, between its axis and its side, and up to what is wide
    bore : diameter of the nozzle's opening, about as wide as beads; 0 where it is not known
    largest_tilt : of the tool from upright, on five axes; of layers that a tool that stands upright may follow
    smallest_height, largest_height : of layers that the nozzle can lay
    feed, first_feed, travel_feed, retraction_feed : while it extrudes, on the first layer, moves, and draws back; a
        first_feed of 0 for the usual one
    largest_flow : cubic millimetres a second, 0 for no limit
    acceleration : along the path, millimetres a second squared, for the time that a program takes
    turn_speed, turn_acceleration : of the table's axes at most, degrees a second (squared)
    deviation : of the tip from its way between points
    filament : diameter; 1.128379 counts extrusion in cubic millimetres
    flow : of extrusion, 1 for the volume of the bead
    tolerance : distance of points from straight moves at which they are left out, as a share of a bead's width
    retraction, lift : length of filament that is drawn back between beads, and how far the tool leaves the bead
    seam : where beads that close begin: at the place that is "nearest", or at their "back", the largest Y, where they
        make one seam
    hop : shorter ways to another bead of the same layer need neither
    walls, skins, infill : contours beside the rim, layers at the bottom and the top that are filled, and share of the
        volume between them; 1 fills the part
    skirt, skirt_distance : lines around the first layer, and their distance from it; 0 makes them a brim
    nozzle_temperature, bed_temperature : degrees, 0 for no heating
    fan, fan_from : share of its speed, and the layer from which on it runs
    start, end : text before and after the moves
    """

    axes: str = "xyz"
    moves: str = "inverse"
    extrusion: str = "relative"
    scale: float = 1.0
    bed_width: float = 0.0
    bed_depth: float = 0.0
    bed_height: float = 0.0
    bed_origin: str = "centre"
    bed_x: float | None = None
    bed_y: float | None = None
    pivot_z: float = 0.0
    nozzle_radius: float = 0.2
    nozzle_angle: float = 30.0
    nozzle_length: float = 10.0
    bore: float = 0.0
    largest_tilt: float = 45.0
    smallest_height: float = 0.0
    largest_height: float = math.inf
    feed: float = 1200.0
    first_feed: float = 0.0
    travel_feed: float = 6000.0
    retraction_feed: float = 1800.0
    largest_flow: float = 0.0
    acceleration: float = 1000.0
    turn_speed: float = 60.0
    turn_acceleration: float = 600.0
    deviation: float = 0.05
    filament: float = 1.75
    flow: float = 1.0
    tolerance: float = 0.02
    retraction: float = 1.0
    lift: float = 0.5
    hop: float = 0.0
    seam: str = "nearest"
    walls: int = 2
    skins: int = 4
    infill: float = 1.0
    skirt: int = 0
    skirt_distance: float = 5.0
    nozzle_temperature: float = 0.0
    bed_temperature: float = 0.0
    fan: float = 0.0
    fan_from: int = 1
    start: str = "G28"
    end: str = "M104 S0\nM84"

    def __post_init__(self) -> None:
        convert_values(self)
        check_choice(self, "axes", AXES)
        check_choice(self, "moves", MOVES)
        check_choice(self, "extrusion", EXTRUSIONS)
        check_choice(self, "bed_origin", ORIGINS)
        check_choice(self, "seam", SEAMS)
        positive = ("scale", "nozzle_radius", "nozzle_length", "feed", "travel_feed", "retraction_feed", "filament")
        check_positive(self, *positive, "flow", "acceleration", "turn_speed", "turn_acceleration", "deviation")
        for name in ("bed_x", "bed_y", "pivot_z"):
            value = getattr(self, name)
            if value is not None and not math.isfinite(value):
                raise SettingError(f"the {name} is {quote_value(value)}: give a finite number")
        not_negative = (
            *("bed_width", "bed_depth", "bed_height", "bore", "smallest_height", "first_feed", "largest_flow"),
            *("tolerance", "retraction", "lift", "hop", "skirt", "skirt_distance", "nozzle_temperature"),
            *("bed_temperature", "fan", "fan_from", "walls", "skins", "infill"),
        )
        for name in not_negative:
            if not 0 <= getattr(self, name) < math.inf:
                raise SettingError(f"the {name} is {quote_value(getattr(self, name))}: give a number from 0 on")
        if self.skirt > 100:
            raise SettingError(f"the skirt is {quote_value(self.skirt)}: give 100 lines or fewer")
        for name in ("fan", "infill"):
            if getattr(self, name) > 1:
                raise SettingError(f"the {name} is {getattr(self, name):g}: give a share from 0 to 1")
        if not (self.walls or self.skins or self.infill):
            raise SettingError("the walls, skins and infill are all 0: give one of them, or nothing would be printed")
        if not self.largest_height > self.smallest_height:
            raise SettingError(f"the largest_height is {self.largest_height:g}: give more than the smallest_height")
        for name in ("nozzle_angle", "largest_tilt"):
            if not 0 <= getattr(self, name) < 90:
                raise SettingError(f"the {name} is {quote_value(getattr(self, name))}: give degrees from 0 to below 90")
        is_volumetric = re.search(_VOLUMETRIC + r"(?![\d.])(?!\s*D0\b)", self._start_code)
        if is_volumetric and abs(self.filament - _CUBIC) > 1e-3:
            raise SettingError(
                f"the start text makes extrusion volumetric ({_VOLUMETRIC}): take it out, or write filament = {_CUBIC}"
            )

    @property
    def _start_code(self) -> str:
        """The start text without comments, in capital letters."""
        return re.sub(r";.*|\([^()\n]*\)", "", self.start).upper()

    @property
    def _start_words(self) -> list[str]:
        return re.findall(r"[GM]\d+(?![\d.])", self._start_code)

    @property
    def contradictions(self) -> dict[str, str]:
        """Words of the start text that the moves contradict, and what they set; :attr:`modes` puts them right."""
        wrong, words = _OVERRIDDEN | _EXTRUSION[self.extrusion][1], self._start_words
        # The last of a kind counts.
        undone = {"G91": "G90", "G20": "G21", "G93": "G94"}
        last = {word: place for place, word in enumerate(words)}
        return {
            word: meaning
            for word, meaning in wrong.items()
            if word in last and last[word] > last.get(undone.get(word, self.modes.split()[-1]), -1)
        }

    @property
    def modes(self) -> str:
        """Words after the start text: millimetres, places that are absolute, and how extrusion counts."""
        return f"G21 G90 {_EXTRUSION[self.extrusion][0]}"

    @property
    def turns(self) -> bool:
        """Whether the tool follows the layers' normals."""
        return self.axes != "xyz"

    @property
    def middle(self) -> tuple[float, float]:
        """X and Y of the middle of the part."""
        half = 0.5 if self.bed_origin == "corner" else 0.0
        x, y = (half * size if at is None else at
                for at, size in ((self.bed_x, self.bed_width), (self.bed_y, self.bed_depth)))  # fmt: skip
        return x, y

    @property
    def reach(self) -> tuple[list[float], list[float]]:
        """Lowest and highest X, Y and Z of the bed, infinite where it is not known."""
        low, high = [], []
        for size in (self.bed_width, self.bed_depth):
            begin = 0.0 if self.bed_origin == "corner" else -size / 2
            low.append(begin if size else -math.inf)
            high.append(begin + size if size else math.inf)
        return [*low, -math.inf], [*high, self.bed_height or math.inf]


def read_machine(path: str | PathLike[str]) -> Machine:
    """The :class:`Machine` of a name among :data:`MACHINES`, or of a .toml file with some of its attributes; the others
    are as in the machine that a line such as ``machine = "marlin"`` names, or as they are by default.

    Raises
    ------
    SettingError
        with one line that names the file, what is wrong in it, and the remedy
    """
    path = Path(check_path(path, "the machine's file"))
    if str(path) in MACHINES:
        path = _SHIPPED / f"{path}{SUFFIX}"
    if path.suffix.lower() != SUFFIX:
        raise SettingError(f"{path}: a machine's file must end in {SUFFIX}, or be one of {', '.join(MACHINES)}")
    with border(path, "write lines such as feed = 1200"):
        values = tomllib.loads(read_text(path, SETTINGS_BYTES))
        base = values.pop("machine", None)
        if base is not None and base not in MACHINES:
            raise SettingError(f"the machine {quote_value(base)} is unknown: use one of {', '.join(MACHINES)}")
        known = {} if base is None else tomllib.loads(read_text(_SHIPPED / f"{base}{SUFFIX}", SETTINGS_BYTES))
        return from_names(Machine, known | values)
