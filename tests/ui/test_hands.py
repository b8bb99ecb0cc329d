# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What hands do: drag a count of lines, throw the dice, and bend a mesh whose defects are marked."""

import numpy as np

from .test_window import add_ball, result, solved

IDLE = "part('jobs.queue').queue.running is None"
# Inside: how far each empty is from the middle of its face, as modifiers and shape keys bend it.
APART = """
def apart():
    obj, graph = active(), bpy.context.evaluated_depsgraph_get()
    seen = obj.evaluated_get(graph)
    found = []
    for empty in obj.children:
        face = seen.data.polygons[empty["synch_face"]]
        place = obj.matrix_world @ face.center
        found.append((empty.evaluated_get(graph).matrix_world.translation - place).length)
    return found
"""


def drag_across(window, place, pixels):
    """Drag a field to the right by steps of ten pixels."""
    window.drag([place + (step, 0) for step in range(0, pixels + 1, 10)])


def test_lines_across_and_the_spacing_are_dragged_and_say_the_same(panel, keep):
    add_ball(panel, 4)
    panel.run("active().synch.spacing = 0.4; area().tag_redraw()")
    before = panel.value("active().synch_simple.lines")
    label = panel.wait_for("Lines Across")
    x, _, width, _ = panel.region()
    field = np.array([x + 0.5 * width, label[1]])
    drag_across(panel, field, 60)
    lines, spacing = panel.value("[active().synch_simple.lines, active().synch.spacing]")
    assert lines > before and np.isclose(lines * spacing, before * 0.4, rtol=1e-5)
    assert not panel.value("active().synch.automatic_spacing")
    keep("lines_dragged", panel.picture("UI"))
    label = panel.wait_for("Spacing")
    drag_across(panel, np.array([x + 0.7 * width, label[1]]), 60)
    lines_after, after = panel.value("[active().synch_simple.lines, active().synch.spacing]")
    assert after > spacing and np.isclose(lines_after * after, lines * spacing, rtol=1e-5)


def test_automatic_turned_off_leaves_what_it_chose(panel, keep):
    add_ball(panel, 5)
    lines = panel.value("active().synch_simple.lines")
    automatic = "active().synch.automatic_spacing"
    panel.click("Auto")
    panel.until(f"not {automatic}")
    assert np.isclose(panel.value("active().synch_simple.lines"), lines, rtol=1e-5)
    panel.wait_for("Spacing")
    keep("automatic_off", panel.picture("UI"))
    panel.click("Auto")
    panel.until(automatic)
    used = solved(panel)["settings"]["spacing"]
    panel.click("Auto")
    panel.until(f"not {automatic}")
    assert np.isclose(panel.value("active().synch.spacing"), used, rtol=1e-5)
    assert not panel.shows(panel.says("Update {what}", what=panel.says("Stripes")))


def test_the_dice_shows_a_field_near_the_best_and_says_how_far_it_is(panel, keep):
    add_ball(panel, 4)
    panel.run("active().synch.spacing = 0.4")
    best = solved(panel)["energy"]
    x, _, width, _ = panel.region()
    for throw in range(3):
        before = panel.value("active().synch_shown.variation")
        panel.click((x + width - 45, panel.wait_for("Variation")[1]))
        panel.until(f"{IDLE} and active().synch_shown.variation not in (0, {before})")
        panel.move((600, 500))  # the tooltip would lie over what it costs
        more = result(panel)["energy"] / best - 1
        assert more <= 0.05, throw
        panel.wait_for(panel.says("{more:+.1%} energy, against the best", more=more))
    keep("dice", panel.picture())
    drawn = panel.value("active().synch_shown.variation")
    panel.press("F9")
    panel.wait_for(str(drawn), "WINDOW")  # F9 says which one it is
    keep("dice_redo", panel.picture())
    panel.press("ESC")


def test_empties_follow_a_surface_that_is_bent_and_go_with_it(panel, keep):
    add_ball(panel, 4)
    solved(panel)
    panel.run(APART)
    panel.click("Empties")
    assert max(panel.value("apart()")) < 1e-4
    panel.run(
        "bend = active().modifiers.new('Bend', 'SIMPLE_DEFORM')\n"
        "bend.deform_method, bend.angle = 'BEND', 1.5\n"
        "bpy.context.view_layer.update()"
    )
    panel.until("max(apart()) < 1e-3")
    keep("empties_bent", panel.picture())
    panel.run("bpy.ops.ed.undo_push(message='bent')")
    panel.move((600, 500))
    panel.press("X")
    panel.press("RET")
    panel.until("not any(o.type == 'EMPTY' for o in bpy.data.objects)")


def test_curves_of_the_lines_are_outlined_at_once(panel, keep):
    add_ball(panel, 4)
    solved(panel)
    panel.scroll_to("Curves")
    panel.click("Curves")
    panel.until("[o.type for o in bpy.context.selected_objects if o != active()] == ['CURVE']")
    assert panel.value("active().type") == "MESH"  # the panel stays
    keep("curves", panel.picture())


def test_the_plain_look_is_a_picture_of_the_pattern(panel, keep):
    add_ball(panel, 4)
    solved(panel)
    pictures = []
    for kind, button in (("stripes", None), ("quads", "Quad Pattern")):
        if button:
            panel.run(f"active().synch_simple.kind = {kind!r}; area().tag_redraw()")
            panel.click(button)
            panel.until(f"{IDLE} and 'synch_phase_x' in active().data.attributes")
            panel.wait_for("Variation")
        panel.move((600, 500))
        panel.wait_to_see(lambda _: True, "UI", still=2)
        x, y = panel.wait_for("Look")
        left, bottom, _, height = panel.region()
        row = int(bottom + height - y)
        pictures.append(panel.picture("UI")[row + 25 : row + 115, int(x - left) : int(x - left) + 150].astype(int))
        keep(f"plain_{kind}", panel.picture("UI"))
    assert np.abs(pictures[0] - pictures[1]).mean() > 5
