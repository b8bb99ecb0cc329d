# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Save a file with every kind of result, and beside it what a later version has to find there.

    python tests/addon/saved/make.py [FOLDER]

Made once by each version, with the oldest Blender that it supports, and kept: test_saved.py opens them all.
"""

import json
import sys
from pathlib import Path

import bpy
import numpy as np

import synch_fields
from synch_fields import __version__ as VERSION
from synch_fields.synch_addon import api
from synch_fields.synch_addon.patterns import favourites

FACTS = ("command", "energy", "lower_bound", "disclinations", "dislocations")


def active(name):
    obj = bpy.context.active_object
    obj.name = obj.data.name = name
    return obj


def ball(name, place, subdivisions=3):
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions, location=(place, 0, 0))
    return active(name)


def group(obj, name, vertices):
    obj.vertex_groups.new(name=name).add(vertices, 1.0, "REPLACE")


def make():
    """The objects, by their names; and facts that are not in their attributes."""
    facts = {}
    stripes = ball("Stripes", 0, 4)
    stripes.synch.symmetry, stripes.synch.spacing, stripes.synch.automatic_spacing = "VECTOR", 0.3, False
    stripes.synch.guidance, stripes.synch.angle = "BLEND", 0.25
    row = stripes.synch.constraints.add()
    group(stripes, "Belt", [v.index for v in stripes.data.vertices if abs(v.co.z) < 0.1])
    row.where, row.what, row.vertex_group = "GROUP", "ALONG", "Belt"
    api.stripes(stripes, spacing=0.3, guidance="axis:Z", constraints=[])
    facts["Stripes"] = {"lines": api.isolines(stripes)["lines"], "kept": favourites.keep(stripes, "Best")}
    api.number_stripes(stripes)
    api.relief(stripes)
    calm = ball("Calm", 3, 4)
    api.stripes(calm, spacing=0.3, branching=0.2, guidance="axis:X")
    facts["Calm"] = {"lines": api.isolines(calm)["lines"]}
    quads = ball("Quads", 6, 4)
    api.quads(quads, spacing=0.3)
    facts["Quads"] = {"lines": api.isolines(quads)["lines"], "kept": favourites.keep(quads, "Best")}
    facts["Mesh"] = {"faces": api.quad_mesh(ball("Mesh", 9, 4), spacing=0.4)["quad_mesh"]["faces"]}
    api.directions(ball("Directions", 12), symmetry="cross")
    api.preset(ball("Knit", 15, 4), "knit", spacing=0.3)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(18, 0, 0))
    block = active("Block")
    group(block, "Bottom", [v.index for v in block.data.vertices if v.co.z < 0])
    group(block, "Top", [v.index for v in block.data.vertices if v.co.z > 0])
    facts["Block"] = {"layers": api.layers(block, guidance="harmonic:Bottom:Top", spacing=0.4, size=0.2)["layers"]}
    flow = ball("Flow", 21)
    vectors = np.cross([0, 0, 1], [v.co for v in flow.data.vertices]).astype(np.float32)
    flow.data.attributes.new("velocity", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", vectors.ravel())
    facts["Flow"] = {"vortices": len(api.clebsch(flow, quantum=np.pi / 5, show="tubes", target_gap=0.1)["vortices"])}
    bpy.ops.curve.primitive_bezier_circle_add(radius=1, location=(21, 3, 0))
    ring = bpy.context.active_object
    ring.name, ring["synch_strength"] = "Ring", 1.0
    report = api.clebsch(ring, quantum=0.5, show="filaments", resolution=24, target_gap=0.1)
    facts["Ring"] = {"filaments": len(report["filaments"]), "object": report["object"]}
    for kind in ("stripes", "quads"):
        moving = ball(f"Moving {kind}", 24 if kind == "stripes" else 27)
        moving.shape_key_add(name="Basis")
        key = moving.shape_key_add(name="Longer")
        for vertex, point in zip(moving.data.vertices, key.data, strict=True):
            point.co.z = 1.3 * vertex.co.z
        for frame, value in ((1, 0.0), (2, 1.0)):
            key.value = value
            key.keyframe_insert("value", frame=frame)
        api.animate(moving, frames=(1, 2), pattern=kind, spacing=0.5)
    for obj in bpy.data.objects:
        if obj.type == "MESH" and obj.synch.result:
            kept = json.loads(obj.synch.result)
            facts.setdefault(obj.name, {}).update({name: kept[name] for name in FACTS if name in kept})
    return facts


def attributes():
    """Of each mesh, the attributes that are ours, with their layout and the mean of their squares."""
    found = {}
    for obj in bpy.data.objects:
        for a in obj.data.attributes if obj.type == "MESH" else ():
            if a.name.startswith("synch_"):
                name = {"FLOAT_VECTOR": "vector", "FLOAT2": "vector", "FLOAT_COLOR": "color"}.get(a.data_type, "value")
                values = np.empty(len(a.data) * (len(getattr(a.data[0], name)) if name != "value" else 1), np.float32)
                a.data.foreach_get(name, values)
                square = float(np.mean(values.astype(float) ** 2))
                found.setdefault(obj.name, {})[a.name] = [a.domain, a.data_type, square]
    return found


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else __file__)
    folder = folder if folder.is_dir() else folder.parent
    synch_fields.register()
    bpy.ops.wm.read_homefile(use_empty=True)
    facts = make()
    path = folder / f"{VERSION}.blend"
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True)
    told = {"objects": facts, "attributes": attributes()}
    path.with_suffix(".json").write_text(json.dumps(told, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    synch_fields.unregister()
    print(path, path.stat().st_size)


if __name__ == "__main__":
    main()
