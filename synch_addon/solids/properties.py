# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of layers as Blender properties: those that the panel stores and those of the operator."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    StringProperty,
)

from ..blender.registration import keeping
from ..blender.strokes import SOURCE_TYPES
from ..settings.guidance import BOUNDARY
from ..settings.guide_list import AXIS, VECTORS
from ..settings.solver import BRANCHING, METHOD, ROUNDING, SEED, SPACING_MAP, SPACING_RANGE, TARGET_GAP
from .settings import Flush, LayerGuide, text_of_groups

_HEIGHT = {"min": 0.0, "precision": 4, "subtype": "DISTANCE"}
_LENGTH = {"subtype": "DISTANCE", "min": 1e-6, "soft_min": 1e-4, "precision": 4}
_KINDS = (
    ("axis", "Axis", "An axis of the object: flat layers"),
    ("harmonic", "Between Groups", "From one vertex group's faces to another's, along a harmonic function"),
    ("distance", "Away From", "Away from a vertex group's faces, from the whole surface, or from another mesh"),
    ("curve", "Along Curve", "Along a curve object: layers cross it"),
    ("around", "Around Curve", "Away from a curve object: layers lie around it like skins"),
    ("attribute", "Attribute", "A vector attribute on the vertices, extended into the solid"),
    ("file", "File", "Vectors in a solid, on points or cells of a .vtu or .sol file"),
    ("lines", "File of Lines", "The same for vectors of either sign, such as principal stresses"),
)
# Lengths that may be automatic, and the properties that say so.
LENGTHS = {"spacing": "automatic_spacing", "size": "automatic_size"}


def _suggest_groups(properties, context, text):
    return [*(group.name for group in properties.id_data.vertex_groups), BOUNDARY]


def _suggest_origins(properties, context, text):
    own = properties.id_data
    meshes = [obj.name for obj in context.scene.objects if obj.type == "MESH" and obj != own]
    return [*_suggest_groups(properties, context, text), *meshes]


def _suggest_curves(properties, context, text):
    own = properties.id_data
    return [obj.name for obj in context.scene.objects if obj.type in SOURCE_TYPES and obj != own]


class LayerProperties:
    """Shared by the panel's storage and the operator."""

    spacing: FloatProperty(
        name="Spacing",
        description="Distance from one layer to the next; the object's scale counts",
        default=0.1,
        **_LENGTH,
    )
    spacing_map: SPACING_MAP
    spacing_range: SPACING_RANGE
    branching: BRANCHING
    smallest_height: FloatProperty(
        name="Smallest Height",
        description="Of a layer: with limits they branch as little as keeps to these; 0 for none",
        **_HEIGHT,
    )
    largest_height: FloatProperty(
        name="Largest Height",
        description="Of a layer, above the smallest one; 0 for none",
        **_HEIGHT,
    )
    numbers: EnumProperty(
        name="Numbers",
        description="What counts as one layer: in the attribute, in files and where paths are ordered",
        items=[
            ("PIECES", "Of Pieces", "Each connected piece has a number of its own, from the bottom"),
            ("LEVELS", "Of Levels", "Pieces at one height have one number, each body's from its lowest layer on"),
        ],
    )
    size: FloatProperty(
        name="Resolution",
        description="Longest edge of the tetrahedra that fill the object, at most half the spacing",
        default=0.05,
        **_LENGTH,
    )
    method: METHOD
    rounding: ROUNDING
    seed: SEED
    target_gap: TARGET_GAP


class SynchFlush(bpy.types.PropertyGroup):
    """What is asked of the layers on a part of the surface."""

    group: StringProperty(
        name="Group", description="Vertex group, or the word boundary", default=BOUNDARY, search=_suggest_groups
    )
    wish: EnumProperty(
        name="Wish",
        description="What the layers do there",
        items=[
            ("LAYER", "Layer on It", "A layer lies exactly on these faces"),
            ("CONSTANT", "Parallel", "Layers run along each piece of these faces, at whichever distance"),
        ],
    )
    offset: FloatProperty(
        name="Offset",
        description="How far the faces lie above the last layer, in layers: a half for beads that end at them",
        min=0.0,
        max=0.99,
        step=10,
    )


class SynchLayering(LayerProperties, bpy.types.PropertyGroup):
    """Settings of an object's layers, kept in the file; each kind of guide has names of its own."""

    guide: EnumProperty(
        name="Guidance",
        description="What the layers follow",
        items=[(kind.upper(), label, tip) for kind, label, tip in _KINDS],
    )
    axis: AXIS
    low: StringProperty(name="From", description="Vertex group where the layers begin", search=_suggest_groups)
    high: StringProperty(name="To", description="Vertex group where the layers end", search=_suggest_groups)
    origin: StringProperty(
        name="From",
        description="Vertex group, mesh object, or the word boundary",
        default=BOUNDARY,
        search=_suggest_origins,
    )
    curve: StringProperty(name="Curve", description="Curve or Grease Pencil object", search=_suggest_curves)
    vectors: VECTORS
    file: StringProperty(
        name="File", description="A .vtu, or a .sol beside its .mesh, with vectors in the solid", subtype="FILE_PATH"
    )
    array: StringProperty(name="Array", description="Name of the array of vectors; empty for the only one")
    groups: CollectionProperty(name="Groups", description="What is asked of parts of the surface", type=SynchFlush)
    automatic_spacing: BoolProperty(
        name="Automatic Spacing", description="As many layers as the resolution carries, forty at most", default=True
    )
    automatic_size: BoolProperty(
        name="Automatic Resolution",
        description="About a hundred thousand tetrahedra, or more where the spacing needs them",
        default=True,
    )


# Properties with the names of each kind of guide.
GUIDE_NAMES = {
    "AXIS": ("axis",),
    "HARMONIC": ("low", "high"),
    "DISTANCE": ("origin",),
    "CURVE": ("curve",),
    "AROUND": ("curve",),
    "ATTRIBUTE": ("vectors",),
    "FILE": ("file", "array"),
    "LINES": ("file", "array"),
}
# Names that may be empty.
OPTIONAL_NAMES = ("array",)


def stored_guidance(stored):
    """The guidance as text, from an object's settings."""
    names = ((name, getattr(stored, name)) for name in GUIDE_NAMES[stored.guide])
    kept = tuple(value for name, value in names if value or name not in OPTIONAL_NAMES)
    return str(LayerGuide(stored.guide.lower(), kept))


def stored_groups(stored):
    """The groups as text, from an object's settings."""
    return text_of_groups(
        [Flush(row.group, row.wish.lower(), row.offset * (row.wish == "LAYER")) for row in stored.groups if row.group]
    )


register, unregister = keeping((SynchFlush, SynchLayering), (bpy.types.Object, "synch_layering", SynchLayering))
