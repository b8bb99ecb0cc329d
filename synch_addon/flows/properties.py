# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of vortices as Blender properties: what is solved, kept by the scene, and what is seen, kept by objects."""

import math

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    StringProperty,
)

from ...core.errors import SynchError
from ...core.extract.tubes import NORTH
from ...core.files.json_text import kept, kept_names
from ...core.tasks.flow_settings import ClebschSettings
from ..blender.registration import keeping
from ..settings.solver import METHOD, ROUNDING, SEED, TARGET_GAP, settings_of
from . import memory
from .choice import slide
from .report import VALUES

_DEFAULT = ClebschSettings()
_OPENING = {
    "name": "Width",
    "description": "How much of the sphere is inside a tube, degrees around the chosen point's antipode",
    "default": _DEFAULT.opening,
    "min": 1.0,
    "max": 179.0,
}
_SMOOTHING = {
    "name": "Smoothing",
    "description": "How often points of filaments and tubes move to the middle of their neighbours",
    "default": _DEFAULT.smoothing,
    "min": 0,
    "soft_max": 20,
}


class VortexProperties:
    """What is solved, shared by the panel's storage and the operator."""

    filepath: StringProperty(
        name="File",
        description="OpenVDB or NumPy file with a velocity, #### for frame numbers; empty for the chosen objects",
        subtype="FILE_PATH",
    )
    attribute: StringProperty(
        name="Attribute",
        description="Velocity on the vertices of the chosen mesh, which then shows the map itself, or grid of a volume",
        default=_DEFAULT.attribute,
    )
    show: EnumProperty(
        name="Show",
        description="How vortices are shown",
        items=[
            ("FILAMENTS", "Filaments", "Curves that carry the same circulation each"),
            ("TUBES", "Tubes", "Surfaces around the vorticity, coloured by the map; by the method Semidefinite"),
            ("BOTH", "Both", "Filaments and tubes, of one solve"),
        ],
    )
    resolution: IntProperty(
        name="Resolution",
        description="Nodes of the grid along its longest side; a NumPy file has a grid of its own",
        default=_DEFAULT.resolution,
        min=8,
        soft_max=128,
    )
    by: EnumProperty(
        name="Quantum",
        description="How the circulation of one filament is chosen",
        items=[
            ("COUNT", "Filaments", "So many pass the plane with most vorticity"),
            ("CIRCULATION", "Circulation", "It is given"),
        ],
    )
    count: FloatProperty(
        name="Filaments",
        description="So many through the plane with most vorticity",
        default=_DEFAULT.count,
        min=0.1,
        soft_max=32,
    )
    quantum: FloatProperty(
        name="Circulation",
        description="Of one filament, in the units of the velocity times length",
        default=1.0,
        min=1e-6,
        soft_max=100,
        precision=4,
    )
    core: FloatProperty(
        name="Core",
        description="Radius over which the vorticity of curves is spread, in cells; "
        "0 for half a cell, and two where tubes are shown",
        min=0.0,
        soft_max=6.0,
    )
    opening: FloatProperty(**_OPENING)
    smoothing: IntProperty(**_SMOOTHING)
    unwrapped: BoolProperty(
        name="Unwrapped",
        description="Draw filaments in one piece where they leave a periodic box, instead of in parts that lie in it",
    )
    method: METHOD
    rounding: ROUNDING
    seed: SEED
    target_gap: TARGET_GAP
    use_frames: BoolProperty(
        name="Frames", description="Solve a range of frames, each from the one before: one object a frame"
    )
    frame_start: IntProperty(name="First Frame", description="Of the range", default=1)
    frame_end: IntProperty(name="Last Frame", description="Of the range", default=24)


def plain(properties):
    """:class:`ClebschSettings` from an operator's properties."""
    apart = {
        "quantum": properties.quantum if properties.by == "CIRCULATION" else None,
        "core": properties.core or None,
        "frames": (properties.frame_start, properties.frame_end) if properties.use_frames else None,
    }
    return settings_of(ClebschSettings, properties, VortexProperties, **apart)


class SynchVortices(VortexProperties, bpy.types.PropertyGroup):
    """Settings of vortices, kept in the file."""


def _show(look, _context):
    """The objects of the solve show what the sliders of one of them are set to."""
    obj = look.id_data
    if look.result and memory.flows.holds(obj):
        slide(obj)


class SynchVortexLook(bpy.types.PropertyGroup):
    """What an object shows of its solve, and what was found; a slider shows it at once, without a solve."""

    point: FloatVectorProperty(
        name="Point",
        description="Point of the sphere: filaments are where the map shows its antipode, tubes around that",
        subtype="DIRECTION",
        default=NORTH,
        update=_show,
    )
    opening: FloatProperty(**_OPENING, update=_show)
    smoothing: IntProperty(**_SMOOTHING, update=_show)
    result: StringProperty(name="Result", description="What the panel shows of the solve, as JSON")
    sources: StringProperty(name="Sources", description="Names of the objects that the flow was read from, as JSON")

    @property
    def source_objects(self):
        """The objects that the flow was read from, as far as they are still there."""
        try:
            names = kept_names(self.sources, f"what {self.id_data.name} keeps")
        except SynchError:
            names = []
        return [bpy.data.objects[name] for name in names if name in bpy.data.objects]

    @property
    def place(self):
        """Latitude and longitude of the point in degrees."""
        x, y, z = self.point
        return math.degrees(math.asin(max(-1.0, min(1.0, z)))), math.degrees(math.atan2(y, x))

    @property
    def figures(self):
        """What was found, {} where nothing was, or where it cannot be read."""
        try:
            return kept(self.result, f"what {self.id_data.name} keeps", VALUES)
        except SynchError:
            return {}


register, unregister = keeping(
    (SynchVortices, SynchVortexLook),
    (bpy.types.Scene, "synch_vortices", SynchVortices),
    (bpy.types.Object, "synch_vortices", SynchVortexLook),
)
