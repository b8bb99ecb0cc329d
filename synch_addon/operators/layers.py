# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator: layers in the solid of the active object, or of the one whose layers it shows."""

import bpy
from bpy.props import StringProperty

from ...core.settings.layers import LayerSettings
from .. import api
from ..settings.rna import settings_of
from ..solids.links import solid_of
from ..solids.properties import LAYER_NAMES, LENGTHS, LayerProperties, stored_groups, stored_guidance
from ..solids.report import headline
from .field_operator import ObjectOperator


class SYNCH_OT_layers(ObjectOperator, LayerProperties, bpy.types.Operator):
    """Fill the closed mesh with evenly spaced layers that follow a direction and end flush with chosen surfaces"""

    bl_idname = "synch.layers"
    bl_label = "Layers"

    guidance: StringProperty(
        name="Guidance", description="What the layers follow, such as axis:Z or harmonic:Bottom:Top", default="axis:Z"
    )
    groups: StringProperty(
        name="Groups", description="Conditions on parts of the surface, such as Top=layer,Bottom=constant"
    )

    def _target(self, context):
        return solid_of(context.active_object) if self._work is None else super()._target(context)

    def _take(self, context):
        stored = self._target(context).synch_layering
        self.guidance, self.groups = stored_guidance(stored), stored_groups(stored)
        for name in LAYER_NAMES:
            if name in LENGTHS and getattr(stored, LENGTHS[name]):
                self.properties.property_unset(name)
            else:
                setattr(self, name, getattr(stored, name))

    def _job(self, context):
        lengths = {name: getattr(self, name) if self.properties.is_property_set(name) else None for name in LENGTHS}
        apart = {"guidance": self.guidance, "groups": self.groups, **lengths}
        return api.layer_job(self._target(context), settings_of(LayerSettings, self, LAYER_NAMES, **apart))

    def _announce(self, context, report):
        for name in LENGTHS:
            setattr(self, name, report["settings"][name])
        return super()._announce(context, report)

    def _headline(self, report):
        return headline(report)

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        for name in ("guidance", "groups", *LAYER_NAMES):
            column.prop(self, name)
