# SPDX-License-Identifier: GPL-3.0-or-later
"""What Solid view shows of a result, and how it goes again."""


def inked(picture):
    """Share of the pixels of the view that are as dark and blue as a stripe."""
    picture = picture.astype(int)
    return float(((picture[..., 2] > picture[..., 0] + 8) & (picture.sum(axis=2) < 250)).mean())


def is_inked(picture):
    """stripes in the view"""
    return inked(picture) > 0.005


def is_plain(picture):
    """no stripes in the view"""
    return inked(picture) < 0.001


def test_a_pattern_is_seen_in_solid_view_at_once_and_goes_by_a_click(panel, keep):
    panel.run("bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=2)")
    panel.run("bpy.ops.object.shade_smooth()")
    panel.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.6")
    assert is_plain(panel.picture("WINDOW"))
    for kind, button in (("stripes", "Stripes"), ("quads", "Quad Pattern")):
        panel.run(f"active().synch_simple.kind = {kind!r}; area().tag_redraw()")
        panel.click(button)
        panel.wait_for("Variation")
        panel.wait_to_see(is_inked, "WINDOW")
        keep(f"solid_{kind}", panel.picture())
    panel.run("active().modifiers.new('smooth', 'SUBSURF').levels = 2")
    panel.wait_to_see(is_inked, "WINDOW")
    keep("solid_subdivided", panel.picture())
    panel.scroll_to("Solid", up=True)
    panel.click("Solid")
    panel.wait_to_see(is_plain, "WINDOW")
    assert "synch_phase_x" in panel.value("state()")["attributes"]


def test_the_ink_follows_a_shape_key_a_frame_and_the_object_that_goes(panel, keep):
    """Ink that stayed behind would be hidden by the surface, which grows around it."""
    panel.run("view().view_distance = 8")
    panel.run("bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=1)")
    panel.run("bpy.ops.object.shade_smooth()")
    panel.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.3")
    panel.click("Stripes")
    panel.wait_for("Variation")
    panel.wait_to_see(is_inked, "WINDOW")
    panel.run(
        "obj = active()\n"
        "obj.shape_key_add(name='Basis')\n"
        "key = obj.shape_key_add(name='bent')\n"
        "for point in key.data:\n"
        "    x, y, z = point.co\n"
        "    point.co = (1.5 * x + z * z, y, 2.2 * z)\n"
        "key.value = 0.0\n"
        "key.keyframe_insert('value', frame=1)\n"
        "key.value = 1.0\n"
        "key.keyframe_insert('value', frame=20)\n"
        "bpy.context.scene.frame_set(1)"
    )
    panel.wait_for(panel.says("Shape: {shape}", shape="Basis"))
    panel.wait_to_see(is_inked, "WINDOW")
    straight = inked(panel.picture("WINDOW"))
    panel.run("bpy.context.scene.frame_set(20)")
    panel.wait_to_see(lambda picture: inked(picture) > 1.2 * straight, "WINDOW")
    keep("solid_bent", panel.picture())
    assert panel.value("sum(o.type == 'EMPTY' for o in bpy.data.objects)") > 0
    panel.run("bpy.data.objects.remove(active())")
    panel.until("not any(o.type == 'EMPTY' for o in bpy.data.objects)")
