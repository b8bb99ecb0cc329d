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
    assert is_plain(panel.picture("WINDOW"))
    for button, name in (("Stripes", "solid_stripes"), ("Quads", "solid_quads")):
        panel.click(button)
        panel.wait_for("Variation")
        panel.wait_to_see(is_inked, "WINDOW")
        keep(name, panel.picture())
    panel.run("active().modifiers.new('smooth', 'SUBSURF').levels = 2")
    panel.wait_to_see(is_inked, "WINDOW")
    keep("solid_subdivided", panel.picture())
    panel.scroll_to("Solid", up=True)
    panel.click("Solid")
    panel.wait_to_see(is_plain, "WINDOW")
    assert "synch_phase_x" in panel.value("state()")["attributes"]
