# SPDX-License-Identifier: GPL-3.0-or-later
"""Several selected objects: one click solves them one after the other, each with its own settings."""

import json


def test_one_click_solves_all_selected_objects_and_one_cancels_them(panel, keep):
    for number in range(3):
        place = f"location=({3 * number - 3}, 0, 0)"
        panel.run(f"bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=1, {place})")
    panel.run("bpy.ops.object.select_all(action='DESELECT')")
    panel.run("[obj.select_set(obj.type == 'MESH') for obj in bpy.data.objects]")
    panel.run("active().synch.symmetry, active().synch.angle = 'VECTOR', 0.5")
    panel.click("Copy Settings to Selected")
    panel.until("[obj.synch.symmetry for obj in bpy.context.view_layer.objects.selected] == ['VECTOR'] * 3")
    panel.click("Stripes")
    panel.until("len(part('jobs.queue').queue.works) == 3")
    panel.wait_for("Cancel All")
    keep("several", panel.picture("UI"))
    panel.click("Cancel All")
    panel.until("not part('jobs.queue').queue.works")
    assert not any(panel.value("[obj.synch.result for obj in bpy.context.view_layer.objects.selected]"))
    panel.run("bpy.context.view_layer.objects.selected[0].synch.angle = 0.0")
    panel.wait_for("Stripes")
    panel.click("Stripes")
    panel.until("all(obj.synch.result for obj in bpy.context.view_layer.objects.selected)")
    results = panel.value("[obj.synch.result for obj in bpy.context.view_layer.objects.selected]")
    angles = sorted(json.loads(result)["settings"].get("angle", 0.0) for result in results)
    assert [round(angle, 3) for angle in angles] == [0.0, 0.5, 0.5]
    keep("several_done", panel.picture())
    panel.move((700, 500))
    panel.press("Z", ctrl=True)  # one step for one click
    panel.until("not any(obj.synch.result for obj in bpy.data.objects)")


def test_undo_between_two_objects_of_a_click_takes_back_the_first(panel):
    """Its modifier would else point to a surface that is gone, and Blender crash."""
    for size in (6, 2):  # the second is shown on a surface of its own; the first takes a while
        panel.run(f"bpy.ops.mesh.primitive_ico_sphere_add(subdivisions={size}, location=({size}, 0, 0))")
    panel.run("bpy.ops.ed.undo_push(message='add')")
    panel.run("[obj.select_set(obj.type == 'MESH') for obj in bpy.data.objects]")
    first, objects = panel.value("active().name"), panel.value("sorted(obj.name for obj in bpy.data.objects)")
    panel.click("Stripes")
    panel.until("active().synch.result")
    assert panel.value("[len(active().modifiers) > 0, len(part('jobs.queue').queue.works)]") == [True, 1]
    panel.move((700, 500))
    panel.press("Z", ctrl=True)
    panel.until(f"not bpy.data.objects[{first!r}].synch.result")
    assert not panel.value(f"len(bpy.data.objects[{first!r}].modifiers)")
    panel.until("not part('jobs.queue').queue.works")
    panel.press("Z", ctrl=True, shift=True)
    panel.press("Z", ctrl=True)
    panel.run("bpy.ops.ed.undo_push(message='still alive')")
    assert set(panel.value("sorted(obj.name for obj in bpy.data.objects)")) >= set(objects)
