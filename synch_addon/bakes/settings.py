# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be baked and how it is kept: maps, their formats, and the settings of a bake."""

import string
from dataclasses import dataclass
from typing import NamedTuple

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

from ...core.errors import SettingError, shown
from ...core.keywords import check_choice, check_path, take_all

SIZES = (16, 16384)
_MOST_SAMPLES = 4096


class MapKind(NamedTuple):
    """How a map is kept: grey or not, bits of a channel as PNG and as EXR, and what its values stand for."""

    is_grey: bool
    png_depth: str
    exr_depth: str
    meaning: str
    is_color: bool = False


# In the order in which they are baked. The names are those of files and flags too.
MAPS = {
    "mask": MapKind(True, "8", "16", "the factor of the pattern: 1 in a stripe or on a line, 0 elsewhere"),
    "colour": MapKind(False, "8", "16", "base colour of what is rendered", is_color=True),
    "height": MapKind(True, "16", "32", "height of the pattern, from 0 to 1"),
    "normal": MapKind(False, "8", "16", "tangent space normal of what is rendered, bump included; +X +Y +Z"),
    "phase": MapKind(False, "16", "32", "two values of the phase from -1 to 1, kept as (1 + value) / 2"),
    "index": MapKind(True, "16", "32", "number of the stripe or quad, from 1 on; PNG: over 65535"),
}
# The UV map that is made where none is named.
NEW_MAP = "Synch Bake"
SUFFIXES = {"PNG": ".png", "EXR": ".exr"}


@dataclass(frozen=True)
class BakeSettings:
    """Settings of a bake, for operator, command line and API alike.

    Attributes
    ----------
    maps : names of :data:`MAPS`, also as one text with commas
    size : of the images in pixels, as wide as high
    margin : pixels by which each island of the UV map is extended
    samples : of each pixel of mask, colour, height and normal; phase and index are taken at its centre
    uv_map : name of a UV map; "" for the active one, or with `unwrap` for :data:`NEW_MAP`
    unwrap : make the UV map by Smart UV Project if the mesh does not have it
    folder : where the files go; "" for images packed into the .blend
    naming : name of each file or image, without suffix; {object} and {map} are filled in
    file_format : "PNG" or "EXR"
    material : show the images instead of the pattern, by a new material
    displacement : the new material displaces the surface by the height, too
    """

    maps: tuple[str, ...] = ("colour", "normal", "height")
    size: int = 1024
    margin: int = 16
    samples: int = 16
    uv_map: str = ""
    unwrap: bool = False
    folder: str = ""
    naming: str = "{object}_{map}"
    file_format: str = "PNG"
    material: bool = False
    displacement: bool = False

    def __post_init__(self):
        take_all(self)
        names = self.maps.split(",") if isinstance(self.maps, str) else self.maps
        if not isinstance(names, list | tuple):
            raise SettingError(f"the maps are {shown(names)}: give names such as colour,normal")
        for name in names:
            if not isinstance(name, str) or name not in MAPS:
                raise SettingError(f"the map {shown(name)} is unknown: use one or more of {', '.join(MAPS)}")
        object.__setattr__(self, "maps", tuple(name for name in MAPS if name in names))
        if not self.maps:
            raise SettingError(f"no map is asked for: choose one or more of {', '.join(MAPS)}")
        for name, low, high in (("size", *SIZES), ("margin", 0, self.size), ("samples", 1, _MOST_SAMPLES)):
            value = getattr(self, name)
            if not low <= value <= high:
                raise SettingError(f"the {name} is {shown(value)}: give a whole number from {low} to {high}")
        check_choice(self, "file_format", SUFFIXES)
        if self.material and not {"colour", "normal", "height"} & set(self.maps):
            raise SettingError("a material shows colour, normal or height: add one of them to the maps")
        if self.displacement and not (self.material and "height" in self.maps):
            raise SettingError("displacement is made by a material of the height: ask for both")
        check_path(self.folder, "the folder")
        self._check_name()

    def _check_name(self):
        try:
            used = {field for _, field, _, _ in string.Formatter().parse(self.naming) if field is not None}
            if used <= {"object", "map"}:
                self.naming.format(object="", map="")
        except ValueError:
            used = {self.naming}
        if used - {"object", "map"} or not self.naming.strip() or set(self.naming) & set("/\\"):
            raise SettingError(
                f"the name {shown(self.naming)} cannot be filled in: use letters, {{object}} and {{map}}"
            )
        if len(self.maps) > 1 and "map" not in used:
            raise SettingError(f"the name {self.naming!r} is the same for {len(self.maps)} maps: add {{map}}")

    def file_name(self, name, map_name):
        """Of the file or image of a map of an object with this name."""
        stem = bpy.path.clean_name(self.naming.format(object=name, map=map_name))
        return stem + SUFFIXES[self.file_format]

    def depth(self, map_name):
        """Bits of a channel of a map."""
        kind = MAPS[map_name]
        return kind.png_depth if self.file_format == "PNG" else kind.exr_depth


_DEFAULT = BakeSettings()


class BakeProperties:
    """The settings as Blender properties, shared by the panel's storage and the operator."""

    maps: EnumProperty(
        name="Maps",
        description="Images to bake; click with Shift to choose several",
        items=[
            ("MASK", "Mask", "1 in a stripe or on a line, 0 elsewhere, on all faces", "MOD_MASK", 1),
            ("COLOUR", "Color", "The base color of what is rendered", "COLOR", 2),
            ("HEIGHT", "Height", "Height of the pattern from 0 to 1, with 16 bits", "MOD_DISPLACE", 4),
            ("NORMAL", "Normal", "Tangent space normals of what is rendered, with its bump", "NORMALS_FACE", 8),
            (
                "PHASE",
                "Phase",
                "Cosine and size of the sine of the phase; of quads, both cosines in order",
                "FORCE_WIND",
                16,
            ),
            ("INDEX", "Index", "A number for each stripe or quad; a stripe ends at defects", "LINENUMBERS_ON", 32),
        ],
        options={"ENUM_FLAG"},
        default={name.upper() for name in _DEFAULT.maps},
    )
    size: IntProperty(
        name="Size",
        description="Width and height of the images in pixels",
        default=_DEFAULT.size,
        min=SIZES[0],
        max=SIZES[1],
        soft_max=8192,
        subtype="PIXEL",
    )
    margin: IntProperty(
        name="Margin",
        description="How far the image goes on beyond the edges of UV islands, so that no background shows at seams",
        default=_DEFAULT.margin,
        min=0,
        soft_max=64,
        subtype="PIXEL",
    )
    samples: IntProperty(
        name="Samples",
        description="For each pixel: more make edges smoother and take longer",
        default=_DEFAULT.samples,
        min=1,
        max=_MOST_SAMPLES,
        soft_max=64,
    )
    uv_map: StringProperty(name="UV Map", description="Where on the image each face is; empty for the active map")
    unwrap: BoolProperty(
        name="Smart UV Project",
        description=f"Make the UV map if the mesh does not have it; where none is named, {NEW_MAP!r}",
    )
    folder: StringProperty(
        name="Folder", description="Where the files go; empty to pack the images into the .blend", subtype="DIR_PATH"
    )
    naming: StringProperty(
        name="Name", description="Of each file or image; {object} and {map} are filled in", default=_DEFAULT.naming
    )
    file_format: EnumProperty(
        name="Format",
        description="Kind of the images",
        items=[
            ("PNG", "PNG", "8 bits, and 16 for height, phase and index"),
            ("EXR", "OpenEXR", "Floating-point numbers: 16 bits, and 32 for height, phase and index"),
        ],
        default=_DEFAULT.file_format,
    )
    material: BoolProperty(
        name="Material of Images",
        description="Show the images in place of the pattern; its material is kept, and is what the next bake shows",
    )
    displacement: BoolProperty(
        name="Displacement", description="Let the new material displace the surface by the height when it is rendered"
    )
