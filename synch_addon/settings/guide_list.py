# SPDX-License-Identifier: GPL-3.0-or-later
"""Guides as Blender properties, which an object keeps in the file."""

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty

from ..blender.strokes import SOURCE_TYPES
from .guidance import AXES, BOUNDARY, Source

# (kind, label, tip, the property that holds its name or None)
_KINDS = (
    ("curvature-max", "Largest Curvature", "Across ridges: where the surface bends most", None),
    ("curvature-min", "Smallest Curvature", "Along ridges: where the surface bends least", None),
    ("gradient", "Gradient", "Where a float attribute or vertex group grows", "numbers"),
    ("contour", "Contour", "Along the lines on which a float attribute or vertex group is constant", "numbers"),
    ("distance", "Away From", "Away from a vertex group, a curve or the boundary, on the shortest way", "origin"),
    ("offset", "Around", "Along the lines of equal distance from a vertex group, a curve or the boundary", "origin"),
    ("axis", "Axis", "An axis of the object, projected to the surface", "axis"),
    ("uv-u", "UV U", "Where the first coordinate of a UV map grows", "uv_map"),
    ("uv-v", "UV V", "Where the second coordinate of a UV map grows", "uv_map"),
    ("attribute", "Attribute", "A vector attribute on the vertices, projected to the surface", "vectors"),
    ("file", "File", "A field file of another program: .rawfield or .rosy", "path"),
)
_PLAIN_KINDS = {kind.upper().replace("-", "_"): kind for kind, *_ in _KINDS}
# The property with a guide's name, for each kind of guide that has one.
NAME_PROPERTIES = {kind.upper().replace("-", "_"): prop for kind, _, _, prop in _KINDS if prop}
GUIDE_ITEMS = [(kind.upper().replace("-", "_"), label, tip) for kind, label, tip, _ in _KINDS]


def _point_attributes(obj, data_type):
    """Names of an object's attributes of a type on the vertices."""
    return [a.name for a in obj.data.attributes if (a.domain, a.data_type) == ("POINT", data_type) and a.name[0] != "."]


def suggest_numbers(properties, context, text):
    """Float attributes and vertex groups of the active object, for the search of a property."""
    obj = context.active_object
    return [*_point_attributes(obj, "FLOAT"), *(group.name for group in obj.vertex_groups)]


def suggest_vectors(properties, context, text):
    """Vector attributes of the active object, for the search of a property."""
    return [name for name in _point_attributes(context.active_object, "FLOAT_VECTOR") if name != "position"]


def _suggest_origins(properties, context, text):
    obj = context.active_object
    sources = [other.name for other in context.scene.objects if other.type in SOURCE_TYPES and other != obj]
    return [*(group.name for group in obj.vertex_groups), BOUNDARY, *sources]


def _suggest_uv_maps(properties, context, text):
    return [layer.name for layer in context.active_object.data.uv_layers]


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
        search=_suggest_origins,
    )
    axis: AXIS
    uv_map: StringProperty(name="UV Map", description="Empty for the active UV map", search=_suggest_uv_maps)
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
        return Source(_PLAIN_KINDS[kind], name, strength)


def stored_guidance(stored):
    """The guidance as text, from an object's settings.

    Raises
    ------
    SettingError
        when a guide lacks its name
    """
    if stored.guidance == "SMOOTH":
        return "smooth"
    if stored.guidance == "BLEND":
        return ",".join(str(guide.source(guide.kind, guide.strength)) for guide in stored.guides) or "smooth"
    exact = stored.guidance == "ATTRIBUTE"
    return str(stored.guide.source(stored.guidance, None if exact else stored.guide.strength))


register, unregister = bpy.utils.register_classes_factory((SynchGuide,))
