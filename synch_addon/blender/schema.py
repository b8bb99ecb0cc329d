# SPDX-License-Identifier: GPL-3.0-or-later
"""Every attribute that the program writes to a mesh: its name, domain, type and meaning, in one place."""

import re
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

# Blender's names for an attribute type: numpy type, width, name in foreach_set.
TYPES = {
    "FLOAT": (np.float32, 1, "value"),
    "INT": (np.int32, 1, "value"),
    "BOOLEAN": (bool, 1, "value"),
    "INT32_2D": (np.int32, 2, "value"),
    "FLOAT_VECTOR": (np.float32, 3, "vector"),
    "FLOAT2": (np.float32, 2, "vector"),
    "FLOAT4": (np.float32, 4, "vector"),  # not in Blender 4.5
    "FLOAT_COLOR": (np.float32, 4, "color"),
    "BYTE_COLOR": (np.float32, 4, "color"),
    "INT8": (np.int8, 1, "value"),
    "INT16_2D": (np.int16, 2, "value"),
    "QUATERNION": (np.float32, 4, "value"),
    "FLOAT4X4": (np.float32, 16, "value"),
}
PREFIX = "synch_"
# The version of what these mean together, raised where that changes: a custom property of each mesh that has one of
# them, and in what an object keeps of its last solve. Without the property, it is the first version.
FORMAT, STAMP = 1, "synch_format"
FAVOURITE = re.compile(rf"{PREFIX}favourite_(\d+)_")


@dataclass(frozen=True)
class Attribute:
    """An attribute of a mesh: as wide as its type in :data:`TYPES`, a value for each element of its domain."""

    name: str
    domain: str
    data_type: str
    meaning: str

    @property
    def layout(self):
        """Domain and type."""
        return self.domain, self.data_type

    def in_favourite(self, number):
        """The attribute in which a favourite keeps this one."""
        own = self.name.removeprefix(PREFIX).removeprefix("vertex_")
        return replace(self, name=f"{PREFIX}favourite_{number}_{own}")


class Phase(NamedTuple):
    """The attributes of one phase of a pattern; a second index or a disclination that no face has is absent."""

    phase: Attribute
    index: Attribute
    index_2: Attribute
    disclination: Attribute
    vertex_phase: Attribute


_PHASE = Phase(
    Attribute("synch_phase{}", "CORNER", "FLOAT", "phase α in radians"),
    Attribute("synch_index{}", "FACE", "INT", "dislocation number of the face, of a quad's first triangle"),
    Attribute("synch_index{}_2", "FACE", "INT", "dislocation number of a quad's second triangle"),
    Attribute("synch_disclination{}", "FACE", "FLOAT_COLOR", "rim values around a disclination, less the centre's"),
    Attribute("synch_vertex_phase{}", "POINT", "FLOAT", "α at the vertex, in the sheet of its `synch_direction`"),
)
PHASES = {
    kind: tuple(Phase(*(replace(a, name=a.name.format(suffix)) for a in _PHASE)) for suffix in suffixes)
    for kind, suffixes in {"stripes": ("",), "quads": ("_x", "_y")}.items()
}
DIRECTION = Attribute("synch_direction", "POINT", "FLOAT_VECTOR", "unit direction in object space, along the stripes")
SINGULARITY = Attribute("synch_singularity", "FACE", "FLOAT", "disclination index k/2 (k/4 for crosses)")
_PLACE = "place inside singular faces, zero elsewhere: corner weights of a triangle; (s, t, −1) of a quad"
BARYCENTRIC = Attribute("synch_barycentric", "CORNER", "FLOAT_VECTOR", _PLACE)
PATTERN = Attribute("synch_pattern", "POINT", "FLOAT", "cos α, for quads cos α_x · cos α_y, for quick use")
_BACK = "quads: rim value of each phase at the end of the walk around a disclination, back at the first corner"
CLOSING = Attribute("synch_closing", "FACE", "FLOAT2", _BACK)
_SLOTS = "stripes, after Number Stripes: number of the stripe in each slot (period of the phase modulo 3); negative "
_SLOTS += "where the phase grows to the right of the direction along"
_ERROR = "spacing of the lines over the wanted one, minus 1; of quads for the phase that is further off; 0 at defects"
SPACING_ERROR = Attribute("synch_spacing_error", "FACE", "FLOAT", _ERROR)
NUMBER = Attribute("synch_number", "FACE", "FLOAT_VECTOR", _SLOTS)
ALONG = Attribute(
    "synch_along", "CORNER", "FLOAT_VECTOR", "likewise: distance along the stripe of each slot, in spacings"
)
LAYER = Attribute("synch_layer", "FACE", "INT", "layers: number of the layer, from the bottom")
SPHERE = Attribute("synch_sphere", "POINT", "FLOAT_VECTOR", "tubes and flows on a surface: point of the sphere there")
COLOR = Attribute("synch_color", "POINT", "FLOAT_COLOR", "the same point as a colour")
STRENGTH = Attribute("synch_strength", "FACE", "FLOAT", "flows on a surface: circulation of the vortices in the face")
_PARENT = "pattern's own surface: {} of the three vertices of the object that the place lies between"
PARENTS = tuple(
    Attribute(f"synch_parent_{number}", "POINT", "INT", _PARENT.format(which))
    for number, which in enumerate(("first", "second", "third"), start=1)
)
SOURCE_FACE = Attribute("synch_source_face", "FACE", "INT", "likewise: face of the object that a face is part of")
WEIGHTS = Attribute("synch_weights", "POINT", "FLOAT_VECTOR", "likewise: weights of these vertices, which add up to 1")

MAPPED = Attribute(
    "synch_spacing_map", "POINT", "FLOAT", "quad mesh: weights of its spacing map, before it is painted on"
)

# The attributes of each kind of pattern; those that determine it, which a favourite keeps; and those that each frame of
# an animation stores, since places are the same in all frames.
PATTERNS = {
    kind: (*sum(phases, ()), *[CLOSING] * (len(phases) - 1), BARYCENTRIC, PATTERN, SPACING_ERROR)
    for kind, phases in PHASES.items()
}
KEPT = {kind: (DIRECTION, *(phase.vertex_phase for phase in phases)) for kind, phases in PHASES.items()}
FRAMED = {
    kind: (*(a for a in own if a not in (BARYCENTRIC, SPACING_ERROR, *KEPT[kind])), DIRECTION)
    for kind, own in PATTERNS.items()
}
_OTHERS = SINGULARITY, NUMBER, ALONG, LAYER, SPHERE, COLOR, STRENGTH, *PARENTS, WEIGHTS, SOURCE_FACE, MAPPED
ATTRIBUTES = tuple(dict.fromkeys((DIRECTION, *PATTERNS["stripes"], *PATTERNS["quads"], *_OTHERS)))
_NUMBERS = re.compile(rf"(?<=\.)-?\d+$|(?<={PREFIX}favourite_)\d+")
_LAYOUTS = {a.name: a.layout for a in ATTRIBUTES}
_LAYOUTS |= {f"{a.name}.0": a.layout for own in FRAMED.values() for a in own}
_LAYOUTS |= {a.in_favourite(0).name: a.layout for own in KEPT.values() for a in own}


def layout_of(name):
    """Domain and type of an attribute of ours, also of a frame or a favourite, by its name; None for another one."""
    return _LAYOUTS.get(_NUMBERS.sub("0", name))
