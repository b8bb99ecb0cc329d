# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the next strokes, kept with the scene."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty

from ..blender.registration import register_all

_WISHES = (
    ("ALONG", "Along", "Stripes run along the stroke"),
    ("ACROSS", "Across", "Stripes cross the stroke at a right angle"),
    ("PHASE", "Line Here", "A stripe, or a row of edges of a quad mesh, lies on the stroke"),
)


class SynchStrokes(bpy.types.PropertyGroup):
    """Settings of the next stroke."""

    wish: EnumProperty(name="Ask For", description="What the next stroke asks for", items=_WISHES)
    soft: BoolProperty(
        name="Soft", description="Let the pattern deviate from the next stroke, instead of meeting it exactly"
    )
    strength: FloatProperty(
        name="Strength",
        description="Strength of a soft stroke: at 1 it counts about as much as the rest of the surface",
        default=10.0,
        min=0.0,
        soft_max=100.0,
    )

    @property
    def weight(self):
        """Weight of the next stroke's constraint; None for one that is met exactly."""
        return self.strength if self.soft else None


register, unregister = register_all((SynchStrokes,), (bpy.types.Scene, "synch_strokes", SynchStrokes))
