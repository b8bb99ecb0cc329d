# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The manual's first page, followed by a new user: Suzanne, a striped render, a baked texture and a quad mesh."""

import numpy as np

from .test_window import stripes_are_seen

IMAGES = "[(i.name, list(i.size), bool(i.packed_file)) for i in bpy.data.images if i.name.startswith('Suzanne')]"
IDLE = "part('jobs.queue').queue.running is None"


def test_the_first_page_from_suzanne_to_stripes_a_texture_and_quads(as_delivered, keep, tmp_path):
    blender = as_delivered
    blender.run("bpy.ops.mesh.primitive_monkey_add(); bpy.ops.object.shade_smooth()")
    blender.open_panel()
    blender.click("Stripes")
    blender.wait_for("Rendered")

    rendered = tmp_path / "render.png"
    blender.run(
        "scene = bpy.context.scene; scene.render.resolution_percentage = 25; scene.eevee.taa_render_samples = 4"
    )
    blender.run(f"scene.render.filepath = {str(rendered)!r}; bpy.ops.render.render(write_still=True)")
    blender.run(f"image = bpy.data.images.load({str(rendered)!r}); size = tuple(image.size)")
    pixels = np.array(blender.value("list(image.pixels)")).reshape(-1, 4)[:, :3]
    dark, light = (pixels[:, 2] > 1.5 * pixels[:, 0]).sum(), (pixels[:, 0] > 1.05 * pixels[:, 2]).sum()
    assert min(dark, light) > 300, (dark, light)

    blender.click("Advanced")
    blender.scroll_to("Bake")
    blender.click("Bake", last=True)
    blender.scroll_to("Bake", count=2)
    blender.run("bpy.context.scene.synch_bake.size = 128; bpy.context.scene.synch_bake.samples = 1")
    blender.click("Bake", last=True)
    blender.until(f"{IDLE} and len({IMAGES}) == 3")
    names = {f"Suzanne_{name}.png" for name in ("colour", "height", "normal")}
    assert {(name, *size, packed) for name, size, packed in blender.value(IMAGES)} == {
        (n, 128, 128, True) for n in names
    }

    blender.scroll_to("Simple", up=True)
    blender.click("Simple")
    label = blender.wait_for("Kind")
    x, _, width, _ = blender.region()
    blender.click((x + 0.6 * width, label[1]))
    keep("start_list", blender.picture())
    blender.press("THREE")  # the third of the list; its underlined letter differs between languages
    blender.click("Quad Mesh")
    blender.until(f"{IDLE} and active().name == 'Suzanne Quads'")
    assert blender.value("all(len(p.vertices) == 4 for p in active().data.polygons)")
    assert blender.value("active().show_wire and not bpy.data.objects['Suzanne'].visible_get()")
    assert blender.shows("Result")  # the number of its faces
    keep("start_quads", blender.picture())
    assert not stripes_are_seen(blender.picture("WINDOW"))


def test_errors_are_in_english_in_every_language(as_delivered):
    """In the window and to scripts, where the labels beside them are translated."""
    blender = as_delivered
    blender.run("bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)")
    blender.run("bpy.context.preferences.view.language = 'de_DE'")
    shown = "try: bpy.ops.synch.stripes(spacing=100)\nexcept RuntimeError as error: answer = str(error)"
    raised = "try: part('api').stripes(active(), spacing=100)\nexcept Exception as error: answer = str(error)"
    english = "the spacing 100 is larger than the object"
    assert english in blender.run(shown) and english in blender.run(raised)
    blender.open_panel()
    blender.wait_for("Streifen")
