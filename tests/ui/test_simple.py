# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The simple panel in a real window: one button, and variations that a click on a thumbnail's button shows."""

import numpy as np
import pytest

from .test_window import add_ball, solved


@pytest.fixture
def simple(as_delivered):
    """The simple panel."""
    as_delivered.open_panel()
    return as_delivered


def test_one_button_and_the_thumbnails_of_what_it_made(simple, keep):
    add_ball(simple, 5)
    simple.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.3")
    for text in ("Simple", "Advanced", "Stripes", "Direction", "Branching"):
        simple.wait_for(text)
    for text in ("Guide", "Pattern", "Details", "Make"):
        assert not simple.shows(text), text
    simple.click("Stripes")
    simple.wait_for("Variation")
    gallery = "part('panels.thumbnails').galleries.of(active())"
    simple.until(f"len({gallery}.made) == {gallery}.count > 1")
    keep("simple", simple.picture("UI"))
    before = simple.value(f"[variation.picture.tolist() for variation in {gallery}.made]")
    simple.run("from mathutils import Euler; view().view_rotation = Euler((1.5, 0, 2.5)).to_quaternion()")
    simple.run("import numpy as np; turned = np.array(view().view_rotation.to_matrix()).T; area().tag_redraw()")
    simple.until(f"{gallery}.is_complete and bool(np.abs({gallery}.view - turned).max() < 0.03)")
    after = simple.value(f"[variation.picture.tolist() for variation in {gallery}.made]")
    assert all(np.abs(np.subtract(old, new)).max() > 0.5 for old, new in zip(before, after, strict=True))
    cost = simple.value(f"part('panels.thumbnails')._cost({gallery}.made[1])")
    simple.click(cost)
    simple.until(f"active().synch_shown.variation == {gallery}.made[1].number")
    keep("simple_variation", simple.picture())


def test_another_count_of_faces_is_one_field_and_one_click(simple, keep):
    add_ball(simple, 4)
    simple.run("active().synch_simple.kind = 'quad_mesh'; active().synch.faces = 300; area().tag_redraw()")
    simple.click("Quad Mesh")
    simple.until("active().synch.source is not None")
    for text in ("Quad Mesh Again", "Face Count", "Loops", "Branching"):
        simple.wait_for(text)
    name, count = simple.value("active().name"), simple.value("len(active().data.polygons)")
    objects = simple.value("len(bpy.data.objects)")
    assert 280 <= count <= 320
    simple.run("active().synch.faces = 600; area().tag_redraw()")
    simple.run("work = None; queue = part('jobs.queue').queue")
    simple.click(simple.says("Update {what}", what=simple.says("Quad Mesh")))
    simple.until("bool(work := queue.running or work) and (work.is_seen or work.is_over)")
    assert simple.value("work.is_seen")  # drawn over the quad mesh, although its source is hidden
    simple.until("len(active().data.polygons) > 550")
    simple.wait_for("Quad Mesh Again")
    assert simple.value("active().name") == name and simple.value("len(bpy.data.objects)") == objects
    keep("quad_mesh_again", simple.picture("UI"))


def test_a_click_on_the_picture_of_a_look_applies_it(simple, keep):
    add_ball(simple, 4)
    simple.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.4")
    simple.run("bpy.context.scene.synch_preset = 'corduroy'")  # as the click does
    simple.until("active().active_material and active().active_material.name == 'Synch Corduroy'")

    def is_velvet(picture):
        """ribs of orange velvet in Solid view"""
        red, _, blue = (picture[..., channel].astype(int) for channel in range(3))
        return (red > blue + 50).sum() > 20_000

    keep("look_in_solid", simple.wait_to_see(is_velvet, None))
    assert not simple.shows("Apply Corduroy")
    simple.run("bpy.ops.ed.undo_push(message='before')")
    place = simple.wait_for("Look") + (40, -55)
    simple.click(place)
    simple.wait_for("Zebra", "WINDOW")
    keep("looks", simple.picture())
    simple.click("Zebra", "WINDOW")
    simple.until("active().active_material.name == 'Synch Zebra' and bpy.context.scene.synch_preset == 'zebra'")
    simple.move((500, 700))
    simple.press("Z", ctrl=True)  # one step
    simple.until("active().active_material.name == 'Synch Corduroy' and bpy.context.scene.synch_preset == 'corduroy'")


def test_enter_in_a_field_that_is_unchanged_changes_nothing(simple):
    add_ball(simple, 4)
    simple.run("active().synch.automatic_spacing = True; area().tag_redraw()")
    solved(simple)
    lines = simple.value("active().synch_simple.lines")
    assert lines != round(lines)
    simple.move(simple.wait_for("Lines Across") + (76, 0))
    simple.hold(ctrl=True)  # as a double click, which edits the field
    simple.release()
    simple.press("RET")
    assert simple.value("[active().synch_simple.lines, active().synch.automatic_spacing]") == [lines, True]
    assert not simple.shows(simple.says("Update {what}", what=simple.says("Stripes")))
