# SPDX-License-Identifier: GPL-3.0-or-later
"""Guides as Blender properties, which an object keeps in the file."""

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty

from ...core.settings.guidance import AUTOMATIC, AXES, BOUNDARY, GUIDES, SMOOTH, Source, parse_guidance
from ..blender.registration import register_all
from .rna import identifier_of
from .suggestions import suggest_numbers, suggest_origins, suggest_uv_maps, suggest_vectors

_KINDS = {identifier_of(kind): kind for kind in GUIDES}
# The property with a guide's name, for each kind of guide that has one.
NAME_PROPERTIES = {identifier_of(kind): guide.names for kind, guide in GUIDES.items() if guide.names}
GUIDE_ITEMS = [(identifier_of(kind), guide.label, guide.tip) for kind, guide in GUIDES.items()]
# Values of an object's guidance without a guide.
UNGUIDED = AUTOMATIC.upper(), SMOOTH.upper()
# Files keep the numbers of values, so these stay: guides that are added to the end of GUIDES are numbered after BLEND.
_AUTOMATIC, _SMOOTH, _BLEND = 100, 0, 12
GUIDANCE = EnumProperty(
    name="Guidance",
    description="What the directions follow",
    items=[
        (AUTOMATIC.upper(), "Automatic", "Quad meshes follow curvature, others turn least", "NONE", _AUTOMATIC),
        (SMOOTH.upper(), "Smoothest", "The field that turns least over the surface", "NONE", _SMOOTH),
        *((*item, "NONE", number + (number >= _BLEND)) for number, item in enumerate(GUIDE_ITEMS, 1)),
        ("BLEND", "Blend", "Several guides, each with a strength", "NONE", _BLEND),
    ],
    default=AUTOMATIC.upper(),
)

AXIS = EnumProperty(
    name="Axis",
    description="Axis of the object",
    items=[(axis, axis, f"The object's {axis} axis") for axis in AXES],
    default="Z",
)
VECTORS = StringProperty(name="Attribute", description="Vector attribute on the vertices", search=suggest_vectors)


class SynchGuide(bpy.types.PropertyGroup):
    """One source of guidance; each kind has a name of its own, so that trying another forgets nothing."""

    kind: EnumProperty(name="Guide", description="What the directions follow", items=GUIDE_ITEMS)
    numbers: StringProperty(
        name="Values", description="Float attribute or vertex group on the vertices", search=suggest_numbers
    )
    origin: StringProperty(
        name="From",
        description="Vertex group, curve object, or the word boundary",
        default=BOUNDARY,
        search=suggest_origins,
    )
    axis: AXIS
    uv_map: StringProperty(name="UV Map", description="Empty for the active UV map", search=suggest_uv_maps)
    vectors: VECTORS
    path: StringProperty(name="File", description="A .rawfield or .rosy file of this mesh", subtype="FILE_PATH")
    strength: FloatProperty(
        name="Strength",
        description="How strongly the directions follow, against smoothness and other guides",
        default=1.0,
        min=0.0,
        soft_max=10.0,
    )

    def source(self, kind, strength):
        """The plain source of a kind, with this guide's name for it."""
        name = getattr(self, NAME_PROPERTIES[kind]) if kind in NAME_PROPERTIES else ""
        return Source(_KINDS[kind], name, strength)

    def take(self, source):
        """Become a plain source; returns the identifier of its kind."""
        self.kind = identifier_of(source.kind)
        if self.kind in NAME_PROPERTIES:
            setattr(self, NAME_PROPERTIES[self.kind], source.name)
        self.strength = 1.0 if source.strength is None else source.strength
        return self.kind


def stored_guidance(stored):
    """The guidance as text, from an object's settings. Raises SettingError when a guide lacks its name."""
    if stored.guidance in UNGUIDED:
        return stored.guidance.lower()
    if stored.guidance == "BLEND":
        return ",".join(str(guide.source(guide.kind, guide.strength)) for guide in stored.guides) or SMOOTH
    exact = stored.guidance == "ATTRIBUTE"
    return str(stored.guide.source(stored.guidance, None if exact else stored.guide.strength))


def store_guidance(stored, text):
    """Give an object's settings the guidance of a text, the inverse of :func:`stored_guidance`."""
    sources = parse_guidance(text)
    if not sources:
        stored.guidance = text.strip().upper()
    elif len(sources) == 1 and (sources[0].kind != "attribute" or sources[0].strength is None):
        stored.guidance = stored.guide.take(sources[0])
    else:
        stored.guidance = "BLEND"
        stored.guides.clear()
        for source in sources:
            stored.guides.add().take(source)


register, unregister = register_all((SynchGuide,))
