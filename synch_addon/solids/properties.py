# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of layers as Blender properties: those that the panel stores and those of the operator."""

from functools import partial

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, StringProperty

from ...core.settings.guidance import BOUNDARY
from ...core.settings.layers import LAYER_GUIDES, LAYER_WISHES, Flush, LayerGuide, LayerSettings, text_of_groups
from ...core.settings.setting import records
from ..blender.registration import register_all
from ..settings.automatic import automatic_properties
from ..settings.guide_list import AXIS, VECTORS
from ..settings.rna import identifier_of, properties_of, property_of
from ..settings.suggestions import suggest_curves, suggest_groups, suggest_solid_origins
from .expected import expected_lengths

# Settings that panel and operator have as properties.
LAYER_NAMES = tuple(name for name, record in records(LayerSettings) if record.group)
# Lengths that may be automatic, and the properties that say so.
LENGTHS = {"spacing": "automatic_spacing", "size": "automatic_size"}
LayerProperties = properties_of(LayerSettings, LAYER_NAMES)


def given_lengths(stored):
    """Spacing and size that are set, None for automatic ones."""
    return {
        name: None if getattr(stored, is_automatic) else getattr(stored, name) for name, is_automatic in LENGTHS.items()
    }


def _shown(name):
    """The field of a length and its button, to mix into the settings."""

    def write(stored, number):
        setattr(stored, LENGTHS[name], number is None)
        if number is not None:
            setattr(stored, name, number)

    def expected(stored):
        lengths = expected_lengths(stored.id_data, **given_lengths(stored))
        return None if lengths is None else getattr(lengths, name)

    make = partial(property_of, LayerSettings, name, precision=3)  # the unit has to fit in
    return automatic_properties(f"shown_{name}", make, lambda stored: given_lengths(stored)[name], write, expected)


class SynchFlush(bpy.types.PropertyGroup):
    """A condition on the layers at a part of the surface."""

    group: StringProperty(
        name="Group", description="Vertex group, or the word boundary", default=BOUNDARY, search=suggest_groups
    )
    wish: EnumProperty(
        name="Wish",
        description="What the layers do there",
        items=[(identifier_of(wish.name), wish.label, wish.tip) for wish in LAYER_WISHES],
    )
    offset: FloatProperty(
        name="Offset",
        description="Height of the faces above the last layer, in layers: a half for beads that end at the faces",
        min=0.0,
        max=0.99,
        step=10,
    )


class SynchLayering(LayerProperties, _shown("spacing"), _shown("size"), bpy.types.PropertyGroup):
    """Settings of an object's layers, kept in the file; each kind of guide has names of its own."""

    guide: EnumProperty(
        name="Guidance",
        description="What the layers follow",
        items=[(identifier_of(kind), guide.label, guide.tip) for kind, guide in LAYER_GUIDES.items()],
    )
    axis: AXIS
    low: StringProperty(name="From", description="Vertex group where the layers begin", search=suggest_groups)
    high: StringProperty(name="To", description="Vertex group where the layers end", search=suggest_groups)
    origin: StringProperty(
        name="From",
        description="Vertex group, mesh object, or the word boundary",
        default=BOUNDARY,
        search=suggest_solid_origins,
    )
    curve: StringProperty(name="Curve", description="Curve or Grease Pencil object", search=suggest_curves)
    vectors: VECTORS
    file: StringProperty(
        name="File", description="A .vtu, or a .sol beside its .mesh, with vectors in the solid", subtype="FILE_PATH"
    )
    array: StringProperty(name="Array", description="Name of the array of vectors; empty for the only one")
    groups: CollectionProperty(name="Groups", description="Conditions on parts of the surface", type=SynchFlush)
    automatic_spacing: BoolProperty(
        name="Automatic Spacing",
        description="24 layers across the object, or up to forty where the resolution carries them",
        default=True,
    )
    automatic_size: BoolProperty(
        name="Automatic Size",
        description="About a hundred thousand tetrahedra, or more where the spacing needs them",
        default=True,
    )


# Properties with the names of each kind of guide, and those of them that may be empty.
GUIDE_NAMES = {identifier_of(kind): guide.names for kind, guide in LAYER_GUIDES.items()}
OPTIONAL_NAMES = {name for guide in LAYER_GUIDES.values() if guide.optional for name in guide.names[-guide.optional :]}


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


register, unregister = register_all((SynchFlush, SynchLayering), (bpy.types.Object, "synch_layering", SynchLayering))
