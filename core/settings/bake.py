# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of a bake: which maps, and how they are stored."""

import string
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from ..errors import SettingError, quote_value
from ..validation import check_path
from .setting import FOLDER, PIXELS, Choice, SettingsRecord, setting

BAKES = ("bake",)
_bake_setting = partial(setting, commands=BAKES)


class MapKind(NamedTuple):
    """How a map is stored.

    Attributes
    ----------
    is_grey : one channel, not three
    png_depth, exr_depth : bits of a channel
    meaning : of its values
    is_color : whether the values are colours
    """

    is_grey: bool
    png_depth: str
    exr_depth: str
    meaning: str
    is_color: bool = False


# In the order in which they are baked. Files and flags have the same names.
MAPS = {
    "mask": MapKind(True, "8", "16", "the factor of the pattern: 1 in a stripe or on a line, 0 elsewhere"),
    "colour": MapKind(False, "8", "16", "base colour of what is rendered", is_color=True),
    "height": MapKind(True, "16", "32", "height of the pattern, from 0 to 1"),
    "normal": MapKind(False, "8", "16", "tangent space normal of what is rendered, bump included; +X +Y +Z"),
    "phase": MapKind(False, "16", "32", "two values of the phase from -1 to 1, kept as (1 + value) / 2"),
    "index": MapKind(True, "16", "32", "number of the stripe or quad, from 1 on; PNG: over 65535"),
}
_MAPS = (
    Choice("mask", "Mask", "1 in a stripe or on a line, 0 elsewhere, on all faces", "MOD_MASK"),
    Choice("colour", "Color", "The base color of what is rendered", "COLOR"),
    Choice("height", "Height", "Height of the pattern from 0 to 1, with 16 bits", "MOD_DISPLACE"),
    Choice("normal", "Normal", "Tangent space normals of what is rendered, with its bump", "NORMALS_FACE"),
    Choice("phase", "Phase", "Cosine and size of the sine of the phase; of quads, both cosines in order", "FORCE_WIND"),
    Choice("index", "Index", "A number for each stripe or quad; a stripe ends at defects", "LINENUMBERS_ON"),
)
_FORMATS = (
    Choice("PNG", "PNG", "8 bits, and 16 for height, phase and index"),
    Choice("EXR", "OpenEXR", "Floating-point numbers: 16 bits, and 32 for height, phase and index"),
)
SUFFIXES = {"PNG": ".png", "EXR": ".exr"}
# The UV map that is made if none is named.
NEW_MAP = "Synch Bake"


@dataclass(frozen=True, kw_only=True)
class BakeSettings(SettingsRecord):
    """Which maps are baked, and where they are stored."""

    maps: tuple[str, ...] = _bake_setting(
        ("colour", "normal", "height"), "Maps", "Images to bake; click with Shift to choose several", choices=_MAPS
    )
    size: int = _bake_setting(
        1024,
        "Size",
        "Width and height of the images in pixels",
        unit=PIXELS,
        least=16,
        most=16384,
        usual=(None, 8192),
        group="bake",
    )
    margin: int = _bake_setting(
        16,
        "Margin",
        "Pixels by which the image continues beyond UV islands, so that seams show no background",
        unit=PIXELS,
        least=0,
        most=16384,
        usual=(None, 64),
        group="bake",
    )
    samples: int = _bake_setting(
        16,
        "Samples",
        "Samples of each pixel: more make edges smoother and take longer",
        least=1,
        most=4096,
        usual=(None, 64),
        group="bake",
    )
    uv_map: str = _bake_setting("", "UV Map", "UV map to bake over; empty for the active one", unset="the active one")
    unwrap: bool = _bake_setting(
        False, "Smart UV Project", f"Make the UV map if the mesh does not have it; where none is named, {NEW_MAP!r}"
    )
    folder: str = _bake_setting(
        "",
        "Folder",
        "Folder for the files; empty to pack the images into the .blend",
        names=FOLDER,
        unset="packed into the .blend of --output",
    )
    naming: str = _bake_setting(
        "{object}_{map}",
        "Name",
        "Name of each file or image; {object} and {map} are filled in",
        group="files",
        flag="name",
    )
    file_format: str = _bake_setting(
        "PNG", "Format", "File format of the images", choices=_FORMATS, group="files", flag="format"
    )
    material: bool = _bake_setting(
        False,
        "Material of Images",
        "Show the images in place of the pattern; the pattern's material is kept for the next bake",
        group="files",
    )
    displacement: bool = _bake_setting(
        False, "Displacement", "Let the new material displace the surface by the height when it is rendered"
    )

    def __post_init__(self) -> None:
        self._order_maps()
        super().__post_init__()
        if self.margin > self.size:
            raise SettingError(f"the margin is {self.margin}: give a whole number from 0 to {self.size}")
        if self.material and not {"colour", "normal", "height"} & set(self.maps):
            raise SettingError("a material shows colour, normal or height: add one of them to the maps")
        if self.displacement and not (self.material and "height" in self.maps):
            raise SettingError("displacement is made by a material of the height: ask for both")
        check_path(self.folder, "the folder")
        self._check_name()

    def _order_maps(self) -> None:
        """Put the maps into the order in which they are baked; they may be given as a text with commas."""
        names = self.maps.split(",") if isinstance(self.maps, str) else self.maps
        if not isinstance(names, list | tuple):
            raise SettingError(f"the maps are {quote_value(names)}: give names such as colour,normal")
        for name in names:
            if not isinstance(name, str) or name not in MAPS:
                raise SettingError(f"the map {quote_value(name)} is unknown: use one or more of {', '.join(MAPS)}")
        object.__setattr__(self, "maps", tuple(name for name in MAPS if name in names))
        if not self.maps:
            raise SettingError(f"no map is asked for: choose one or more of {', '.join(MAPS)}")

    def _check_name(self) -> None:
        try:
            used = {field for _, field, _, _ in string.Formatter().parse(self.naming) if field is not None}
            if used <= {"object", "map"}:
                self.naming.format(object="", map="")
        except (ValueError, LookupError, MemoryError):  # a wrong format, a field in a format, a huge width
            used = {self.naming}
        if used - {"object", "map"} or not self.naming.strip() or set(self.naming) & set("/\\"):
            raise SettingError(
                f"the name {quote_value(self.naming)} cannot be filled in: use letters, {{object}} and {{map}}"
            )
        if len(self.maps) > 1 and "map" not in used:
            raise SettingError(f"the name {self.naming!r} is the same for {len(self.maps)} maps: add {{map}}")

    def depth(self, map_name: str) -> str:
        """Bits of a channel of a map."""
        kind = MAPS[map_name]
        return kind.png_depth if self.file_format == "PNG" else kind.exr_depth
