# SPDX-License-Identifier: GPL-3.0-or-later
"""The few choices of the simple panel, each a name for values of the object's settings."""

import math
from functools import partial

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty

from ...core.refinement.spacing import lines_in_period
from ...core.settings.surface import SurfaceSettings
from ..blender.registration import register_all
from ..jobs.kept_results import read_result_or_empty
from ..patterns.refine import expected_faces, expected_spacing, mesh_detail
from ..settings.automatic import automatic_properties
from ..settings.fields import AUTOMATIC_SPACING, original_of
from ..settings.rna import property_of

# Settings of each direction: guidance and angle.
_DIRECTIONS = {
    "AUTOMATIC": ("AUTOMATIC", 0.0),
    "SMOOTH": ("SMOOTH", 0.0),
    "CURVATURE": ("CURVATURE_MIN", 0.0),
    "AXIS": ("AXIS", math.pi / 2),
    "STROKES": ("SMOOTH", 0.0),
}
_DIRECTION_ITEMS = (
    ("AUTOMATIC", "Automatic", "Smoothest, but along curvature for quad meshes without strokes", 0),
    ("SMOOTH", "Smoothest", "Lines that turn as little as the shape allows (the smoothest direction field)", 1),
    ("CURVATURE", "Along Curvature", "Lines along ridges, where the surface bends least (principal directions)", 2),
    ("AXIS", "Around an Axis", "Rings around an axis of the object", 3),
    ("STROKES", "Strokes", "Lines that you draw on the surface", 4),
    ("OTHER", "Other Guides", "The guides of the box Guide under Advanced", 5),
)
_KIND_ITEMS = (
    ("stripes", "Stripes", "Even stripes over the surface", "MOD_WAVE", 0),
    ("quads", "Quad Pattern", "A grid of squares over the surface", "MESH_GRID", 1),
    ("quad_mesh", "Quad Mesh", "A new mesh of quads, and the object is hidden", "MOD_REMESH", 2),
    ("directions", "Directions", "A direction at each vertex, without lines", "ORIENTATION_NORMAL", 3),
)
# By how much, at most, an estimate of the automatic spacing differs from the one that is solved.
_ESTIMATE_ERROR = 0.1


def _get_direction(simple):
    """The number of the menu's direction that the guidance and angle of an object agree with; the last for others."""
    stored = simple.id_data.synch
    if simple.others:
        return len(_DIRECTIONS)
    for number, (name, (guidance, angle)) in enumerate(_DIRECTIONS.items()):
        # The menu must not change while the angle is dragged: any fits, but for entries with an angle any except 0.
        if stored.guidance == guidance and (angle == 0 or stored.angle != 0):
            return number if name != "SMOOTH" or not simple.draws else list(_DIRECTIONS).index("STROKES")
    return len(_DIRECTIONS)


def _set_direction(simple, number):
    simple.others = number == len(_DIRECTIONS)
    if number < len(_DIRECTIONS):
        name = list(_DIRECTIONS)[number]
        simple.draws = name == "STROKES"
        stored = simple.id_data.synch
        stored.guidance, stored.angle = _DIRECTIONS[name]


def _size(simple):
    """The spacing, in scene units, at which the count of lines is one; 0 for an object without extent.

    It is measured on the mesh, so that modifiers and shape keys do not change it.
    """
    obj = original_of(simple.id_data)
    found = mesh_detail(obj) if obj.type == "MESH" else None
    return (max(obj.dimensions) if found is None else found.size) * lines_in_period(simple.kind)


def _get_lines(simple):
    obj, stored = simple.id_data, simple.id_data.synch
    spacing = expected_spacing(simple.kind, original_of(obj)) if stored.automatic_spacing else stored.spacing
    return _size(simple) / spacing if spacing else 0.0


def _set_lines(simple, count):
    stored = simple.id_data.synch
    shown = _get_lines(simple)
    if math.isclose(count, shown, rel_tol=1e-5) or count == round(count) == round(shown):  # Enter in the field
        return
    if _size(simple) > 0:
        stored.spacing, stored.automatic_spacing = _size(simple) / count, False


def _set_automatic(simple, is_automatic):
    """Switch the automatic spacing. Off, it keeps the solved spacing if the mesh still suggests about that one, else
    the estimate."""
    obj = simple.id_data
    if is_automatic:
        obj.synch.automatic_spacing = True
        return
    original_of(obj).update_from_editmode()
    expected = expected_spacing(simple.kind, original_of(obj))
    if expected:  # else there is no surface yet, and the spacing stays automatic
        solved = (read_result_or_empty(obj.synch.result).get("settings") or {}).get("spacing") or 0.0
        obj.synch.spacing = solved if math.isclose(solved, expected, rel_tol=_ESTIMATE_ERROR) else expected
        obj.synch.automatic_spacing = False


_Faces = automatic_properties(
    "faces",
    partial(property_of, SurfaceSettings, "faces"),
    lambda simple: simple.id_data.synch.faces or None,
    lambda simple, count: setattr(simple.id_data.synch, "faces", count or 0),
    lambda simple: expected_faces(original_of(simple.id_data), simple.id_data.synch),
)


class SynchSimple(_Faces, bpy.types.PropertyGroup):
    """What the simple panel makes of an object."""

    kind: EnumProperty(name="Kind", description="What the button makes", items=_KIND_ITEMS)
    direction: EnumProperty(
        name="Direction",
        description="What lines follow",
        items=_DIRECTION_ITEMS,
        get=_get_direction,
        set=_set_direction,
    )
    draws: BoolProperty(name="Strokes", description="Let lines follow drawn strokes")
    others: BoolProperty(name="Other Guides", description="Let lines follow the guides under Advanced")
    lines: FloatProperty(
        name="Lines Across",
        description="Approximate number of lines across the object's longest side, which sets their distance",
        get=_get_lines,
        set=_set_lines,
        min=0.1,
        soft_min=4,
        soft_max=200,
        precision=0,
        step=100,
    )
    automatic_spacing: BoolProperty(
        **AUTOMATIC_SPACING,
        get=lambda simple: simple.id_data.synch.automatic_spacing,
        set=_set_automatic,
    )


register, unregister = register_all((SynchSimple,), (bpy.types.Object, "synch_simple", SynchSimple))
