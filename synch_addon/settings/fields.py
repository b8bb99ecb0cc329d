# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of directions, stripes, quads and quad meshes as Blender properties, which an object keeps in the file."""

from types import SimpleNamespace

import bpy
from bpy.props import BoolProperty, BoolVectorProperty, CollectionProperty, IntProperty, PointerProperty, StringProperty

from ...core.settings.setting import records
from ...core.settings.surface import SurfaceSettings
from ..blender.registration import register_all
from ..blender.translations import OURS
from .constraint_list import SynchConstraint
from .favourite_list import SynchFavourite
from .guide_list import GUIDANCE, SynchGuide, stored_guidance
from .rna import properties_of, property_of, settings_of, values_of

RECORDS = dict(records(SurfaceSettings))
# Settings that panel and operators have as properties, and those of them that quad meshes have apart.
PROPERTY_NAMES = tuple(name for name, record in RECORDS.items() if record.group and name != "guidance")
MESH_NAMES = {name: f"mesh_{name}" for name, record in RECORDS.items() if "quad_mesh" in record.variants}
# Settings that a quad mesh takes from its source, besides the guidance.
DIRECTED_NAMES = ("angle", "angle_attribute", "angle_range", "boundary", "vertex_group")
# Name and tooltip of the stored property, and of the one in the simple panel.
AUTOMATIC_SPACING = dict(
    name="Automatic Spacing", description="About forty stripes across the object, or as many as the mesh can carry"
)
# What an object has of its own besides.
STORED_NAMES = (*PROPERTY_NAMES, "automatic_spacing", *MESH_NAMES.values())

SettingProperties = properties_of(
    SurfaceSettings,
    PROPERTY_NAMES,
    boundary=property_of(SurfaceSettings, "boundary", translation_context=OURS),
    mirror=BoolVectorProperty(name=RECORDS["mirror"].label, description=RECORDS["mirror"].tip, size=3),
)
MeshProperties = properties_of(
    SurfaceSettings, (), **{name: property_of(SurfaceSettings, name, "quad_mesh") for name in MESH_NAMES}
)
_StoredMeshProperties = properties_of(
    SurfaceSettings,
    (),
    **{stored: property_of(SurfaceSettings, name, "quad_mesh") for name, stored in MESH_NAMES.items()},
)


class SynchSettings(SettingProperties, _StoredMeshProperties, bpy.types.PropertyGroup):
    """Settings of an object, kept in the file."""

    guidance: GUIDANCE
    guide: PointerProperty(name="Guide", description="The only guide", type=SynchGuide)
    guides: CollectionProperty(name="Guides", description="The guides of a blend", type=SynchGuide)
    automatic_spacing: BoolProperty(
        **AUTOMATIC_SPACING,
        default=True,
    )
    constraints: CollectionProperty(
        name="Constraints", description="Conditions on the pattern along lines of the mesh", type=SynchConstraint
    )
    pins: StringProperty(name=RECORDS["pins"].label, description=RECORDS["pins"].tip)
    active_constraint: IntProperty(name="Active Constraint", description="Row that the panel shows", min=0)
    favourites: CollectionProperty(name="Favourites", description="Variations that are kept", type=SynchFavourite)
    source: PointerProperty(
        name="Source", description="The object that this quad mesh was made of", type=bpy.types.Object
    )
    made_along: StringProperty(name="Made Along", description="Guidance that this quad mesh was made with")
    made_from: StringProperty(name="Made From", description="Hash of the mesh that this quad mesh was made of")
    result: StringProperty(name="Result", description="What the panel shows of the last solve, as JSON")


def source_of(obj):
    """The object of the scene that a quad mesh was made of; None without one, and if the panel is set to make something
    other than quad meshes."""
    source = obj.synch.source if obj.synch_simple.kind == "quad_mesh" else None
    return source if source is not None and bpy.context.scene in source.users_scene else None


def original_of(obj):
    """The object whose directions are used: the source of a quad mesh, otherwise the object itself."""
    return source_of(obj) or obj


def stored_settings(obj):
    """The :class:`SurfaceSettings` that the panel keeps for an object; errors as :func:`stored_guidance`."""
    stored, directed = obj.synch, original_of(obj).synch
    values = stored
    if directed != stored:
        values = SimpleNamespace(**{name: getattr(stored, MESH_NAMES.get(name, name)) for name in PROPERTY_NAMES})
        vars(values).update({name: getattr(directed, name) for name in DIRECTED_NAMES})
    return plain(values, None if stored.automatic_spacing else stored.spacing, stored_guidance(directed))


def plain(properties, spacing, guidance=None):
    """:class:`SurfaceSettings` from an operator's properties, with the spacing given apart (None: automatic), or from
    an object's, whose guidance is given as text."""
    mirror = "".join(axis for axis, chosen in zip("XYZ", properties.mirror, strict=True) if chosen)
    guidance = properties.guidance if guidance is None else guidance
    apart = {"guidance": guidance, "spacing": spacing, "mirror": mirror}
    return settings_of(SurfaceSettings, properties, PROPERTY_NAMES, **apart)


def mesh_values(settings, spacing):
    """Properties of a quad mesh, by name: those of the :class:`SurfaceSettings` that it was made with, and its
    spacing."""
    names = [name for name in PROPERTY_NAMES if "quad_mesh" in RECORDS[name].commands]
    values = values_of(settings, [name for name in names if name not in ("spacing", "mirror")])
    values = {MESH_NAMES.get(name, name): value for name, value in values.items()}
    values |= {"mirror": [axis in settings.mirror for axis in "XYZ"], "made_along": settings.guidance}
    return values | {"spacing": spacing, "automatic_spacing": settings.spacing is None}


register, unregister = register_all((SynchSettings,), (bpy.types.Object, "synch", SynchSettings))
