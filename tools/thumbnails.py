# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the thumbnails that ship: a sphere for each preset, and for each node group of the asset library.

    python tools/thumbnails.py [--folder synch_addon/looks/thumbnails]

Needs Blender as a module (bpy).
"""

import argparse
from pathlib import Path

import bpy

import synch_fields
from synch_fields.synch_addon import api
from synch_fields.synch_addon.looks import assets, presets
from synch_fields.synch_addon.looks.render import render_picture
from synch_fields.synch_addon.nodes.canvas import surface_material

SIZE = 128
# Stripes or quads across the sphere of a thumbnail, as many as can be told apart in it.
ACROSS, FINE = 11, 16
CLAY, ROUGHNESS = (0.50, 0.44, 0.37, 1.0), 0.45


def main() -> None:
    parser = argparse.ArgumentParser(description="Make the thumbnails that ship.")
    parser.add_argument("--folder", type=Path, default=assets.THUMBNAILS, metavar="DIR")
    options = parser.parse_args()
    synch_fields.register()
    try:
        thumbnails(options.folder)
    finally:
        synch_fields.unregister()


def thumbnails(folder):
    """A picture of a sphere for each preset, and for each node group of the asset library."""
    folder.mkdir(exist_ok=True)
    for name, preset in presets.PRESETS.items():
        obj = sphere()
        across = FINE if name in ("wood-cut", "fingerprint") else ACROSS
        api.preset(obj, name, spacing=spacing_across(obj, preset.kind, across))
        picture(obj, folder / f"{name}.png")
    for _, name in assets.GROUPS.values():
        obj = sphere()
        kind = "quads" if "quad" in name else "stripes"
        getattr(api, kind)(obj, spacing=spacing_across(obj, kind))
        if "relief" in name:
            obj.active_material = clay()
            api.relief(obj, height=0.3 if kind == "stripes" else 0.2, level=2)
        picture(obj, folder / f"{name}.png")


def sphere():
    """A smooth sphere."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=1)
    bpy.context.object.data.shade_smooth()
    return bpy.context.object


def spacing_across(obj, kind, across=ACROSS):
    """The period of so many stripes or quads; one of quads has two."""
    return max(obj.dimensions) / across * (2 if kind == "quads" else 1)


def clay():
    """A plain material."""
    material, surface, _ = surface_material("Clay")
    surface.inputs["Base Color"].default_value, surface.inputs["Roughness"].default_value = CLAY, ROUGHNESS
    return material


def picture(obj, path):
    render_picture(obj, path, resolution=(SIZE, SIZE), samples=96, view=(-25, 22), markers=False)


if __name__ == "__main__":
    main()
