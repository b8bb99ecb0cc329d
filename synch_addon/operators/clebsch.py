# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator: vortices of a volume, of a file, or of curves that stand for filaments."""

import bpy
from bpy.props import EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty

from ...core.errors import SynchError
from ..clebsch import clebsch
from ..strokes import SOURCE_TYPES
from ..surface_flows import VELOCITY
from .field_operator import progress_of


class SYNCH_OT_clebsch(bpy.types.Operator):
    """Show the vortices of the active volume or mesh, of a file, or of the flow that the selected curves induce"""

    bl_idname = "synch.clebsch"
    bl_label = "Vortices"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(
        name="File", description="OpenVDB or NumPy file with a velocity; empty for the objects", subtype="FILE_PATH"
    )
    attribute: StringProperty(
        name="Attribute",
        description="Velocity on the vertices of the active mesh, which then shows the map itself",
        default=VELOCITY,
    )
    show: EnumProperty(
        name="Show",
        description="How vortices are shown",
        items=[
            ("FILAMENTS", "Filaments", "Curves that carry the same circulation each"),
            ("TUBES", "Tubes", "Surfaces around the vorticity, coloured by the map to the sphere"),
        ],
    )
    resolution: IntProperty(
        name="Resolution", description="Nodes of the grid along its longest side", default=48, min=8, soft_max=128
    )
    count: FloatProperty(
        name="Filaments", description="So many through the plane with most vorticity", default=4.0, min=0.1, soft_max=32
    )
    opening: FloatProperty(
        name="Width", description="How much of the sphere is inside a tube, degrees", default=60.0, min=1.0, max=179.0
    )
    point: FloatVectorProperty(
        name="Seen From",
        description="Point of the sphere that decides which of the possible tubes are shown",
        subtype="DIRECTION",
        default=(0.0, 0.0, 1.0),
    )
    smoothing: IntProperty(name="Smoothing", description="Of filaments", default=2, min=0, soft_max=20)

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("leave the present mode: vortices are made in object mode")
            return False
        return True

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        names = ("filepath", "attribute", "show", "resolution", "count")
        for name in names + (("opening", "point") if self.show == "TUBES" else ("smoothing",)):
            column.prop(self, name)

    def execute(self, context):
        manager = context.window_manager
        manager.progress_begin(0, 1)
        try:
            report = clebsch(
                self._source(context),
                progress_of(manager),
                attribute=self.attribute,
                show=self.show.lower(),
                resolution=self.resolution,
                count=self.count,
                opening=self.opening,
                point=tuple(self.point) if self.show == "TUBES" else None,
                smoothing=self.smoothing,
            )
        except SynchError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            manager.progress_end()
        self.report({"INFO"}, f"{report['object']}: energy {report['energy']:.4g}, {report['status']}")
        return {"FINISHED"}

    def _source(self, context):
        if self.filepath:
            return bpy.path.abspath(self.filepath)
        active = context.active_object
        if active is not None and active.type == "VOLUME":
            return active
        chosen = [obj for obj in context.selected_objects if obj.type in SOURCE_TYPES]
        if not chosen:
            raise SynchError("nothing has a flow: choose a file, a volume, a mesh, or curves that stand for filaments")
        return chosen


CLASSES = (SYNCH_OT_clebsch,)
