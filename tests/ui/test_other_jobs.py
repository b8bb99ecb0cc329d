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


def test_an_automatic_length_of_layers_stays_what_it_was(panel, keep):
    panel.run(CUBE)
    panel.scroll_to("Layers")
    panel.click("Layers", last=True)
    panel.scroll_to("Resolution")
    expected = panel.value("active().synch_layering.shown_size")
    panel.click("Auto", last=True)
    panel.until("not active().synch_layering.automatic_size")
    assert panel.value("active().synch_layering.size") == pytest.approx(expected)
    keep("layers_automatic_off", panel.picture("UI"))


def filament_pixels(picture):
    """How many pixels have the orange of filaments that are drawn before the end of their solve."""
    red, green, blue = (picture[..., channel].astype(int) for channel in range(3))
    return ((red > 200) & (green > 80) & (green < 160) & (blue < 80)).sum()


def height_of_progress(panel):
    """The height in the window at which the sidebar shows the progress of the running job."""
    while not (shown := panel.places(panel.value("queue.running.short_line"))).size:  # it goes on meanwhile
        panel.run("area().tag_redraw()")
    return shown[0, 1]


def test_filaments_are_drawn_long_before_the_end_and_go_with_the_job(panel, keep):
    panel.run(CIRCLE + "bpy.context.scene.synch_vortices.resolution = 120")
    panel.run("queue = part('jobs.queue').queue")
    panel.scroll_to("Vortices")
    panel.click("Vortices", last=True)
    panel.scroll_to("Vortices", count=2)
    x, y = panel.wait_for("Vortices", last=True)
    panel.click((x, y))
    panel.until("queue.running is not None")
    panel.move((700, 500))
    panel.until("queue.running.expected is not None")
    assert abs(height_of_progress(panel) - y) < 3  # in the place of the button
    panel.run("circle = active()\ncircle.hide_set(True)")
    panel.until("queue.running.picture is not None")
    keep("first_filaments", panel.wait_to_see(lambda picture: filament_pixels(picture) > 100, "WINDOW"))
    panel.run("circle.hide_set(False)\ncircle.select_set(True)")  # a panel without an object has fewer rows
    while abs(height_of_progress(panel) - y) >= 3:
        pass
    left, _, width, _ = panel.region("UI")
    panel.click((left + width - 50, y))
    panel.until("queue.running is None")
    assert not panel.value("any(o.name.endswith(' Filaments') for o in bpy.data.objects)")
    assert abs(panel.wait_for("Vortices", last=True)[1] - y) < 3
    panel.run("circle.hide_set(True)")
    panel.wait_to_see(lambda picture: filament_pixels(picture) == 0, "WINDOW")


def test_the_view_is_zoomed_and_esc_ends_a_bake_while_cycles_works(panel, keep):
    panel.run("bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=1); bpy.ops.synch.stripes(spacing=0.3)")
    panel.run("bake = bpy.context.scene.synch_bake; bake.size = 2048; bake.samples = 64; bake.unwrap = True")
    panel.scroll_to("Bake")
    panel.click("Bake")
    panel.scroll_to("Bake", count=2)
    panel.click("Bake", last=True)
    panel.until(
        "any(hasattr(o, '_child') for o in __import__('gc').get_objects() if type(o).__name__ == 'OtherProcess')"
    )
    before = panel.value("view().view_distance")
    panel.move((500, 500))
    panel.run("event('WHEELUPMOUSE', 'PRESS', 500, 500)")
    panel.until(f"view().view_distance < {before}")
    keep("bake_runs", panel.picture())
    assert panel.value("part('jobs.queue').queue.running.stage") == "height"
    panel.press("ESC")
    panel.until("part('jobs.queue').queue.running is None")
    assert panel.value("[len(bpy.data.scenes), len(active().data.uv_layers)]") == [1, 1]
    assert not panel.value("[image.name for image in bpy.data.images if image.size[0] == 2048]")
