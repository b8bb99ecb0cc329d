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
    "tube, rings = active(), bmesh.new()\n"
    "rings.from_mesh(tube.data)\n"
    "upright = [e for e in rings.edges if abs(e.verts[0].co.z - e.verts[1].co.z) > 1]\n"
    "bmesh.ops.subdivide_edges(rings, edges=upright, cuts=5, use_grid_fill=True)\n"
    "rings.to_mesh(tube.data)\n"
    "rig = bpy.data.objects.new('Rig', bpy.data.armatures.new('Rig'))\n"
    "bpy.context.collection.objects.link(rig)\n"
    "bpy.context.view_layer.objects.active = rig\n"
    "bpy.ops.object.mode_set(mode='EDIT')\n"
    "for name, low, side in (('lower', -2, -1), ('upper', 0, 1)):\n"
    "    bone = rig.data.edit_bones.new(name)\n"
    "    bone.head, bone.tail = (0, 0, low), (0, 0, low + 2)\n"
    "    group = tube.vertex_groups.new(name=name)\n"
    "    group.add([v.index for v in tube.data.vertices if side * v.co.z > -0.1], 1, 'REPLACE')\n"
    "rig.data.edit_bones['upper'].parent = rig.data.edit_bones['lower']\n"
    "bpy.ops.object.mode_set(mode='OBJECT')\n"
    "bone = rig.pose.bones['upper']\n"
    "bone.rotation_mode = 'XYZ'\n"
    "for frame, angle in ((1, 0.0), (20, 1.2)):\n"
    "    bone.rotation_euler = (angle, 0, 0)\n"
    "    bone.keyframe_insert('rotation_euler', frame=frame)\n"
    "rig.hide_set(True)\n"
    "tube.modifiers.new('Armature', 'ARMATURE').object = rig\n"
    "bpy.context.view_layer.objects.active = tube\n"
    "tube.select_set(True)\n"
    "bpy.context.scene.frame_set(1)"
)
HEXAGONS = (
    "bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=1.6)\n"
    "ball = bmesh.new()\n"
    "ball.from_mesh(active().data)\n"
    "bmesh.ops.bevel(ball, geom=ball.verts, offset=33, offset_type='PERCENT', affect='VERTICES', segments=1)\n"
    "ball.to_mesh(active().data)"
)
SHAPES = {"cube": CUBE, "monkey": MONKEY, "tube": TUBE, "hexagons": HEXAGONS}
MESH = "str([[v.co[:] for v in active().data.vertices], [f.vertices[:] for f in active().data.polygons]])"


@pytest.mark.parametrize(("name", "build"), SHAPES.items(), ids=SHAPES)
def test_every_view_draws_the_stripes(panel, keep, name, build):
    panel.run("view().view_distance = 8")
    panel.run("import bmesh\n" + build)
    mesh = panel.value(MESH)
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
    assert panel.value(MESH) == mesh
    assert panel.value("[a.name for a in active().data.attributes if a.name.startswith('synch_')]") == []
