# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of vortices as Blender properties: those of the solve belong to the scene, those of the look to objects."""

import math
from functools import partial

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatVectorProperty, IntProperty, StringProperty

from ...core.errors import SynchError
from ...core.extract.vortices.tubes import NORTH
from ...core.files.json_text import read_kept_dict, read_kept_names
from ...core.settings.flow import FlowSettings, automatic_core
from ..blender.registration import register_all
from ..settings.automatic import automatic_properties
from ..settings.rna import properties_of, property_of, settings_of
from . import memory
from .choice import slide
from .report import VALUES

# Settings that panel and operator have as properties of their own names.
FLOW_NAMES = (
    *("show", "resolution", "share", "count", "quantum", "core", "attribute", "opening", "smoothing", "unwrapped"),
    *("method", "rounding", "seed", "target_gap"),
)
VortexProperties = properties_of(
    FlowSettings,
    FLOW_NAMES,
    core=property_of(FlowSettings, "core", min=0.0),
    filepath=StringProperty(
        name="File",
        description="OpenVDB, NumPy, VTK, NetCDF or HDF5 file with a velocity, #### for frame numbers; "
        "empty for the chosen objects",
        subtype="FILE_PATH",
    ),
    by=EnumProperty(
        name="Quantum",
        description="How the circulation of one filament is chosen",
        items=[
            ("COUNT", "Filaments", "So many pass the plane with most vorticity"),
            ("CIRCULATION", "Circulation", "It is given"),
            ("SHARE", "Vorticity Carried", "The filaments carry a share of the vorticity"),
        ],
        default="SHARE",
    ),
    use_frames=BoolProperty(
        name="Frames", description="Solve a range of frames, each from the one before: one object a frame"
    ),
    frame_start=IntProperty(name="First Frame", description="Of the range", default=1),
    frame_end=IntProperty(name="Last Frame", description="Of the range", default=24),
)


def plain(properties):
    """:class:`FlowSettings` from an operator's properties."""
    apart = {
        "quantum": properties.quantum if properties.by == "CIRCULATION" else None,
        "count": properties.count if properties.by == "COUNT" else None,
        "core": properties.core or None,
        "frames": (properties.frame_start, properties.frame_end) if properties.use_frames else None,
    }
    return settings_of(FlowSettings, properties, FLOW_NAMES, **apart)


_Core = automatic_properties(
    "shown_core",
    partial(property_of, FlowSettings, "core"),
    lambda stored: stored.core or None,
    lambda stored, cells: setattr(stored, "core", cells or 0.0),
    lambda stored: automatic_core(stored.show.lower()),
)


class SynchVortices(VortexProperties, _Core, bpy.types.PropertyGroup):
    """Settings of vortices, kept in the file."""


def _show(look, _context):
    """Show the values of one object's sliders on all objects of its solve."""
    obj = look.id_data
    if look.result and memory.flows.holds(obj):
        slide(obj)


class SynchVortexLook(bpy.types.PropertyGroup):
    """How an object shows its solve; sliders change it at once, without a solve."""

    point: FloatVectorProperty(
        name="Point",
        description="Point of the sphere: filaments are where the map takes its antipode, and tubes surround them",
        subtype="DIRECTION",
        default=NORTH,
        update=_show,
    )
    opening: property_of(FlowSettings, "opening", update=_show)
    smoothing: property_of(FlowSettings, "smoothing", update=_show)
    result: StringProperty(name="Result", description="What the panel shows of the solve, as JSON")
    sources: StringProperty(name="Sources", description="Names of the objects that the flow was read from, as JSON")

    @property
    def source_objects(self):
        """The objects that the flow was read from, as far as they are still there."""
        try:
            names = read_kept_names(self.sources, f"what {self.id_data.name} keeps")
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
        """The stored result; {} without one, and if it cannot be read."""
        try:
            return read_kept_dict(self.result, f"what {self.id_data.name} keeps", VALUES)
        except SynchError:
            return {}


register, unregister = register_all(
    (SynchVortices, SynchVortexLook),
    (bpy.types.Scene, "synch_vortices", SynchVortices),
    (bpy.types.Object, "synch_vortices", SynchVortexLook),
)
