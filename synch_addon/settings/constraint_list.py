# SPDX-License-Identifier: GPL-3.0-or-later
"""The constraint list as Blender properties, which an object keeps in the file."""

import math

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, PointerProperty, StringProperty

from ...core.settings.constraints import PLACES, WISHES, Constraint, wishes_at
from ..blender.registration import register_all
from ..blender.strokes import SOURCE_TYPES
from ..blender.translations import OURS
from .rna import identifier_of
from .suggestions import suggest_numbers, suggest_vectors

_ANGLE = {"subtype": "ANGLE", "soft_min": -math.pi, "soft_max": math.pi}

_PLACES = [
    (identifier_of(place.name), place.label, place.tip, place.icon, number) for number, place in enumerate(PLACES)
]
_WISHES = [(identifier_of(wish.name), wish.label, wish.tip) for wish in WISHES]


def _keep_possible(row, context):
    """After another place was chosen."""
    if row.what not in row.possible:
        row.what = "ALONG"


def _is_source(row, candidate):
    return candidate.type in SOURCE_TYPES and candidate != row.id_data


def _suggest_attributes(row, context, text):
    suggest = suggest_numbers if row.what == "PHASE" else suggest_vectors
    return suggest(row, context, text)


class SynchConstraint(bpy.types.PropertyGroup):
    """One row of the constraint list, kept in the file."""

    where: EnumProperty(
        name="Where",
        description="Where something is asked for",
        translation_context=OURS,
        items=_PLACES,
        update=_keep_possible,
    )
    what: EnumProperty(name="Ask For", description="What is asked for there", items=_WISHES)
    vertex_group: StringProperty(name="Vertex Group", description="Vertices with a weight above zero")
    curve: PointerProperty(
        name="Curve",
        description="A curve, a Grease Pencil object, or a mesh of edges",
        type=bpy.types.Object,
        poll=_is_source,
    )
    attribute: StringProperty(
        name="Attribute",
        description="Vector attribute on the vertices; for phases a float attribute, in radians, or a vertex group",
        search=_suggest_attributes,
    )
    angle: FloatProperty(name="Angle", description="Angle from the line, counterclockwise seen from outside", **_ANGLE)
    phase: FloatProperty(
        name="Phase",
        description="0° is the middle of a stripe, 180° the middle of a gap; it grows to the left of the line",
        **_ANGLE,
    )
    soft: BoolProperty(
        name="Soft", description="Let the pattern deviate from this constraint, instead of meeting it exactly"
    )
    weight: FloatProperty(
        name="Weight",
        description="Strength of the constraint: at 1 it counts about as much as the rest of the surface",
        default=1.0,
        min=0.0,
        soft_max=100.0,
    )
    enabled: BoolProperty(name="Enabled", description="Use this row", default=True)

    @property
    def possible(self):
        """Conditions that the place of the row allows."""
        return [what.upper() for what in wishes_at(self.where.lower())]

    @property
    def is_incomplete(self):
        """Whether the row lacks the vertex group, curve or attribute that it needs."""
        return self.where in {"GROUP", "CURVE", "ATTRIBUTE"} and not self.place_name

    @property
    def has_weight(self):
        """Whether the row may be soft."""
        return self.what not in {"CUT", "CONSTANT"}

    @property
    def place_name(self):
        """Name of the vertex group, curve object or attribute; "" where the place has none."""
        if self.where == "CURVE":
            # The row alone would keep a curve that was deleted.
            return self.curve.name if self.curve and self.curve.users_scene else ""
        if self.where in {"BOUNDARY", "GROUP"}:
            return self.vertex_group
        return self.attribute if self.where == "ATTRIBUTE" else ""


def stored_constraints(obj):
    """The enabled rows of an object's list.

    Returns tuple of Constraint; empty where the extension is not registered, so that objects keep no list. Raises
    SettingError when a row lacks its vertex group, curve or attribute, or asks for what is impossible there.
    """
    return tuple(_plain(row) for row in obj.synch.constraints if row.enabled) if hasattr(obj, "synch") else ()


def _plain(row):
    radians = {"ANGLE": row.angle, "PHASE": row.phase}.get(row.what, 0.0)
    return Constraint(
        where=row.where.lower(),
        what=row.what.lower(),
        name=row.place_name,
        degrees=round(math.degrees(radians), 4),  # Blender keeps radians in single precision
        weight=row.weight if row.soft and row.has_weight else None,
    )


register, unregister = register_all((SynchConstraint,))
