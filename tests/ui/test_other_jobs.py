# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What solves besides fields: layers in a solid, vortices of curves, animations, each from its panel."""

import pytest

CUBE = """
bpy.ops.mesh.primitive_cube_add(size=2)
bpy.ops.ed.undo_push(message="cube")
"""
CIRCLE = """
bpy.ops.curve.primitive_bezier_circle_add(radius=1)
bpy.context.scene.synch_vortices.resolution = 24
bpy.ops.ed.undo_push(message="circle")
"""
SWELLING = """
bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=1)
ball = bpy.context.active_object
ball.shape_key_add(name="Basis")
key = ball.shape_key_add(name="Long")
for point in key.data:
    point.co.z *= 1.2
for frame, value in ((1, 0), (4, 1)):
    key.value = value
    key.keyframe_insert("value", frame=frame)
bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 4
bpy.ops.ed.undo_push(message="ball")
"""
JOBS = {
    "Layers": (CUBE, "any(o.name.endswith(' Layers') for o in bpy.data.objects)"),
    "Vortices": (CIRCLE, "any(o.name.endswith(' Filaments') for o in bpy.data.objects)"),
    "Animation": (SWELLING, "'synch_phase.4' in active().data.attributes"),
}


@pytest.mark.parametrize("name", JOBS)
def test_a_job_runs_from_its_panel_and_is_undone(name, panel, keep):
    scene, made = JOBS[name]
    panel.run(scene)
    panel.scroll_to(name)
    panel.click(name, last=True)
    button = "Animate" if name == "Animation" else name
    panel.scroll_to(button, count=2 if button == name else 1)
    panel.click(button, last=True)
    panel.until(f"part('jobs.queue').queue.running is None and ({made})")

    def is_idle(picture):
        """the bar gone"""
        return not panel.reads(picture, "Cancel")

    keep(name.lower(), panel.wait_to_see(is_idle, None))
    panel.move((700, 500))
    panel.press("Z", ctrl=True)
    panel.until(f"not ({made})")
