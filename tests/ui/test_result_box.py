# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The box "Result" in a real window: the look, what is said of the mesh, and the defects that one click hides."""

from .test_solid_view import inked, is_inked
from .test_window import add_ball, figures, result, solved


def test_the_look_is_changed_and_a_changed_mesh_is_solved_again(panel, keep):
    add_ball(panel, 4)
    panel.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.8")
    solved(panel)
    half = inked(panel.wait_to_see(is_inked, "WINDOW"))
    panel.scroll_to("Width")
    width = panel.wait_for("Width")
    panel.move(width)
    panel.hold()
    for step in (10, 30, 50):
        panel.move(width - (step, 0))
    panel.release()
    assert panel.value("part('panels.look').look_of(active())[2]") < 0.4

    def is_thinner(picture):
        """thinner stripes"""
        return inked(picture) < 0.8 * half

    panel.wait_to_see(is_thinner, "WINDOW")
    keep("look", panel.picture())

    figures(panel, result(panel))
    panel.wait_for(panel.says("{length} apart on {count:,} faces", length="0.8 m", count=1280))
    panel.scroll_to("Empties", up=True)
    panel.until("all(not empty.visible_get() for empty in active().children)")  # the dots are there
    assert panel.value("len(active().children)") > 0
    panel.click("Empties")
    panel.until("all(empty.visible_get() for empty in active().children)")
    panel.click("Empties")
    panel.until("all(not empty.visible_get() for empty in active().children)")

    assert not panel.shows("Mesh Changed: Solve Again")
    panel.move((600, 500))  # off the button, whose tooltip would lie over the next row
    panel.run("active().data.vertices[0].co.x += 0.2; active().data.update()")
    panel.wait_for("Mesh Changed: Solve Again")
    keep("mesh_changed", panel.picture("UI"))
    before = panel.value("active().synch.result")
    panel.click("Mesh Changed: Solve Again")
    panel.until(f"part('jobs.queue').queue.running is None and active().synch.result != {before!r}")
    panel.until("not part('patterns.memory').is_outdated(active())")
    keep("result", panel.picture("UI"))
