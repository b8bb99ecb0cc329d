# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Patterns on a surface of their own, as every kind of view draws them."""

import pytest

from .test_solid_view import is_inked
from .test_window import stripes_are_seen

CUBE = "bpy.ops.mesh.primitive_cube_add(size=3)"
MONKEY = (
    "bpy.ops.mesh.primitive_monkey_add(size=3)\n"
    "bpy.ops.object.shade_smooth()\n"
    "import bmesh\n"
    "half = bmesh.new()\n"
    "half.from_mesh(active().data)\n"
    "bmesh.ops.delete(half, geom=[v for v in half.verts if v.co.x < -1e-4], context='VERTS')\n"
    "half.to_mesh(active().data)\n"
    "for kind in ('MIRROR', 'SUBSURF', 'SOLIDIFY'):\n"
    "    active().modifiers.new(kind.capitalize(), kind)\n"
    "from mathutils import Euler\n"
    "view().view_rotation = Euler((1.25, 0, 0.7)).to_quaternion()"
)
TUBE = (
    "bpy.ops.mesh.primitive_cylinder_add(vertices=8, radius=0.8, depth=4, end_fill_type='NOTHING')\n"
    "twist = active().modifiers.new('Twist', 'SIMPLE_DEFORM')\n"
    "twist.deform_method, twist.deform_axis = 'TWIST', 'Z'\n"
    "for frame, twist.angle in ((1, 0.0), (20, 1.2)):\n"
    "    twist.keyframe_insert('angle', frame=frame)\n"
    "bpy.context.scene.frame_set(1)"
)


@pytest.mark.parametrize(("name", "build"), [("cube", CUBE), ("monkey", MONKEY), ("tube", TUBE)])
def test_every_view_draws_the_stripes(panel, keep, name, build):
    panel.run(build)
    panel.click("Stripes")
    panel.wait_for("Variation")
    panel.wait_to_see(is_inked, "WINDOW")
    keep(f"own_surface_{name}_solid", panel.picture("WINDOW"))
    for shading in ("MATERIAL", "RENDERED"):
        for frame in (1, 20) if name == "tube" else (1,):
            panel.run(f"bpy.context.scene.frame_set({frame})")
            panel.run(f"area().spaces[0].shading.type = {shading!r}")
            picture = panel.wait_to_see(stripes_are_seen, "WINDOW", still=5)
            keep(f"own_surface_{name}_{shading.lower()}_{frame}", picture)
    assert panel.value("[a.name for a in active().data.attributes if a.name.startswith('synch_')]") == []
