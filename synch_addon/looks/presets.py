# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets: each a material, and the settings of the solve that it is made for."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import bpy

from ...core.errors import SettingError, SynchError, quote_value
from ...core.refinement.spacing import automatic_spacing, lines_in_period
from ...core.validation import convert_value
from ..blender import meshes
from ..blender.pattern_surface import surface_of
from ..blender.phases import pattern_kind
from ..blender.transaction import whole_or_nothing
from ..nodes.materials import new_material, show_material, show_plain, shows_pattern
from ..nodes.stripe_profiles import NUMBER
from ..patterns import memory, numbers
from ..settings.guide_list import store_guidance
from . import looks

# Custom property of a material: the preset that it was made for.
_PROPERTY = "synch_preset"
# What stands in a list of presets for the look of a pattern that has none.
PLAIN = "plain"


@dataclass(frozen=True)
class Preset:
    """A look, and how the pattern for it is solved.

    Attributes
    ----------
    label, description : for the panel
    kind : "stripes" or "quads"
    across : stripes or quads across the object
    draw : what :func:`new_material` calls
    numbered : whether stripes of different numbers look different
    settings : of the solve
    """

    label: str
    description: str
    kind: str
    across: int
    draw: Callable
    numbered: bool = False
    settings: Mapping = field(default_factory=dict)


PRESETS = {
    "zebra": Preset("Zebra", "Black and white hair, bold stripes with frayed edges", "stripes", 20, looks.zebra),
    "corduroy": Preset(
        "Corduroy", "Ribs of velvet, worn on top", "stripes", 44, looks.corduroy, True, {"guidance": "axis:Z"}
    ),
    "wood-cut": Preset(
        "Wood-Cut",
        "Lines of ink along the least curvature, which swell where the surface is turned from the light",
        "stripes",
        56,
        looks.wood_cut,
        settings={"guidance": "curvature-min"},
    ),
    "knit": Preset("Knit Ribs", "Columns of stitches of a thick yarn", "stripes", 30, looks.knit, True),
    "cane": Preset("Woven Cane", "Strips of rattan, over and under in turn", "quads", 34, looks.cane),
    "fingerprint": Preset(
        "Fingerprint", "Ridges in ink, which break off and have pores", "stripes", 46, looks.fingerprint, True
    ),
}


def find_preset(name):
    """The :class:`Preset` of this name, refusing others."""
    if convert_value("preset", str, name) not in PRESETS:
        raise SettingError(f"the preset {quote_value(name)} is unknown: use one of {', '.join(PRESETS)}")
    return PRESETS[name]


def fits(obj, preset):
    """Whether an object's present pattern can show a preset, without another solve."""
    if pattern_kind(obj) != preset.kind:
        return False
    return not preset.numbered or NUMBER in surface_of(obj).data.attributes or memory.holds(obj)


def solve_settings(obj, preset):
    """Settings of the solve that a preset is made for, its spacing included."""
    with meshes.object_mode(obj):
        spacing = automatic_spacing(meshes.read_mesh(obj).mesh, lines_in_period(preset.kind), preset.across)
    return {"symmetry": "line", "guidance": "smooth", **preset.settings, "spacing": spacing}


def store_settings(stored, settings):
    """Put what :func:`solve_settings` gives into the settings of an object's panel."""
    store_guidance(stored, settings["guidance"])
    stored.symmetry = settings["symmetry"].upper()
    stored.spacing, stored.automatic_spacing = settings["spacing"], False


def solve_for(obj, name, always=False):
    """Command and settings of the solve that a preset needs on an object, None where the present pattern fits."""
    preset = find_preset(name)
    with meshes.object_mode(obj):
        if fits(obj, preset) and not always:
            return None
        return {"command": preset.kind, **solve_settings(obj, preset)}


def show(obj, name, assign_faces=False):
    """Show a preset on an object whose pattern fits it; returns the material."""
    preset = find_preset(name)
    with meshes.object_mode(obj), whole_or_nothing():
        if preset.numbered and NUMBER not in surface_of(obj).data.attributes:
            numbers.number_stripes(obj)
        made = preset_material(name)
        show_material(surface_of(obj), made, preset.kind, assign_faces=assign_faces)
        meshes.update(surface_of(obj))
    return made


def show_without_preset(obj):
    """Show an object's pattern in two plain colours, as it was before any preset; returns the material.

    Raises SynchError where it has no pattern.
    """
    kind = pattern_kind(obj)
    if kind is None:
        raise SynchError(f"{obj.name} has no pattern: solve stripes or quads on it first")
    with meshes.object_mode(obj), whole_or_nothing():
        made = show_plain(surface_of(obj), kind)
        meshes.update(surface_of(obj))
    return made


def shown_preset(obj):
    """The name of the preset that an object's pattern shows, PLAIN for another look, None without a pattern."""
    if obj is None or obj.type != "MESH" or pattern_kind(obj) is None:
        return None
    shown = (slot.material for slot in surface_of(obj).material_slots if shows_pattern(slot.material))
    name = next((material.get(_PROPERTY) for material in shown), None)
    return name if name in PRESETS else PLAIN


def preset_material(name) -> bpy.types.Material:
    """The file's material of a preset, made on first use."""
    for material in bpy.data.materials:
        if material.library is None and material.get(_PROPERTY) == name:
            return material
    preset = find_preset(name)
    made = new_material(f"Synch {preset.label}", preset.kind, preset.draw)
    made[_PROPERTY] = name
    return made
